//! Conversion of velocities and moments to those of rotation vectors, by the right Jacobian of SO(3).

use sinew_core::glam::Vec3;
use sinew_core::math;

use super::numbers::{Numbers, collect};
use crate::limited::LimitReason;

/// The right Jacobian `J` at a rotation vector φ of at most 180 deg: `ω = J φ̇`, with ω in body axes.
///
/// `J = 1 - a [φ]× + b [φ]×²`, `J⁻¹ = 1 + [φ]×/2 + c [φ]×²` (Chirikjian 2011), and `[φ]×` changes its sign in the
/// transposes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RightJacobian {
    vector: Vec3,
    a: f32,
    b: f32,
    c: f32,
}

impl RightJacobian {
    pub(super) fn at(rotation_vector: &[f32]) -> Self {
        let vector = vec3(rotation_vector);
        let squared = vector.dot(vector);
        let (b, c) = if squared < 1.0 {
            // A series, because the closed form subtracts nearly equal numbers. The truncation error is below
            // 2e-10.
            let series = |coefficients: [f32; 5]| {
                coefficients.into_iter().rev().fold(0.0, |sum, next| next + squared * sum)
            };
            (
                series([
                    1.0 / 6.0,
                    -1.0 / 120.0,
                    1.0 / 5040.0,
                    -1.0 / 362_880.0,
                    1.0 / 39_916_800.0,
                ]),
                series([
                    1.0 / 12.0,
                    1.0 / 720.0,
                    1.0 / 30240.0,
                    1.0 / 1_209_600.0,
                    1.0 / 47_900_160.0,
                ]),
            )
        } else {
            let angle = math::sqrt(squared);
            let half = 0.5 * angle;
            let (half_sine, half_cosine) = math::sin_cos(half);
            let sine = 2.0 * half_sine * half_cosine;
            ((angle - sine) / (angle * squared), (1.0 - half * half_cosine / half_sine) / squared)
        };
        let half = 0.5 * math::sqrt(squared);
        let (sine, _) = math::sin_cos(half);
        let ratio = if half > 1e-3 { sine / half } else { 1.0 - half * half / 6.0 };
        Self { vector, a: 0.5 * ratio * ratio, b, c }
    }

    /// Returns `J φ̇`.
    pub(super) fn velocities_of(&self, rates: &[f32]) -> Numbers {
        self.apply(rates, -self.a, self.b)
    }

    /// Returns `J⁻¹ ω`.
    pub(super) fn rates_of(&self, velocities: &[f32]) -> Numbers {
        self.apply(velocities, 0.5, self.c)
    }

    /// Returns `Jᵀ` times a moment in body axes: the moment that does the same work on φ̇.
    pub(super) fn moments_of_rates(&self, of_body: &[f32]) -> Numbers {
        self.apply(of_body, self.a, self.b)
    }

    /// Returns `J⁻ᵀ` times a moment on φ̇: the moment in body axes.
    pub(super) fn moments_of_body(&self, of_rates: &[f32]) -> Numbers {
        self.apply(of_rates, -0.5, self.c)
    }

    fn apply(&self, numbers: &[f32], of_cross: f32, of_twice: f32) -> Numbers {
        let v = vec3(numbers);
        let cross = self.vector.cross(v);
        let turned = v + cross * of_cross + self.vector.cross(cross) * of_twice;
        collect(turned.to_array())
    }
}

/// Limits a rotation vector to 180 deg. A longer vector is shortened, because the same pose has a shorter vector in
/// the opposite direction, and servos would jump to that.
pub(super) fn within_half_a_turn(rotation_vector: Numbers) -> (Numbers, Option<LimitReason>) {
    let length = math::length(vec3(&rotation_vector));
    // Tolerance for the rounding of a logarithm of 180 deg.
    if length <= math::PI * (1.0 + 4.0 * f32::EPSILON) {
        return (rotation_vector, None);
    }
    let share = math::PI / length;
    (collect(rotation_vector.iter().map(|x| x * share)), Some(LimitReason::Range))
}

fn vec3(numbers: &[f32]) -> Vec3 {
    match numbers {
        [x, y, z] => Vec3::new(*x, *y, *z),
        // Not reached: three numbers were counted.
        _ => Vec3::ZERO,
    }
}
