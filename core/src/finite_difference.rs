//! Finite differences of any order, eq. (13) of Notman et al. (2011), for vectors and for rotations.

use core::fmt;

use glam::{Quat, Vec3};

use crate::math;

/// A choice of samples, relative to the instant of the difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Scheme {
    /// The instant and later samples, as in the paper for the desired motion.
    Forward,
    /// The instant and earlier samples: the only choice for a measurement.
    Backward,
    /// Samples on both sides of the instant: accurate to second order, without lead or lag.
    Central,
}

impl Scheme {
    /// Returns the number of samples for a difference of this order. The instant is the last sample of a backward
    /// difference, the middle of a central one, and the first of a forward one.
    ///
    /// ```
    /// use sinew_core::finite_difference::Scheme;
    /// assert_eq!(Scheme::Forward.sample_count(2), 3);
    /// assert_eq!(Scheme::Central.sample_count(1), 3);
    /// ```
    pub const fn sample_count(self, order: usize) -> usize {
        let odd = order % 2 == 1;
        match self {
            Self::Central if odd => order.saturating_add(2),
            _ => order.saturating_add(1),
        }
    }
}

/// Returns the derivative of order `order` of evenly spaced samples, in the samples' unit per s^order.
///
/// Order 0 returns the sample. A central difference of odd order is the mean of the differences half a step before
/// and half a step after the instant. O(order).
///
/// # Errors
/// [`DifferenceError`] if the number of samples is not [`Scheme::sample_count`], a sample is not finite,
/// `dt_s` is not a positive number, or the result is too large for f32.
///
/// ```
/// use sinew_core::{finite_difference::{Scheme, of_vectors}, glam::Vec3};
/// let squares = [0.0, 1.0, 4.0].map(|x| Vec3::new(x, 0.0, 0.0));
/// assert_eq!(of_vectors(Scheme::Central, 1, &squares, 1.0)?.x, 2.0);
/// assert_eq!(of_vectors(Scheme::Forward, 2, &squares, 1.0)?.x, 2.0);
/// # Ok::<(), sinew_core::finite_difference::DifferenceError>(())
/// ```
pub fn of_vectors(
    scheme: Scheme,
    order: usize,
    samples: &[Vec3],
    dt_s: f32,
) -> Result<Vec3, DifferenceError> {
    check(scheme, order, samples.len(), samples.iter().all(|sample| sample.is_finite()), dt_s)?;
    finite(scheme_difference(scheme, order, samples.len(), dt_s, |k| {
        samples.get(k).copied().unwrap_or_default()
    }))
}

/// Returns the derivative of order `order` (1: angular velocity, 2: angular acceleration, ...) of evenly spaced
/// orientations, in rad/s^order, as components in the axes of the rotating body: the differences of the components of
/// `Log(R_kᵀ R_k+1) / dt`. Signs of the quaternions do not matter. O(order).
///
/// For world axes use [`of_rotations_in_world`].
///
/// # Errors
/// [`DifferenceError`] as in [`of_vectors`], and for order 0, which is not a vector.
///
/// ```
/// use sinew_core::{finite_difference::{Scheme, of_rotations}, glam::{Quat, Vec3}, math};
/// let turned = [Quat::IDENTITY, -math::exp(Vec3::new(0.02, 0.0, 0.0))];
/// let velocity = of_rotations(Scheme::Forward, 1, &turned, 0.01)?;
/// assert!((velocity.x - 2.0).abs() < 1e-5);
/// # Ok::<(), sinew_core::finite_difference::DifferenceError>(())
/// ```
pub fn of_rotations(
    scheme: Scheme,
    order: usize,
    samples: &[Quat],
    dt_s: f32,
) -> Result<Vec3, DifferenceError> {
    rotations(scheme, order, samples, dt_s, |from, to| from.conjugate() * to)
}

/// Returns the derivative like [`of_rotations`], as components in world axes: the differences of
/// `Log(R_k+1 R_kᵀ) / dt`.
///
/// # Errors
/// As in [`of_rotations`].
///
/// ```
/// use sinew_core::{finite_difference::{Scheme, of_rotations_in_world}, glam::Vec3, math};
/// // A body that was tipped over turns about its own y axis, which now points along z of the world.
/// let lying = math::exp(Vec3::X * core::f32::consts::FRAC_PI_2);
/// let turned = [lying, lying * math::exp(Vec3::Y * 0.02)];
/// let velocity = of_rotations_in_world(Scheme::Forward, 1, &turned, 0.01)?;
/// assert!((velocity - Vec3::Z * 2.0).length() < 1e-4);
/// # Ok::<(), sinew_core::finite_difference::DifferenceError>(())
/// ```
pub fn of_rotations_in_world(
    scheme: Scheme,
    order: usize,
    samples: &[Quat],
    dt_s: f32,
) -> Result<Vec3, DifferenceError> {
    rotations(scheme, order, samples, dt_s, |from, to| to * from.conjugate())
}

fn rotations(
    scheme: Scheme,
    order: usize,
    samples: &[Quat],
    dt_s: f32,
    step: impl Fn(Quat, Quat) -> Quat,
) -> Result<Vec3, DifferenceError> {
    let Some(order_of_velocity) = order.checked_sub(1) else {
        return Err(DifferenceError::OrderZero);
    };
    let unit = samples.iter().all(|q| math::is_unit(*q));
    check(scheme, order, samples.len(), unit, dt_s)?;
    let velocity = |k: usize| match (samples.get(k), samples.get(k.saturating_add(1))) {
        (Some(from), Some(to)) => math::log(step(*from, *to)) / dt_s,
        _ => Vec3::ZERO,
    };
    // There is one step between every two orientations, half an interval after the first of them. A central
    // difference of odd order of the orientations is therefore the mean of two plain differences of the steps; one
    // of even order is a single difference.
    let steps = samples.len().saturating_sub(1);
    finite(scheme_difference(scheme, order_of_velocity, steps, dt_s, velocity))
}

/// Refuses a result that is not finite: a high order over a short time step may overflow.
fn finite(difference: Vec3) -> Result<Vec3, DifferenceError> {
    if difference.is_finite() { Ok(difference) } else { Err(DifferenceError::Overflow) }
}

/// Returns the plain difference over all `count` items. For a central difference of odd order, returns the mean of the
/// two differences that leave out the first or the last item.
fn scheme_difference(
    scheme: Scheme,
    order: usize,
    count: usize,
    dt_s: f32,
    item: impl Fn(usize) -> Vec3,
) -> Vec3 {
    if scheme == Scheme::Central && count > order.saturating_add(1) {
        (plain(order, dt_s, &item) + plain(order, dt_s, |k| item(k.saturating_add(1)))) * 0.5
    } else {
        plain(order, dt_s, item)
    }
}

/// Returns Σ (-1)^i C(k, i) a[k - i] / h^k: the sum of eq. (13) over the items 0..=k.
fn plain(order: usize, dt_s: f32, item: impl Fn(usize) -> Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    let mut binomial = 1.0; // (-1)^i C(k, i)
    for i in 0..=order {
        let from_end = order.saturating_sub(i);
        sum += item(from_end) * binomial;
        binomial *= -as_f32(from_end) / as_f32(i.saturating_add(1));
    }
    for _ in 0..order {
        sum /= dt_s;
    }
    sum
}

fn as_f32(count: usize) -> f32 {
    // Orders are small. Beyond u16 the result has no meaning in f32 anyway.
    u16::try_from(count).map_or(f32::INFINITY, f32::from)
}

fn check(
    scheme: Scheme,
    order: usize,
    found: usize,
    valid: bool,
    dt_s: f32,
) -> Result<(), DifferenceError> {
    let expected = scheme.sample_count(order);
    if found != expected {
        return Err(DifferenceError::Count { expected, found });
    }
    if !valid {
        return Err(DifferenceError::InvalidSample);
    }
    if !(dt_s.is_finite() && dt_s > 0.0) {
        return Err(DifferenceError::TimeStep);
    }
    Ok(())
}

/// An error in the arguments or the result of a difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DifferenceError {
    /// The scheme needs another number of samples.
    Count {
        /// Number of samples that the scheme needs.
        expected: usize,
        /// Number of samples that were given.
        found: usize,
    },
    /// A sample is not finite, or a quaternion not unit.
    InvalidSample,
    /// The time step is not a positive number.
    TimeStep,
    /// The order is 0, but an orientation is not a vector: rotations have differences of order 1 and above.
    OrderZero,
    /// The result is too large for f32.
    Overflow,
}

impl fmt::Display for DifferenceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => {
                write!(f, "this difference takes {expected} samples, {found} were given")
            }
            Self::InvalidSample => {
                f.write_str("a sample is not finite, or a quaternion is not a unit quaternion")
            }
            Self::TimeStep => f.write_str("the time step must be a positive number of seconds"),
            Self::OrderZero => f.write_str("rotations have differences of order 1 and above"),
            Self::Overflow => f.write_str(
                "the difference is too large for f32; take a lower order or a longer time step",
            ),
        }
    }
}

impl core::error::Error for DifferenceError {}

#[cfg(test)]
mod tests {
    use super::*;

    /// The derivative of order `order` of a polynomial of that degree is constant, and every scheme gives it exactly:
    /// order! times the leading coefficient.
    #[test]
    fn polynomials_are_differentiated_exactly_at_every_order() {
        for order in 0..=6usize {
            for scheme in [Scheme::Forward, Scheme::Backward, Scheme::Central] {
                let count = scheme.sample_count(order);
                let mut samples = [Vec3::ZERO; 9];
                for (k, sample) in samples[..count].iter_mut().enumerate() {
                    #[expect(
                        clippy::cast_possible_wrap,
                        clippy::cast_possible_truncation,
                        reason = "small"
                    )]
                    let x = (k as i32 - 3) as f32;
                    let power = (0..order).fold(1.0, |p, _| p * x);
                    *sample = Vec3::new(power, -2.0 * power, 0.5 * power);
                }
                let factorial = (1..=order).fold(1.0, |p, k| p * as_f32(k));
                let got = of_vectors(scheme, order, &samples[..count], 1.0).unwrap();
                // Whole numbers below 2^24 are exact in f32.
                assert_eq!(got, Vec3::new(1.0, -2.0, 0.5) * factorial, "{scheme:?} {order}");
            }
        }
    }

    #[test]
    fn a_steady_turn_has_constant_velocity_and_no_acceleration() {
        let h = 0.01;
        let w = Vec3::new(1.0, -2.0, 0.5);
        let start = math::exp(Vec3::new(0.4, 0.1, -0.9));
        let samples: [Quat; 4] = core::array::from_fn(|k| start * math::exp(w * (as_f32(k) * h)));
        for scheme in [Scheme::Forward, Scheme::Backward, Scheme::Central] {
            let v = of_rotations(scheme, 1, &samples[..scheme.sample_count(1)], h).unwrap();
            // Tolerance: a few times the f32 rounding of a unit quaternion (6e-8), divided by h.
            assert!((v - w).length() < 5e-5, "{scheme:?} {v}");
            let in_world =
                of_rotations_in_world(scheme, 1, &samples[..scheme.sample_count(1)], h).unwrap();
            assert!((in_world - start * w).length() < 5e-5);
            let a = of_rotations(scheme, 2, &samples[..scheme.sample_count(2)], h).unwrap();
            assert!(a.length() < 5e-3, "{scheme:?} {a}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        use DifferenceError as E;
        let two = [Vec3::ZERO; 2];
        assert_eq!(
            of_vectors(Scheme::Central, 1, &two, 0.1),
            Err(E::Count { expected: 3, found: 2 })
        );
        assert_eq!(of_vectors(Scheme::Forward, 1, &two, 0.0), Err(E::TimeStep));
        assert_eq!(of_vectors(Scheme::Forward, 1, &two, f32::NAN), Err(E::TimeStep));
        assert_eq!(
            of_vectors(Scheme::Forward, 1, &[Vec3::ZERO, Vec3::X * f32::NAN], 0.1),
            Err(E::InvalidSample)
        );
        assert_eq!(
            of_vectors(Scheme::Forward, 1, &[Vec3::ZERO, Vec3::X], f32::MIN_POSITIVE / 8.0),
            Err(E::Overflow)
        );
        assert_eq!(of_rotations(Scheme::Forward, 0, &[Quat::IDENTITY], 0.1), Err(E::OrderZero));
        let zero = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0);
        assert_eq!(
            of_rotations(Scheme::Forward, 1, &[Quat::IDENTITY, zero], 0.1),
            Err(E::InvalidSample)
        );
    }
}
