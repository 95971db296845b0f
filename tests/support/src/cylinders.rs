//! Surface integrals of cylinders in f64, by another method than the core's: the integral along the axis is analytic.
//! The integral around the axis uses the double exponential rule (Takahasi and Mori 1974), which tolerates the
//! singularity of a point on the surface.

use glam::DVec3;

/// Returns the integral of `|x - point|` over the lateral surface of a cylinder, in m³.
pub fn distance_integral_m3(start_m: DVec3, end_m: DVec3, radius_m: f64, point_m: DVec3) -> f64 {
    let (length_m, from_start_m) = (start_m.distance(end_m), point_m - start_m);
    if length_m == 0.0 {
        return 0.0;
    }
    let axis = (end_m - start_m) / length_m;
    let foot_m = from_start_m.dot(axis);
    let beside_m = (from_start_m - axis * foot_m).length();
    let along = |angle: f64| {
        let chord_m2 = 4.0 * beside_m * radius_m * (0.5 * angle).sin().powi(2);
        let off_axis_m2 = (beside_m - radius_m).powi(2) + chord_m2;
        antiderivative(length_m - foot_m, off_axis_m2) - antiderivative(-foot_m, off_axis_m2)
    };
    2.0 * radius_m * from_zero_to_pi(along)
}

/// Returns the antiderivative of `√(x² + c)`.
fn antiderivative(x: f64, c: f64) -> f64 {
    let logarithm = if c > 0.0 { (x / c.sqrt()).asinh() } else { 0.0 };
    0.5 * (x * (x * x + c).sqrt() + c * logarithm)
}

fn from_zero_to_pi(function: impl Fn(f64) -> f64) -> f64 {
    use std::f64::consts::{FRAC_PI_2, PI};
    let step = 1.0 / 32.0;
    let term = |k: i32| {
        let t = step * f64::from(k);
        let u = FRAC_PI_2 * t.sinh();
        // π (1 + tanh u) / 2, written so that digits near 0 are exact.
        let angle = PI / (1.0 + (-2.0 * u).exp());
        function(angle) * FRAC_PI_2 * t.cosh() * FRAC_PI_2 / u.cosh().powi(2)
    };
    step * (-110..=110).map(term).sum::<f64>()
}
