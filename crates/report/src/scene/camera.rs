//! Projects the world to the picture.

use glam::DVec3;

/// A camera on a sphere around its target, y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Target of the camera, in metres.
    pub target_m: DVec3,
    /// Angle about the vertical, from the z axis to the x axis.
    pub yaw_rad: f64,
    /// Angle above the horizon.
    pub pitch_rad: f64,
    /// Distance to the target.
    pub distance_m: f64,
    /// Picture units per metre at a distance of one metre.
    pub focal: f64,
    /// Position of the target in the picture.
    pub center: [f64; 2],
}

/// A point in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Projected {
    /// Coordinate to the right.
    pub(super) x: f64,
    /// Coordinate downwards.
    pub(super) y: f64,
    /// Distance along the view, in metres.
    pub(super) depth_m: f64,
    /// Picture units per metre at that depth.
    pub(super) scale: f64,
}

impl Camera {
    /// Projects a point.
    pub(super) fn project(&self, point_m: DVec3) -> Projected {
        let (sin_yaw, cos_yaw) = libm::sincos(self.yaw_rad);
        let (sin_pitch, cos_pitch) = libm::sincos(self.pitch_rad);
        let towards = DVec3::new(cos_pitch * sin_yaw, sin_pitch, cos_pitch * cos_yaw);
        let right = DVec3::new(cos_yaw, 0.0, -sin_yaw);
        let up = towards.cross(right);
        let from_target = point_m - self.target_m;
        let depth_m = self.distance_m - from_target.dot(towards);
        // Limits the scale for points beside or behind the camera.
        let scale = self.focal / depth_m.max(self.distance_m / 60.0);
        let [x, y] = self.center;
        Projected {
            x: x + scale * from_target.dot(right),
            y: y - scale * from_target.dot(up),
            depth_m,
            scale,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_is_right_and_up_is_up() {
        let camera = Camera {
            target_m: DVec3::Y,
            yaw_rad: 0.0,
            pitch_rad: 0.0,
            distance_m: 4.0,
            focal: 400.0,
            center: [200.0, 100.0],
        };
        // Seen from +z, +x is on the right.
        let seen = camera.project(DVec3::new(1.0, 1.5, 0.0));
        assert!((seen.x - 300.0).abs() < 1e-9 && (seen.y - 50.0).abs() < 1e-9, "{seen:?}");
        assert!(camera.project(DVec3::new(0.0, 1.0, 1.0)).depth_m < seen.depth_m);
        let from_the_right = Camera { yaw_rad: core::f64::consts::FRAC_PI_2, ..camera };
        assert!(from_the_right.project(DVec3::new(0.0, 1.0, -1.0)).x > 200.0);
        let from_above = Camera { pitch_rad: 1.0, ..camera };
        assert!(from_above.project(DVec3::new(0.0, 1.0, 1.0)).y > 100.0);
    }
}
