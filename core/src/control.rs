//! Computes torques from state errors: gains, control laws, limits.

use core::fmt;

use glam::Vec3;

use crate::math;
use crate::state::JointState;
use crate::state_error::StateError;
use crate::transform::{Twist, Wrench};

/// Gains of a PD controller.
///
/// With inverse dynamics, gains are stiffness and damping per unit of inertia: `kp` in 1/s², `kd` in 1/s. With PD
/// alone they are N m/rad and N m s/rad (N/m and N s/m along axes that slide).
///
/// ```
/// use sinew_core::control::{Gains, GainsError};
/// use sinew_core::{glam::Vec3, state_error::StateError};
/// let gains = Gains::new(100.0, 20.0)?.with_linear(30.0, 0.0)?;
/// let error = StateError { angular_rad: Vec3::X * 0.1, linear_m: Vec3::Y * 0.2, ..StateError::ZERO };
/// let asked = gains.apply(&error);
/// assert_eq!((asked.angular, asked.linear), (Vec3::X * 10.0, Vec3::Y * 6.0));
/// assert_eq!(Gains::new(100.0, f32::NAN), Err(GainsError::NonFinite("kd")));
/// # Ok::<(), GainsError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gains {
    kp: f32,
    kd: f32,
    linear_kp: f32,
    linear_kd: f32,
}

impl Gains {
    /// Creates gains that apply to the angular and the linear error alike.
    ///
    /// # Errors
    /// [`GainsError`] if a gain is negative or not finite.
    pub fn new(kp: f32, kd: f32) -> Result<Self, GainsError> {
        check([("kp", kp), ("kd", kd)])?;
        Ok(Self { kp, kd, linear_kp: kp, linear_kd: kd })
    }

    /// Replaces the gains of the linear error: with PD alone, linear and angular gains have different units.
    ///
    /// # Errors
    /// [`GainsError`] if a gain is negative or not finite.
    pub fn with_linear(self, kp: f32, kd: f32) -> Result<Self, GainsError> {
        check([("linear kp", kp), ("linear kd", kd)])?;
        Ok(Self { linear_kp: kp, linear_kd: kd, ..self })
    }

    /// Creates gains with `kd = 2 √kp`: the fastest return without overshoot, for unit inertia.
    ///
    /// # Errors
    /// [`GainsError`] if `kp` is negative or not finite.
    ///
    /// ```
    /// let gains = sinew_core::control::Gains::critically_damped(200.0)?;
    /// assert_eq!(gains.kd(), 2.0 * sinew_core::math::sqrt(200.0));
    /// # Ok::<(), sinew_core::control::GainsError>(())
    /// ```
    pub fn critically_damped(kp: f32) -> Result<Self, GainsError> {
        Self::new(kp, 0.0)?;
        Self::new(kp, 2.0 * math::sqrt(kp))
    }

    /// Returns the gains of stable PD in implicit form, for a controller that acts every `dt_s` seconds and holds its
    /// command.
    ///
    /// Implicit gains act on the state one period ahead, which depends on the commanded acceleration itself. They
    /// solve `a = kp (e + dt ė - dt² a) + kd (ė - dt a)` for a. Use them with inverse dynamics, or if the gains are
    /// per unit of inertia.
    ///
    /// Each step is a step of the backward Euler method: the error of a joint decays for all gains and periods. With
    /// the original gains it grows once `kd dt_s` exceeds about 2. Stiff gains become softer in exchange. Gains
    /// with `kd dt_s` far below 1 hardly change.
    ///
    /// After Tan, Liu & Turk, "Stable Proportional-Derivative Controllers" (2011), who predict with the present
    /// velocity (without `dt² a`).
    ///
    /// # Errors
    /// [`GainsError`] if the period is negative or not finite, or an intermediate number is too large for f32.
    ///
    /// ```
    /// use sinew_core::control::Gains;
    /// // At 100 Hz, this damping would reverse the sign of the error and triple it.
    /// let gains = Gains::new(0.0, 400.0)?.implicit(0.01)?;
    /// assert_eq!(gains.kd(), 80.0);
    /// # Ok::<(), sinew_core::control::GainsError>(())
    /// ```
    pub fn implicit(self, dt_s: f32) -> Result<Self, GainsError> {
        // Written so that NaN fails.
        if !(dt_s >= 0.0 && dt_s.is_finite()) {
            return Err(GainsError::Period);
        }
        let softened = |kp: f32, kd: f32| {
            let share = 1.0 + dt_s * (kd + dt_s * kp);
            // A share that overflows would leave gains of zero: NaN is refused below.
            let share = if share.is_finite() { share } else { f32::NAN };
            (kp / share, (kd + dt_s * kp) / share)
        };
        let (kp, kd) = softened(self.kp, self.kd);
        let (linear_kp, linear_kd) = softened(self.linear_kp, self.linear_kd);
        Self::new(kp, kd)?.with_linear(linear_kp, linear_kd)
    }

    /// Returns the gain of the angular error.
    pub const fn kp(self) -> f32 {
        self.kp
    }

    /// Returns the gain of the angular error's rate.
    pub const fn kd(self) -> f32 {
        self.kd
    }

    /// Returns the gain of the linear error.
    pub const fn linear_kp(self) -> f32 {
        self.linear_kp
    }

    /// Returns the gain of the linear error's rate.
    pub const fn linear_kd(self) -> f32 {
        self.linear_kd
    }

    /// Returns `kp e + kd ė`, in the axes of the error.
    pub fn apply(self, error: &StateError) -> Twist {
        Twist {
            angular: error.angular_rad * self.kp + error.angular_rate_rad_s * self.kd,
            linear: error.linear_m * self.linear_kp + error.linear_rate_m_s * self.linear_kd,
        }
    }
}

fn check(gains: [(&'static str, f32); 2]) -> Result<(), GainsError> {
    for (name, value) in gains {
        if !value.is_finite() {
            return Err(GainsError::NonFinite(name));
        }
        if value < 0.0 {
            return Err(GainsError::Negative(name));
        }
    }
    Ok(())
}

/// An error in the gains of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum GainsError {
    /// The named gain is NaN or infinite.
    NonFinite(&'static str),
    /// The named gain is negative: the loop would push away from the goal.
    Negative(&'static str),
    /// The period is not a finite number of seconds, zero or more.
    Period,
}

impl fmt::Display for GainsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinite(name) => write!(f, "the gain {name} is not finite"),
            Self::Negative(name) => {
                write!(f, "the gain {name} is negative; it must be zero or more")
            }
            Self::Period => f.write_str(
                "the period of the gains must be a finite number of seconds, zero or more",
            ),
        }
    }
}

impl core::error::Error for GainsError {}

/// A law that turns an error into a torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum ControlLaw {
    /// `τ = kp e + kd ė`, the law that a servo applies by itself.
    ProportionalDerivative,
    /// `τ = H (θ̈ + kp e + kd ė) + C + G`, eq. (11): the error becomes an acceleration, and inverse dynamics turns
    /// the acceleration into a torque.
    ///
    /// The angular feed-forward θ̈ is used component by component, unchanged. The linear feed-forward is rotated from
    /// desired to measured body axes through the parent's frame. A world error acts on the body's own joint as a whole:
    /// as in the paper, the error of the parent is not subtracted.
    #[default]
    InverseDynamics,
}

/// Rotates a linear acceleration from desired body axes, which [`JointTargets`](crate::JointTargets) uses, to
/// measured body axes. The vector stays the same in the parent's frame.
///
/// Never inlined, since most joints do not slide.
#[inline(never)]
pub(crate) fn through_parent(
    desired: &JointState,
    measured: &JointState,
    linear_m_s2: Vec3,
) -> Vec3 {
    let in_parent = math::rotate(desired.pose.rotation, linear_m_s2);
    math::rotate(measured.pose.rotation.conjugate(), in_parent)
}

/// The maximum torque and force of a joint's drive.
///
/// The limit bounds the lengths of the two vectors, so that a limited vector keeps its direction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TorqueLimit {
    moment_nm: f32,
    force_n: f32,
}

impl TorqueLimit {
    /// No bound. A torque that is not finite still becomes zero.
    pub const NONE: Self = Self { moment_nm: f32::INFINITY, force_n: f32::INFINITY };

    /// Creates a limit from a maximum moment, N m, and a maximum force, N.
    ///
    /// # Errors
    /// [`LimitError`] if a bound is NaN or negative. Infinity means no bound.
    pub fn new(moment_nm: f32, force_n: f32) -> Result<Self, LimitError> {
        // Written so that NaN fails.
        if moment_nm >= 0.0 && force_n >= 0.0 {
            Ok(Self { moment_nm, force_n })
        } else {
            Err(LimitError)
        }
    }

    /// Returns the maximum moment, N m; infinite for no bound.
    pub const fn moment_nm(self) -> f32 {
        self.moment_nm
    }

    /// Returns the maximum force, N; infinite for no bound.
    pub const fn force_n(self) -> f32 {
        self.force_n
    }

    /// Limits a wrench to the bounds, and reports which bound it exceeded. A wrench that is not finite becomes zero,
    /// with [`LimitReason::NotFinite`].
    ///
    /// ```
    /// use sinew_core::{Wrench, control::{LimitReason, TorqueLimit}, glam::Vec3};
    /// let servo = TorqueLimit::new(3.0, 0.0)?;
    /// let wanted = Wrench::new(Vec3::new(0.0, 6.0, 0.0), Vec3::ZERO);
    /// let allowed = servo.apply(wanted);
    /// assert_eq!(allowed.value.moment_nm, Vec3::new(0.0, 3.0, 0.0));
    /// assert_eq!(allowed.reason, Some(LimitReason::Torque));
    /// # Ok::<(), sinew_core::control::LimitError>(())
    /// ```
    #[inline]
    pub fn apply(self, wanted: Wrench) -> Limited<Wrench> {
        if within(wanted.moment_nm, self.moment_nm) && within(wanted.force_n, self.force_n) {
            return Limited { value: wanted, reason: None };
        }
        self.cut(wanted)
    }

    /// Limits a torque in place, like `apply`. If `slides` is false, the joint cannot slide, and its force is assumed
    /// to be zero.
    #[inline]
    pub(crate) fn bound(self, torque: &mut Limited<Wrench>, slides: bool) {
        let wanted = torque.value;
        if within(wanted.moment_nm, self.moment_nm)
            && (!slides || within(wanted.force_n, self.force_n))
        {
            torque.reason = None;
        } else {
            *torque = self.cut(wanted);
        }
    }

    /// Limits a wrench that failed the quick check `within`.
    fn cut(self, wanted: Wrench) -> Limited<Wrench> {
        if !wanted.is_finite() {
            // Checked before any comparison, because NaN passes a clamp.
            return Limited { value: Wrench::ZERO, reason: Some(LimitReason::NotFinite) };
        }
        let cut = |wanted: Vec3, bound: f32| {
            let largest = wanted.abs().max_element();
            if largest <= 0.0 {
                return (wanted, false);
            }
            // Scaled by the largest component. Otherwise the square or the length of a huge torque, or the reciprocal
            // of a tiny torque, could overflow.
            let direction = wanted / largest;
            let length = math::length(direction);
            if length > bound / largest {
                (direction * (bound / length), true)
            } else {
                (wanted, false)
            }
        };
        let (moment_nm, moment_cut) = cut(wanted.moment_nm, self.moment_nm);
        let (force_n, force_cut) = cut(wanted.force_n, self.force_n);
        let reason = match (moment_cut, force_cut) {
            (false, false) => None,
            (true, _) => Some(LimitReason::Torque),
            (false, true) => Some(LimitReason::Force),
        };
        Limited { value: Wrench { moment_nm, force_n }, reason }
    }
}

/// Returns `true` if a vector is zero or surely shorter than a bound. Written so that NaN and overflow give `false`.
/// Compares squares, which avoids a square root.
#[inline]
fn within(wanted: Vec3, bound: f32) -> bool {
    wanted.dot(wanted) < bound * bound || wanted == Vec3::ZERO
}

/// An error in a torque limit: a bound is NaN or negative.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LimitError;

impl fmt::Display for LimitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a torque limit must be zero or more (infinity for none)")
    }
}

impl core::error::Error for LimitError {}

/// A value after all limits, and the reason if it differs from the wanted value.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Limited<T> {
    /// The value to use.
    pub value: T,
    /// The reason why the value was changed, or `None` if it is unchanged.
    pub reason: Option<LimitReason>,
}

impl<T> AsRef<T> for Limited<T> {
    fn as_ref(&self) -> &T {
        &self.value
    }
}

impl<T> AsMut<T> for Limited<T> {
    fn as_mut(&mut self) -> &mut T {
        &mut self.value
    }
}

/// A reason why a value was changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[non_exhaustive]
pub enum LimitReason {
    /// The moment exceeded the joint's limit.
    Torque,
    /// The force exceeded the joint's limit.
    Force,
    /// The wanted value was not finite; the torque is zero.
    NotFinite,
    /// The workspace has no room for the controller's method; the torque is zero.
    NoRoom,
    /// All joints together asked for more than their [`supply`](crate::supply).
    Supply,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_are_checked() {
        assert_eq!(Gains::critically_damped(-1.0), Err(GainsError::Negative("kp")));
        assert_eq!(Gains::critically_damped(f32::NAN), Err(GainsError::NonFinite("kp")));
        assert_eq!(Gains::new(1.0, f32::INFINITY), Err(GainsError::NonFinite("kd")));
    }

    /// Returns the spectral radius of one step of the error `(e, dt ė)` with a constant acceleration. `pushed` is
    /// the part of the acceleration that acts on the position within the step, in units of dt²: 1 for semi-implicit
    /// Euler, 1/2 for a real joint.
    fn growth(gains: Gains, dt_s: f32, pushed: f32) -> f32 {
        let (p, v) = (gains.kp() * dt_s * dt_s, gains.kd() * dt_s);
        let trace = 2.0 - pushed * p - v;
        let determinant = (1.0 - pushed * p) * (1.0 - v) + p * (1.0 - pushed * v);
        let discriminant = 0.25 * trace * trace - determinant;
        if discriminant < 0.0 {
            math::sqrt(determinant)
        } else {
            0.5 * trace.abs() + math::sqrt(discriminant)
        }
    }

    #[test]
    fn implicit_gains_let_every_error_decay_in_every_period() {
        let mut grown = 0;
        for kp in [1.0, 30.0, 200.0, 1e3, 1e4, 1e5] {
            for kd in [0.0, 1.0, 10.0, 2.0 * math::sqrt(kp), 200.0, 1e3, 1e4] {
                for dt_s in [0.002, 0.01, 0.03, 0.1] {
                    let given = Gains::new(kp, kd).unwrap();
                    let implicit = given.implicit(dt_s).unwrap();
                    for pushed in [0.5, 1.0] {
                        let growth = growth(implicit, dt_s, pushed);
                        assert!(growth < 1.0, "{kp} {kd} {dt_s}: {growth}");
                    }
                    // Backward Euler: the decay of an undamped error depends on its frequency alone.
                    let undamped = 1.0 / math::sqrt(1.0 + kp * dt_s * dt_s);
                    if kd <= 0.0 {
                        let growth = growth(implicit, dt_s, 1.0);
                        assert!((growth - undamped).abs() < 1e-5, "{kp} {dt_s}: {growth}");
                    }
                    grown += usize::from(growth(given, dt_s, 1.0) > 1.0);
                }
            }
        }
        assert!(grown > 50, "only {grown} of 168 grow with the gains as given: nothing is shown");
    }

    #[test]
    fn implicit_gains_are_the_given_ones_in_short_periods() {
        let given = Gains::critically_damped(200.0).unwrap().with_linear(3.0, 0.5).unwrap();
        assert_eq!(given.implicit(0.0), Ok(given));
        let near = given.implicit(1e-5).unwrap();
        assert!((near.kp() / given.kp() - 1.0).abs() < 1e-3);
        assert!((near.linear_kd() / given.linear_kd() - 1.0).abs() < 1e-3);
        for period in [-1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(given.implicit(period), Err(GainsError::Period));
        }
        let huge = Gains::new(f32::MAX, f32::MAX).unwrap();
        assert_eq!(huge.implicit(10.0), Err(GainsError::NonFinite("kp")));
    }

    #[test]
    fn limits_refuse_nan_and_cut_by_length() {
        assert_eq!(TorqueLimit::new(f32::NAN, 1.0), Err(LimitError));
        assert_eq!(TorqueLimit::new(1.0, -1.0), Err(LimitError));
        let limit = TorqueLimit::new(5.0, 2.0).unwrap();
        let wanted = |m: Vec3, f: Vec3| limit.apply(Wrench::new(m, f));
        assert_eq!(wanted(Vec3::new(3.0, 0.0, 4.0), Vec3::ZERO).reason, None);
        let cut = wanted(Vec3::new(6.0, 0.0, 8.0), Vec3::X * 4.0);
        assert_eq!(cut.reason, Some(LimitReason::Torque));
        assert_eq!(cut.value, Wrench::new(Vec3::new(3.0, 0.0, 4.0), Vec3::X * 2.0));
        assert_eq!(wanted(Vec3::ZERO, Vec3::X * 4.0).reason, Some(LimitReason::Force));
        for bad in [f32::NAN, f32::INFINITY] {
            let refused = TorqueLimit::NONE.apply(Wrench::new(Vec3::X * bad, Vec3::ZERO));
            assert_eq!(
                refused,
                Limited { value: Wrench::ZERO, reason: Some(LimitReason::NotFinite) }
            );
        }
        let huge = wanted(Vec3::X * f32::MAX, Vec3::ZERO);
        assert_eq!(huge.value.moment_nm, Vec3::X * 5.0, "the square of the length overflows");
        let huge = wanted(Vec3::new(f32::MAX, f32::MAX, 0.0), Vec3::ZERO);
        let expected = Vec3::new(5.0, 5.0, 0.0) * core::f32::consts::FRAC_1_SQRT_2;
        assert!((huge.value.moment_nm - expected).length() < 1e-6, "the length overflows");
        let tiny = wanted(Vec3::X * 1e-40, Vec3::ZERO);
        assert_eq!(tiny.value.moment_nm, Vec3::X * 1e-40, "the reciprocal overflows");
        assert_eq!(tiny.reason, None);
    }
}
