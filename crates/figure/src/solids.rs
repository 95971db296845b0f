//! Solids of uniform density for body segments.
//!
//! The longitudinal axis is z. Hanavan (AMRL-TR-64-102, 1964) and Kwon: elliptical solids and ellipsoids; Yeadon
//! (J. Biomech. 23, 1990, 67-74): stadium solids.

use core::f64::consts::PI;

use glam::DVec3;

/// Volume, centre of mass and inertia of a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solid {
    /// Volume in m³.
    pub volume_m3: f64,
    /// Centre of mass along z, from the "0" end (for an ellipsoid: from its centre), in metres.
    pub center_z_m: f64,
    /// Principal moments of inertia over mass about the centre of mass, about x, y and z, in m².
    pub inertia_over_mass_m2: DVec3,
}

/// Cross-section: its area, and the integrals of x² and y² over it.
struct Section {
    area: f64,
    x2: f64,
    y2: f64,
}

/// Returns nodes and weights of Gauss's rule with 3 points on 0 to 1, exact to degree 5. The integrands are of
/// degree 4 in s, or of degree 2 times s²: the result is exact.
fn gauss() -> [(f64, f64); 3] {
    let d = libm::sqrt(0.15);
    [(0.5 - d, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.5 + d, 5.0 / 18.0)]
}

fn lofted(length_m: f64, section: impl Fn(f64) -> Section) -> Solid {
    let slices = gauss().map(|(s, weight)| (s * length_m, weight, section(s)));
    let mean = |f: &dyn Fn(f64, &Section) -> f64| -> f64 {
        slices.iter().map(|(z, weight, section)| weight * f(*z, section)).sum()
    };
    let area = mean(&|_, section| section.area);
    let center_z_m = mean(&|z, section| z * section.area) / area;
    let x2 = mean(&|_, section| section.x2) / area;
    let y2 = mean(&|_, section| section.y2) / area;
    let z2 = mean(&|z, section| (z - center_z_m) * (z - center_z_m) * section.area) / area;
    Solid {
        volume_m3: area * length_m,
        center_z_m,
        inertia_over_mass_m2: DVec3::new(y2 + z2, x2 + z2, x2 + y2),
    }
}

fn between([start, end]: [f64; 2], s: f64) -> f64 {
    start + (end - start) * s
}

/// Returns an elliptical solid: semi-axes a along x and b along y, linear from the "0" end to the opposite end, in
/// metres.
pub fn elliptical_solid(a_m: [f64; 2], b_m: [f64; 2], length_m: f64) -> Solid {
    lofted(length_m, |s| {
        let (a, b) = (between(a_m, s), between(b_m, s));
        let area = PI * a * b;
        Section { area, x2: area * a * a / 4.0, y2: area * b * b / 4.0 }
    })
}

/// Returns a truncated circular cone from the radii of the "0" end and the opposite end, in metres.
pub fn truncated_cone(radius_m: [f64; 2], length_m: f64) -> Solid {
    elliptical_solid(radius_m, radius_m, length_m)
}

/// Returns an elliptical column with semi-axes a along x and b along y, in metres.
pub fn elliptical_column(a_m: f64, b_m: f64, length_m: f64) -> Solid {
    elliptical_solid([a_m; 2], [b_m; 2], length_m)
}

/// Returns a stadium solid: half thickness t along x between half discs of radius r, both linear along z, in
/// metres.
pub fn stadium_solid(t_m: [f64; 2], r_m: [f64; 2], length_m: f64) -> Solid {
    lofted(length_m, |s| {
        let (t, r) = (between(t_m, s), between(r_m, s));
        let (r2, r3) = (r * r, r * r * r);
        Section {
            area: 4.0 * t * r + PI * r2,
            x2: 4.0 * r * t * t * t / 3.0
                + PI * r2 * t * t
                + 8.0 * r3 * t / 3.0
                + PI * r2 * r2 / 4.0,
            y2: 4.0 * t * r3 / 3.0 + PI * r2 * r2 / 4.0,
        }
    })
}

/// Returns an ellipsoid with these semi-axes along x, y and z, in metres.
pub fn ellipsoid(a_m: f64, b_m: f64, c_m: f64) -> Solid {
    let (a2, b2, c2) = (a_m * a_m, b_m * b_m, c_m * c_m);
    Solid {
        volume_m3: 4.0 / 3.0 * PI * a_m * b_m * c_m,
        center_z_m: 0.0,
        inertia_over_mass_m2: DVec3::new(b2 + c2, c2 + a2, a2 + b2) / 5.0,
    }
}

/// Returns half an ellipsoid of revolution from the radius of its base, which is the "0" end, and its height, in
/// metres.
pub fn semi_ellipsoid(radius_m: f64, height_m: f64) -> Solid {
    let r2 = radius_m * radius_m;
    let across = r2 / 5.0 + 19.0 / 320.0 * height_m * height_m;
    Solid {
        volume_m3: 2.0 / 3.0 * PI * r2 * height_m,
        center_z_m: 0.375 * height_m,
        inertia_over_mass_m2: DVec3::new(across, across, 0.4 * r2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that two halves of a sphere make a sphere (parallel axes).
    #[test]
    fn semi_ellipsoids_make_an_ellipsoid() {
        let (half, whole) = (semi_ellipsoid(0.1, 0.2), ellipsoid(0.1, 0.1, 0.2));
        let away = half.center_z_m * half.center_z_m;
        let sum = half.inertia_over_mass_m2 + DVec3::new(away, away, 0.0);
        assert!((2.0 * half.volume_m3 / whole.volume_m3 - 1.0).abs() < 1e-14);
        assert!(sum.abs_diff_eq(whole.inertia_over_mass_m2, 1e-16));
    }

    #[test]
    fn a_column_and_a_cone_have_their_closed_forms() {
        let (a, b, l) = (0.2, 0.1, 0.5);
        let column = elliptical_column(a, b, l).inertia_over_mass_m2.x;
        assert!((column - (b * b / 4.0 + l * l / 12.0)).abs() < 1e-16);
        let (p, q) = (0.07_f64, 0.04_f64);
        let sum = p * p + p * q + q * q;
        let cone = truncated_cone([p, q], l);
        assert!((cone.volume_m3 / (PI * l * sum / 3.0) - 1.0).abs() < 1e-14);
        let center = l * (p * p + 2.0 * p * q + 3.0 * q * q) / (4.0 * sum);
        assert!((cone.center_z_m / center - 1.0).abs() < 1e-14);
    }
}
