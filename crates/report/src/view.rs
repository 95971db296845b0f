//! The camera and the ground of a playback.

use glam::DVec3;

use super::comparison::farthest;
use super::scene::{Ground, Mannequin, Points, feet_m, reach_m, side_view_rad};

/// The initial view of a playback.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    /// First frame.
    pub(super) frame: usize,
    /// Angle of the camera about the vertical from the z axis to the x axis.
    pub(super) yaw_rad: f64,
    /// Target of the camera; `None` if the camera follows the first point.
    pub(super) target_m: Option<DVec3>,
    /// Size of the scene: 1 m for a human with legs of 0.86 m.
    pub(super) size_m: f64,
    /// Distance of the camera in still pictures.
    pub(super) distance_m: f64,
    /// Ground of the scene.
    pub(super) ground: Ground,
}

impl View {
    /// Returns the view of a human figure: in its farthest reach, with a camera that follows it.
    pub(super) fn of_figure(mannequin: &Mannequin, frames: &[Points]) -> Self {
        let frame = farthest(frames.iter().map(|points| reach_m(points)));
        let lowest_m = frames.iter().map(|points| feet_m(points)).fold(f64::INFINITY, f64::min);
        Self {
            frame,
            yaw_rad: frames.get(frame).map_or(0.0, |points| side_view_rad(points)),
            target_m: None,
            size_m: mannequin.girth(),
            distance_m: 6.0,
            // The soles are a little lower than the points.
            ground: Ground::at(lowest_m - 0.03),
        }
    }

    /// Returns the view of any rig: in its pose farthest from the first pose, with the whole motion visible from
    /// every angle of the camera.
    pub(super) fn of_rig(mannequin: &Mannequin, frames: &[Points]) -> Self {
        /// Ratio of the size to the radius of a sphere around everything, which fits into every picture of the
        /// page.
        const SIZE: f64 = 0.84;
        let all = || frames.iter().flatten();
        let (low_m, high_m) = all()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| {
                (low.min(*at), high.max(*at))
            });
        let thick_m = mannequin.thickest_m();
        let target_m = if frames.is_empty() { DVec3::ZERO } else { 0.5 * (low_m + high_m) };
        let sphere_m = all().map(|at| at.distance(target_m)).fold(0.0, f64::max) + thick_m;
        let size_m = SIZE * sphere_m;
        let off_m2 = |points: &Points| -> f64 {
            points.iter().zip(&frames[0]).map(|(now, first)| now.distance_squared(*first)).sum()
        };
        // Not near the end, to leave a part to play.
        let frame = farthest(frames.iter().take(frames.len() * 3 / 4).map(off_m2));
        Self {
            frame,
            yaw_rad: frames.get(frame).map_or(0.0, |points| three_quarter_rad(points)),
            target_m: Some(target_m),
            size_m,
            distance_m: 6.0 * size_m,
            ground: Ground::of_size(low_m.y.min(target_m.y) - thick_m, size_m),
        }
    }
}

/// Returns the direction from which points are seen with their greatest breadth, and a little turned: the angle
/// about the vertical from the z axis to the x axis, on the side of the x axis.
fn three_quarter_rad(points: &[DVec3]) -> f64 {
    /// Turn from the exact direction, in which the scene looks flat.
    const TURN_RAD: f64 = 0.5;
    let middle_m = points.iter().sum::<DVec3>() / points.len() as f64;
    let [mut xx, mut xz, mut zz] = [0.0; 3];
    for off in points.iter().map(|point| *point - middle_m) {
        xx += off.x * off.x;
        xz += off.x * off.z;
        zz += off.z * off.z;
    }
    // Direction of the greatest breadth, from the x axis to the z axis.
    let breadth_rad = 0.5 * libm::atan2(2.0 * xz, xx - zz);
    let across = DVec3::new(-libm::sin(breadth_rad), 0.0, libm::cos(breadth_rad));
    let across = if across.x < 0.0 { -across } else { across };
    libm::atan2(across.x, across.z) - TURN_RAD
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::fixture::arm;

    /// Returns frames of a bowing arm, scaled by `scale`.
    fn bows(scale: f64) -> (Mannequin, Vec<Points>) {
        let mut arm = arm();
        for link in &mut arm.bodies {
            (link.position_m, link.center_of_mass_m) =
                (link.position_m * scale, link.center_of_mass_m * scale);
        }
        let mannequin = Mannequin::of_rig(&arm);
        let pose = |step: i32| arm.poses(&[0.0, f64::from(step) * 0.3, 0.0, 0.0, 0.0, 0.0]);
        let frames = [0, 1, 2, 3, 2, 1].map(|step| mannequin.points(&pose(step)));
        (mannequin, frames.to_vec())
    }

    #[test]
    fn a_rig_is_seen_in_its_farthest_pose_and_stands_on_the_ground() {
        let (mannequin, frames) = bows(1.0);
        let view = View::of_rig(&mannequin, &frames);
        assert_eq!(view.frame, 3);
        assert!((-0.05..0.0).contains(&view.ground.height_m), "{:?}", view.ground);
        assert!((0.2..0.6).contains(&view.size_m), "an arm of 0.68 m: {}", view.size_m);
        // It bows in the plane of y and z: the view is along x, and a little turned.
        assert!((0.8..1.3).contains(&view.yaw_rad), "{}", view.yaw_rad);
    }

    #[test]
    fn a_view_is_of_the_size_of_the_rig() {
        let ((small, of_small), (large, of_large)) = (bows(0.05), bows(20.0));
        let (near, far) = (View::of_rig(&small, &of_small), View::of_rig(&large, &of_large));
        assert!((far.size_m / near.size_m - 400.0).abs() < 1e-6);
        assert!((far.distance_m / near.distance_m - 400.0).abs() < 1e-6);
        assert!((far.yaw_rad - near.yaw_rad).abs() < 1e-9);
    }
}
