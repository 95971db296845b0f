//! Elementary functions of rotations with the operations of `sinew_core::math`, whose usual case has no branch.

use glam::{Quat, Vec3};
use sinew_core::math;

use crate::lanes::{Rotations, Vectors};

/// Returns the logarithms of rotations.
#[inline(always)]
pub(crate) fn logs<const L: usize>(turns: &Rotations<L>) -> Vectors<L> {
    let mut out = Vectors::ZERO;
    let mut are_near = true;
    for lane in 0..L {
        let (log, is_near) = near_log(turns.at(lane));
        out.set(lane, log);
        are_near &= is_near;
    }
    if !are_near {
        for lane in 0..L {
            out.set(lane, math::log(turns.at(lane)));
        }
    }
    out
}

/// Normalizes rotations.
#[inline(always)]
pub(crate) fn normalize<const L: usize>(rotations: &mut Rotations<L>) {
    let given = *rotations;
    let mut are_near = true;
    for lane in 0..L {
        let (unit, is_near) = near_unit(given.at(lane));
        rotations.set(lane, unit);
        are_near &= is_near;
    }
    if !are_near {
        for lane in 0..L {
            rotations.set(lane, math::unit(given.at(lane)));
        }
    }
}

/// Computes the polynomial of `math::log` for angles up to an eighth of a turn, and whether `math::log` uses it.
#[inline(always)]
fn near_log(q: Quat) -> (Vec3, bool) {
    let v = Vec3::new(q.x, q.y, q.z);
    let squared = v.dot(v);
    let reciprocal = 1.0 / q.w;
    let scale = 2.0 * reciprocal * arctangent_over_tangent(squared * (reciprocal * reciprocal));
    (v * scale, squared <= (EIGHTH_TAN * EIGHTH_TAN) * (q.w * q.w))
}

/// Computes `math::log` of a rotation of any angle, without a branch.
#[inline(always)]
pub(crate) fn any_log(q: Quat) -> Vec3 {
    let v = Vec3::new(q.x, q.y, q.z);
    let (up_squared, along) = (v.dot(v), q.w.abs());
    // Beyond an eighth of a turn, the factor is 2 atan2(|v|, |w|) / |v|, by the operations of `math::atan2`.
    let up = up_squared.sqrt();
    let (half_up, half_along) = (0.5 * up, 0.5 * along);
    let is_low = up <= EIGHTH_TAN * along;
    let is_high = along <= EIGHTH_TAN * up;
    let above = select(is_low, up, select(is_high, -along, half_up - half_along));
    let below = select(is_low, along, select(is_high, up, half_up + half_along));
    let eighth = select(is_low, 0.0, select(is_high, 0.5 * math::PI, 0.25 * math::PI));
    let ratio = above / below;
    let angle = eighth + ratio * arctangent_over_tangent(ratio * ratio);
    let scale = 2.0 * angle / up;
    let far = select(q.w < 0.0, -scale, scale);

    let reciprocal = 1.0 / q.w;
    let squared = up_squared * (reciprocal * reciprocal);
    let near = 2.0 * reciprocal * arctangent_over_tangent(squared);
    v * select(up_squared <= (EIGHTH_TAN * EIGHTH_TAN) * (q.w * q.w), near, far)
}

/// Returns the first number if the condition holds, otherwise the second. The compiler would turn a conditional
/// expression into a branch.
#[inline(always)]
pub(crate) fn select(condition: bool, first: f32, second: f32) -> f32 {
    // All ones or zero.
    let mask = u32::from(condition).wrapping_neg();
    f32::from_bits(first.to_bits() & mask | second.to_bits() & !mask)
}

/// tan(π/8): up to this tangent of half the angle, `math::log` uses a polynomial.
const EIGHTH_TAN: f32 = 0.414_213_57;

/// Computes the polynomial of `math::atan2` for `atan(t) / t` as a function of t².
#[inline(always)]
fn arctangent_over_tangent(z: f32) -> f32 {
    1.0 + z
        * (-0.333_333_2
            + z * (0.199_985_33 + z * (-0.142_429_72 + z * (0.105_814_99 - z * 0.060_332_76))))
}

/// Computes the polynomial of `math::exp` for `sin(x) / x` as a function of x².
#[inline(always)]
pub(crate) fn sine_over_angle(y: f32) -> f32 {
    1.0 + y * (-0.166_666_55 + y * (0.008_332_1 - y * 1.950_396_4e-4))
}

/// Computes the polynomial of `math::exp` for `cos(x)` as a function of x².
#[inline(always)]
pub(crate) fn cosine_of_root(y: f32) -> f32 {
    1.0 - y * (0.5 - y * (0.041_666_653 + y * (-0.001_388_765_4 + y * 2.446_383_4e-5)))
}

/// Computes the series of `math::unit`, and whether `math::unit` uses it.
#[inline(always)]
pub(crate) fn near_unit(q: Quat) -> (Quat, bool) {
    let excess = q.dot(q) - 1.0;
    (q + q * (excess * (0.375 * excess - 0.5)), excess.abs() < 2e-3)
}
