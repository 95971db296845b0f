//! Elementary functions, and the rotation maps built on them.
//!
//! No other part of Sinew's core calls `libm`. A single module decides how a function is computed, which gives equal
//! bits on a PC and a Cortex-M4F.

use glam::{Quat, Vec3};

/// The number π.
pub const PI: f32 = core::f32::consts::PI;

/// Returns the square root, correctly rounded.
///
/// ```
/// assert_eq!(sinew_core::math::sqrt(2.25), 1.5);
/// ```
#[inline]
pub fn sqrt(x: f32) -> f32 {
    sinew_fpu::sqrt(x)
}

/// Returns sine and cosine of an angle in radians, with an error below 1e-7 for angles up to 8192 rad. For larger
/// angles the error is up to half a unit in the last place of the angle.
///
/// ```
/// assert_eq!(sinew_core::math::sin_cos(0.0), (0.0, 1.0));
/// ```
pub fn sin_cos(angle_rad: f32) -> (f32, f32) {
    // From 8192 rad on, the products with the parts of π/2 below are no longer exact.
    let angle = if angle_rad.abs() < 8192.0 { angle_rad } else { libm::fmodf(angle_rad, 2.0 * PI) };
    let turns = angle * (2.0 / PI);
    #[expect(
        clippy::cast_possible_truncation,
        reason = "below 8192 in size, or NaN, which turns to 0"
    )]
    let quarters = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i16;
    let k = f32::from(quarters);
    // π/2 in three parts; the first two are short enough for exact products (Cody and Waite 1980).
    let rest = ((angle - k * 1.570_312_5) - k * 4.837_513e-4) - k * 7.549_79e-8;
    let squared = rest * rest;
    let (sine, cosine) = (rest * sine_over_angle(squared), cosine_of_root(squared));
    match quarters & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Returns the angle in radians of the point `(x, y)`, in [-π, π], with a relative error below 2.4e-7. The result is
/// 0 for the origin, NaN if both are infinite.
///
/// ```
/// assert_eq!(sinew_core::math::atan2(0.0, 1.0), 0.0);
/// ```
pub fn atan2(y: f32, x: f32) -> f32 {
    let (up, along) = (y.abs(), x.abs());
    // Halved, so that the sum does not overflow.
    let (eighth, ratio) = if up <= EIGHTH_TAN * along {
        (0.0, if along > 0.0 { up / along } else { 0.0 })
    } else if along <= EIGHTH_TAN * up {
        (0.5 * PI, -along / up)
    } else {
        let sum = 0.5 * up + 0.5 * along;
        // The halves of the smallest numbers may be zero.
        (0.25 * PI, if sum == 0.0 { 0.0 } else { (0.5 * up - 0.5 * along) / sum })
    };
    let angle = eighth + ratio * arctangent_over_tangent(ratio * ratio);
    let angle = if x < 0.0 { PI - angle } else { angle };
    if y < 0.0 { -angle } else { angle }
}

/// tan(π/8): the polynomial of the arctangent is accurate up to this ratio.
const EIGHTH_TAN: f32 = 0.414_213_57;

// The polynomials are minimax approximations of the relative error, computed by Remez' exchange algorithm in 40
// digits and rounded to f32. The truncation error is below 7e-9 of the value: a ninth of f32's rounding.

/// Returns `atan(t) / t` as a function of `t²` in [0, tan²(π/8)].
#[inline]
fn arctangent_over_tangent(z: f32) -> f32 {
    1.0 + z
        * (-0.333_333_2
            + z * (0.199_985_33 + z * (-0.142_429_72 + z * (0.105_814_99 - z * 0.060_332_76))))
}

/// Returns `sin(x) / x` as a function of `x²` in [0, (π/4)²].
#[inline]
fn sine_over_angle(y: f32) -> f32 {
    1.0 + y * (-0.166_666_55 + y * (0.008_332_1 - y * 1.950_396_4e-4))
}

/// Returns `cos(x)` as a function of `x²` in [0, (π/4)²].
#[inline]
fn cosine_of_root(y: f32) -> f32 {
    1.0 - y * (0.5 - y * (0.041_666_653 + y * (-0.001_388_765_4 + y * 2.446_383_4e-5)))
}

/// Returns `eˣ`. [`exp`] is the map of rotation vectors.
///
/// ```
/// assert_eq!(sinew_core::math::exponential(0.0), 1.0);
/// ```
#[inline]
pub fn exponential(x: f32) -> f32 {
    libm::expf(x)
}

/// Returns the natural logarithm of a number above 0. [`log`] is the map of rotations.
///
/// ```
/// assert_eq!(sinew_core::math::logarithm(1.0), 0.0);
/// ```
#[inline]
pub fn logarithm(x: f32) -> f32 {
    libm::logf(x)
}

/// Returns the nearest whole number; if two are equally near, the even one.
pub(crate) fn round(x: f32) -> f32 {
    libm::rintf(x)
}

/// Returns zero if all components are finite, else NaN. A single comparison of a sum then checks many vectors.
#[inline]
pub(crate) fn zero_of_numbers(v: Vec3) -> f32 {
    v.dot(Vec3::ZERO)
}

/// Returns `true` if all components are finite.
#[inline]
pub(crate) fn is_finite(v: Vec3) -> bool {
    zero_of_numbers(v) == 0.0
}

/// Returns the length of a vector.
///
/// ```
/// # use sinew_core::{glam::Vec3, math};
/// assert_eq!(math::length(Vec3::new(3.0, 4.0, 0.0)), 5.0);
/// ```
#[inline]
pub fn length(v: Vec3) -> f32 {
    sqrt(v.dot(v))
}

/// Returns a vector rotated by a unit quaternion.
///
/// ```
/// # use sinew_core::{glam::{Quat, Vec3}, math};
/// let half_turn = Quat::from_xyzw(0.0, 0.0, 1.0, 0.0);
/// assert_eq!(math::rotate(half_turn, Vec3::X), -Vec3::X);
/// ```
#[inline]
pub fn rotate(q: Quat, v: Vec3) -> Vec3 {
    // v + w t + a × t with t = 2 a × v, where a is the vector part.
    let a = Vec3::new(q.x, q.y, q.z);
    let t = a.cross(v + v);
    plus_cross(v + t * q.w, a, t)
}

/// Returns the rotation from one orientation to another in the axes of the rotating body, `from⁻¹ to`. For equal
/// orientations the products cancel in pairs, and the result is exactly no rotation.
///
/// ```
/// # use sinew_core::{glam::Vec3, math};
/// let tipped = math::exp(Vec3::X * 1.2);
/// let turned = tipped * math::exp(Vec3::Y * 0.3);
/// let turn = math::log(math::turn_in_body(tipped, turned));
/// assert!((turn - Vec3::Y * 0.3).length() < 1e-6);
/// assert_eq!(math::log(math::turn_in_body(tipped, tipped)), Vec3::ZERO);
/// ```
#[inline]
pub fn turn_in_body(from: Quat, to: Quat) -> Quat {
    let (a, b) = (from, to);
    Quat::from_xyzw(
        a.w * b.x - a.x * b.w - a.y * b.z + a.z * b.y,
        a.w * b.y - a.y * b.w - a.z * b.x + a.x * b.z,
        a.w * b.z - a.z * b.w - a.x * b.y + a.y * b.x,
        a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z,
    )
}

/// Returns the rotation like [`turn_in_body`], but in the frame in which both orientations are given: `to from⁻¹`.
///
/// ```
/// # use sinew_core::{glam::Vec3, math};
/// let tipped = math::exp(Vec3::X * 1.2);
/// let turned = math::exp(Vec3::Y * 0.3) * tipped;
/// let turn = math::log(math::turn_in_world(tipped, turned));
/// assert!((turn - Vec3::Y * 0.3).length() < 1e-6);
/// ```
#[inline]
pub fn turn_in_world(from: Quat, to: Quat) -> Quat {
    let (a, b) = (from, to);
    Quat::from_xyzw(
        a.w * b.x - a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.y * b.w + a.z * b.x - a.x * b.z,
        a.w * b.z - a.z * b.w + a.x * b.y - a.y * b.x,
        a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z,
    )
}

/// Returns a rotation followed by a half turn about a unit axis of the rotated body.
#[inline]
pub(crate) fn turned_half(rotation: Quat, axis: Vec3) -> Quat {
    let a = Vec3::new(rotation.x, rotation.y, rotation.z);
    let v = plus_cross(axis * rotation.w, a, axis);
    Quat::from_xyzw(v.x, v.y, v.z, -a.dot(axis))
}

/// Returns `sum + a × b`, added product by product: each is a single instruction on CPUs with multiply-add.
///
/// ```
/// # use sinew_core::{glam::Vec3, math};
/// assert_eq!(math::plus_cross(Vec3::ONE, Vec3::X, Vec3::Y), Vec3::new(1.0, 1.0, 2.0));
/// ```
#[inline]
pub fn plus_cross(sum: Vec3, a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(
        sum.x + a.y * b.z - a.z * b.y,
        sum.y + a.z * b.x - a.x * b.z,
        sum.z + a.x * b.y - a.y * b.x,
    )
}

/// Returns the unit quaternion in the direction of `q`. The result is the identity if the squared length of `q` is
/// below 1.2e-38 (it then has too few digits), infinite or NaN.
///
/// ```
/// # use sinew_core::{glam::Quat, math};
/// let q = math::unit(Quat::from_xyzw(0.0, 0.0, 2.0, 0.0));
/// assert_eq!(q, Quat::from_xyzw(0.0, 0.0, 1.0, 0.0));
/// ```
#[inline]
pub fn unit(q: Quat) -> Quat {
    let squared = q.dot(q);
    let excess = squared - 1.0;
    if excess.abs() < 2e-3 {
        // The series of 1/√squared, as a correction to add: a factor next to 1 would have too few digits.
        q + q * (excess * (0.375 * excess - 0.5))
    } else if squared.is_normal() {
        q * (1.0 / sqrt(squared))
    } else {
        Quat::IDENTITY
    }
}

/// Tolerance for the length of an axis or a quaternion: deviation from 1.
///
/// Configuration files have about six digits; a larger deviation is a mistake, not rounding.
pub(crate) const UNIT_TOLERANCE: f32 = 1e-3;

/// Returns `true` if a quaternion is a rotation: its length is 1 within [`UNIT_TOLERANCE`]. NaN and overflow give
/// `false`.
#[inline]
pub(crate) fn is_unit(q: Quat) -> bool {
    (q.dot(q) - 1.0).abs() <= 2.0 * UNIT_TOLERANCE
}

/// Returns the twist of a rotation about a unit axis, without the swing, as a unit quaternion. Returns the identity
/// if the rotation is a half turn about a perpendicular axis.
#[inline]
pub(crate) fn twist_about(axis: Vec3, rotation: Quat) -> Quat {
    let Quat { x, y, z, w } = rotation;
    let along = axis * axis.dot(Vec3::new(x, y, z));
    unit(Quat::from_xyzw(along.x, along.y, along.z, w))
}

/// Returns the angle of [`twist_about`] in rad, in [-π, π].
pub(crate) fn turn_about(axis: Vec3, rotation: Quat) -> f32 {
    let q = if rotation.w < 0.0 { -rotation } else { rotation };
    2.0 * atan2(Vec3::new(q.x, q.y, q.z).dot(axis), q.w)
}

/// Logarithm map: returns the rotation vector (axis times angle, angle in [0, π]) of a unit quaternion.
///
/// `q` and `-q` are the same rotation and give the same vector. At an angle of exactly π, both axes are valid; the
/// sign of `q` selects the axis. If `q` is not unit, the result may be NaN.
///
/// ```
/// # use sinew_core::{glam::{Quat, Vec3}, math};
/// let half_turn = Quat::from_xyzw(0.0, 1.0, 0.0, 0.0);
/// assert_eq!(math::log(half_turn), Vec3::new(0.0, math::PI, 0.0));
/// assert_eq!(math::log(-Quat::IDENTITY), Vec3::ZERO);
/// ```
#[inline]
pub fn log(q: Quat) -> Vec3 {
    let v = Vec3::new(q.x, q.y, q.z);
    v * log_scale(v.dot(v), q.w)
}

/// Returns the factor from the vector part of a unit quaternion to its logarithm. `squared` is the squared length
/// of the vector part.
///
/// Never inlined, because it is large. Arguments and result are single numbers, which pass in registers; a quaternion
/// would go through memory.
#[inline(never)]
fn log_scale(squared: f32, w: f32) -> f32 {
    if squared <= (EIGHTH_TAN * EIGHTH_TAN) * (w * w) {
        // Up to an eighth of a turn, with t = tan(angle / 2) = |v| / w: (2 / w) atan(t) / t, without a square root.
        let reciprocal = 1.0 / w;
        2.0 * reciprocal * arctangent_over_tangent(squared * (reciprocal * reciprocal))
    } else {
        let s = sqrt(squared);
        let scale = 2.0 * atan2(s, w.abs()) / s;
        if w < 0.0 { -scale } else { scale }
    }
}

/// Exponential map: returns the unit quaternion of a rotation vector; inverse of [`log`].
///
/// The result is NaN if a component is NaN, or the square of the length overflows f32 (3.6e19 rad).
///
/// ```
/// # use sinew_core::{glam::Vec3, math};
/// let v = Vec3::new(0.3, -0.2, 0.9);
/// assert!((math::log(math::exp(v)) - v).abs().max_element() < 1e-6);
/// ```
pub fn exp(rotation_vector_rad: Vec3) -> Quat {
    let v = rotation_vector_rad * 0.5;
    let (scale, w) = sine_over_angle_and_cosine_of(v.dot(v));
    let v = v * scale;
    Quat::from_xyzw(v.x, v.y, v.z, w)
}

/// Returns sine and cosine of half an angle: [`exp`] of a rotation about a unit axis is `(axis sine, cosine)`.
#[inline]
pub(crate) fn half_sin_cos(angle_rad: f32) -> (f32, f32) {
    let half = angle_rad * 0.5;
    let (scale, cosine) = sine_over_angle_and_cosine_of(half * half);
    (half * scale, cosine)
}

/// Returns `sin(x) / x` and `cos(x)` as functions of x².
#[inline]
fn sine_over_angle_and_cosine_of(squared: f32) -> (f32, f32) {
    if squared <= (0.25 * PI) * (0.25 * PI) {
        (sine_over_angle(squared), cosine_of_root(squared))
    } else {
        let half_angle = sqrt(squared);
        let (sine, cosine) = sin_cos(half_angle);
        (sine / half_angle, cosine)
    }
}

/// Interpolates two rotations along the shorter way with constant angular velocity: `a` at 0, `b` at 1 (slerp).
///
/// The result is unit for unit quaternions and any finite `t` below 1e18.
///
/// ```
/// # use sinew_core::{glam::{Quat, Vec3}, math};
/// let quarter = math::exp(Vec3::new(0.0, 0.0, 1.0));
/// let half_way = math::slerp(Quat::IDENTITY, quarter, 0.5);
/// assert!((math::log(half_way).z - 0.5).abs() < 1e-6);
/// ```
pub fn slerp(a: Quat, b: Quat, t: f32) -> Quat {
    unit(a * exp(log(a.conjugate() * b) * t))
}

/// Four numbers for the same operation. Compilers turn these into vector instructions if the CPU has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Four([f32; 4]);

impl Four {
    pub(crate) const ZERO: Self = Self::all(0.0);
    pub(crate) const ONE: Self = Self::all(1.0);

    #[inline]
    pub(crate) const fn all(x: f32) -> Self {
        Self([x; 4])
    }

    #[inline]
    pub(crate) fn from_fn(number: impl Fn(u16) -> f32) -> Self {
        Self([0, 1, 2, 3].map(number))
    }

    #[inline]
    pub(crate) fn first(self) -> f32 {
        self.0[0]
    }

    #[inline]
    pub(crate) fn last(self) -> f32 {
        self.0[3]
    }

    /// Returns the numbers shifted by one: `before` and the first three.
    #[inline]
    pub(crate) fn after(self, before: f32) -> Self {
        let [a, b, c, _] = self.0;
        Self([before, a, b, c])
    }

    /// Returns the sum of the square roots.
    #[inline]
    pub(crate) fn sqrt_sum(self) -> f32 {
        let [a, b, c, d] = self.0.map(sqrt);
        a + b + c + d
    }
}

/// Implements an operator on each of four pairs.
macro_rules! by_number {
    ($operation:ident, $name:ident, $sign:tt) => {
        impl core::ops::$operation for Four {
            type Output = Self;

            #[inline]
            fn $name(self, other: Self) -> Self {
                let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
                Self([a $sign e, b $sign f, c $sign g, d $sign h])
            }
        }
    };
}

by_number!(Add, add, +);
by_number!(Sub, sub, -);
by_number!(Mul, mul, *);

/// Returns `sin(x) / x` and `cos(x)` for four x² in [0, π²], with an error below 5e-7, without a square root or a
/// branch.
#[inline]
pub(crate) fn sine_over_angle_and_cosine(squared: Four) -> (Four, Four) {
    let polynomial = |coefficients: [f32; 7]| {
        let [last, rest @ ..] = coefficients;
        rest.into_iter().fold(Four::all(last), |sum, next| Four::all(next) + squared * sum)
    };
    // Coefficients from the highest power. Minimax of the absolute error; the truncation error is below 8e-10.
    let sine = [
        1.361_460_1e-10,
        -2.472_925_7e-8,
        2.753_59e-6,
        -1.984_053_7e-4,
        8.333_322e-3,
        -0.166_666_66,
        1.0,
    ];
    let below_one = [
        -9.723_404e-12,
        2.060_390_7e-9,
        -2.753_484_7e-7,
        2.480_055_6e-5,
        -1.388_886_4e-3,
        4.166_666_4e-2,
        -0.5,
    ];
    (polynomial(sine), Four::ONE + squared * polynomial(below_one))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_is_exact_to_f32_on_both_sides_of_the_series_limit() {
        for exponent in -12..=0 {
            for step in 1..10 {
                let angle = f64::from(step) * 10f64.powi(exponent) * 0.3;
                let (s, c) = ((angle / 2.0).sin(), (angle / 2.0).cos());
                #[expect(clippy::cast_possible_truncation, reason = "the input rounded to f32")]
                let got = f64::from(log(Quat::from_xyzw(0.0, s as f32, 0.0, c as f32)).y);
                // Tolerance: two roundings of the input and a few of the result, 4 units in the last place.
                assert!(
                    (got / angle - 1.0).abs() < 4.0 * f64::from(f32::EPSILON),
                    "{angle}: {got}"
                );
            }
        }
    }

    #[test]
    fn exp_is_unit_and_inverts_log() {
        for step in 1..310 {
            #[expect(clippy::cast_precision_loss, reason = "small")]
            let angle = step as f32 * 0.01;
            let v = Vec3::new(0.48, -0.64, 0.6) * angle;
            let q = exp(v);
            assert!((q.dot(q) - 1.0).abs() < 4.0 * f32::EPSILON);
            // Near π, the sine of the half angle is stationary; w carries the angle, and the error stays linear.
            assert!((log(q) - v).abs().max_element() < 1e-6, "{angle}");
        }
    }

    #[test]
    fn unit_has_no_bias() {
        // A small deviation must be corrected without a bias, or a long chain of products drifts: with the reciprocal
        // of the root, the mean was 3e-8 above 1.
        let mut sum = 0.0;
        let mut q = exp(Vec3::new(0.4, -1.1, 0.3));
        for _ in 0..1000 {
            q = unit(q * exp(Vec3::new(0.7, 0.2, -0.5)));
            let q = q.to_array().map(f64::from);
            sum += q.iter().map(|x| x * x).sum::<f64>() - 1.0;
        }
        assert!((sum / 2000.0).abs() < 1e-8, "mean length 1 + {:e}", sum / 2000.0);
    }

    #[test]
    fn unit_is_continuous_where_the_series_ends() {
        for squared in [0.997f32, 0.99799, 0.998_01, 1.001_99, 1.002_01, 1.003] {
            let q = unit(Quat::from_xyzw(0.6, 0.0, 0.0, 0.8) * sqrt(squared));
            assert!((q.x - 0.6).abs() < 1e-7 && (q.w - 0.8).abs() < 1e-7, "{squared} {q}");
        }
    }

    #[test]
    fn no_turn_is_none_to_the_last_bit() {
        let (a, b) = (exp(Vec3::new(0.7, -0.3, 1.1)), exp(Vec3::new(-0.2, 0.9, 0.4)));
        assert_eq!(log(turn_in_body(a, a)), Vec3::ZERO);
        assert_eq!(log(turn_in_world(b, b)), Vec3::ZERO);
        let off = |x: Quat, y: Quat| (x - y).to_array().iter().fold(0.0f32, |m, x| m.max(x.abs()));
        assert!(off(turn_in_body(a, b), a.conjugate() * b) < 2.0 * f32::EPSILON);
        assert!(off(turn_in_world(a, b), b * a.conjugate()) < 2.0 * f32::EPSILON);
    }

    /// Returns every 997th f32 below a bound, with both signs.
    fn numbers(bound: f32) -> impl Iterator<Item = f32> {
        let positive = (0..bound.to_bits()).step_by(997).map(f32::from_bits);
        positive.flat_map(|x| [x, -x])
    }

    #[test]
    fn sines_and_cosines_are_as_good_as_said() {
        let mut worst = 0.0f64;
        for x in numbers(8192.0) {
            let (sine, cosine) = sin_cos(x);
            let (exact_sine, exact_cosine) = f64::from(x).sin_cos();
            worst = worst.max((f64::from(sine) - exact_sine).abs());
            worst = worst.max((f64::from(cosine) - exact_cosine).abs());
        }
        assert!(worst < 1e-7, "{worst:e}");
        for x in [8193.0f32, 1e4, 54_321.0, 1e6, 7.7e6, 1e9] {
            // Half the distance to the next f32: the angle itself is not known better.
            let half_unit = 0.5 * (f64::from(f32::from_bits(x.to_bits() + 1)) - f64::from(x));
            let ((sine, cosine), (exact_sine, exact_cosine)) = (sin_cos(x), f64::from(x).sin_cos());
            let off = (f64::from(sine) - exact_sine).hypot(f64::from(cosine) - exact_cosine);
            assert!(off < half_unit + 1e-7, "{x}: {off}");
        }
        for x in [1e20, f32::MAX] {
            let (sine, cosine) = sin_cos(x);
            assert!((sine * sine + cosine * cosine - 1.0).abs() < 4.0 * f32::EPSILON);
        }
        assert!(sin_cos(f32::INFINITY).0.is_nan() && sin_cos(f32::NAN).1.is_nan());
    }

    #[test]
    fn arctangents_are_as_good_as_said() {
        let mut worst = 0.0f64;
        for ratio in numbers(1e9) {
            for (y, x) in [(ratio, 1.0), (1.0, ratio), (ratio, -1.0), (-1e30 * ratio, -1e30)] {
                let exact = f64::from(y).atan2(f64::from(x));
                if x < 0.0 && y.abs() < 1e-30 {
                    continue; // Both sides of the cut are valid.
                }
                let off = (f64::from(atan2(y, x)) - exact).abs();
                worst = worst.max(off / exact.abs().max(f64::from(f32::MIN_POSITIVE)));
            }
        }
        assert!(worst < 2.0 * f64::from(f32::EPSILON), "{worst:e}");
        assert_eq!(atan2(0.0, 0.0).to_bits(), 0);
    }

    #[test]
    fn sines_and_cosines_of_four_are_as_good_as_said() {
        let mut worst = 0.0f64;
        for step in 0..=10_000u16 {
            let x = PI * f32::from(step) * 1e-4;
            let (sine, cosine) = sine_over_angle_and_cosine(Four::all(x * x));
            let exact = f64::from(x * x).sqrt();
            let of_angle = if step == 0 { 1.0 } else { exact.sin() / exact };
            worst = worst.max((f64::from(sine.last()) - of_angle).abs());
            worst = worst.max((f64::from(cosine.first()) - exact.cos()).abs());
        }
        assert!(worst < 5e-7, "{worst:e}");
    }

    #[test]
    fn both_signs_of_a_quaternion_are_one_rotation() {
        let q = exp(Vec3::new(1.0, -0.3, 0.2));
        assert_eq!(log(q), log(-q));
    }
}
