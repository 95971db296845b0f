//! From state errors to torques: gains, control laws, limits.

use core::fmt;

use glam::{Quat, Vec3};

use crate::math;
use crate::state::JointState;
use crate::state_error::StateError;
use crate::transform::{Motion, Wrench};

/// Gains of a PD controller.
///
/// With inverse dynamics they are a stiffness and a damping per unit of inertia, 1/s² and 1/s; without,
/// N m/rad and N m s/rad (N/m and N s/m for what slides).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    kp: f32,
    kv: f32,
    linear_kp: f32,
    linear_kv: f32,
}

impl Gains {
    /// Gains as given, of the angular and the linear error alike.
    ///
    /// # Errors
    /// [`GainsError`] if one is not finite or negative.
    pub fn new(kp: f32, kv: f32) -> Result<Self, GainsError> {
        check([("kp", kp), ("kv", kv)])?;
        Ok(Self { kp, kv, linear_kp: kp, linear_kv: kv })
    }

    /// The same gains with others for the linear error: without inverse dynamics the two have different
    /// units.
    ///
    /// # Errors
    /// [`GainsError`] if one is not finite or negative.
    pub fn with_linear(self, kp: f32, kv: f32) -> Result<Self, GainsError> {
        check([("linear kp", kp), ("linear kv", kv)])?;
        Ok(Self { linear_kp: kp, linear_kv: kv, ..self })
    }

    /// `kv = 2 √kp`: the fastest return without overshoot, for unit inertia.
    ///
    /// # Errors
    /// [`GainsError`] if `kp` is not finite or negative.
    ///
    /// ```
    /// let gains = sinew_core::control::Gains::critically_damped(200.0)?;
    /// assert_eq!(gains.kv(), 2.0 * sinew_core::math::sqrt(200.0));
    /// # Ok::<(), sinew_core::control::GainsError>(())
    /// ```
    pub fn critically_damped(kp: f32) -> Result<Self, GainsError> {
        Self::new(kp, 0.0)?;
        Self::new(kp, 2.0 * math::sqrt(kp))
    }

    /// Gain of the angular error.
    pub const fn kp(self) -> f32 {
        self.kp
    }

    /// Gain of the angular error's rate.
    pub const fn kv(self) -> f32 {
        self.kv
    }

    /// Gain of the linear error.
    pub const fn linear_kp(self) -> f32 {
        self.linear_kp
    }

    /// Gain of the linear error's rate.
    pub const fn linear_kv(self) -> f32 {
        self.linear_kv
    }

    /// `kp e + kv ė`, in the axes of the error.
    pub fn apply(self, error: &StateError) -> Motion {
        Motion {
            angular: error.angular_rad * self.kp + error.angular_rate_rad_s * self.kv,
            linear: error.linear_m * self.linear_kp + error.linear_rate_m_s * self.linear_kv,
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

/// Why gains were refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum GainsError {
    /// The named gain is NaN or infinite.
    NonFinite(&'static str),
    /// The named gain is below zero: the loop would push away from the goal.
    Negative(&'static str),
}

impl fmt::Display for GainsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinite(name) => write!(f, "the gain {name} is not finite"),
            Self::Negative(name) => {
                write!(f, "the gain {name} is negative; it must be zero or more")
            }
        }
    }
}

impl core::error::Error for GainsError {}

/// How an error becomes a torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ControlLaw {
    /// `τ = kp e + kv ė`: what a servo does by itself.
    ProportionalDerivative,
    /// `τ = H (θ̈ + kp e + kv ė) + C + G`, eq. (11): the error becomes an acceleration, and inverse dynamics
    /// the torque for it.
    #[default]
    InverseDynamics,
}

/// Acceleration that eq. (11) asks of a joint, relative to its parent, in measured body axes.
///
/// `feedforward` is the desired acceleration as [`JointTargets`](crate::JointTargets) has it, `correction`
/// is `kp e + kv ė` in the axes of the error's reference frame, and `to_body` turns those to measured body
/// axes. The angular feed-forward is used as it is, component by component; the linear one is a vector of
/// the parent's frame and goes through it. The world error of a body is put on its own joint as a whole, not
/// minus the parent's: accumulation is the point of the method.
pub fn commanded_acceleration(
    desired: &JointState,
    measured: &JointState,
    feedforward: Motion,
    correction: Motion,
    to_body: Quat,
) -> Motion {
    let correction = correction.rotated(to_body);
    let through_parent =
        measured.pose.rotation.conjugate() * (desired.pose.rotation * feedforward.linear);
    Motion {
        angular: feedforward.angular + correction.angular,
        linear: through_parent + correction.linear,
    }
}

/// The most that the drive of a joint may be asked for.
///
/// It bounds the length of the moment and of the force vector, so that what is cut keeps its direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueLimit {
    moment_nm: f32,
    force_n: f32,
}

impl TorqueLimit {
    /// No bound (but what is not finite is still refused).
    pub const NONE: Self = Self { moment_nm: f32::INFINITY, force_n: f32::INFINITY };

    /// Bounds of the moment and of the force.
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

    /// What may be asked for of a wanted wrench, and why it is less.
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
    pub fn apply(self, wanted: Wrench) -> Limited<Wrench> {
        if !wanted.is_finite() {
            // Before any comparison: NaN passes a clamp.
            return Limited { value: Wrench::ZERO, reason: Some(LimitReason::NotFinite) };
        }
        let cut = |wanted: Vec3, bound: f32| {
            let largest = wanted.abs().max_element();
            if largest <= 0.0 {
                return (wanted, false);
            }
            // In units of the largest component: neither the square of a huge torque nor its length may
            // overflow, nor the reciprocal of a tiny one.
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

/// A bound of a torque limit is NaN or negative.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LimitError;

impl fmt::Display for LimitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a torque limit must be zero or more (infinity for none)")
    }
}

impl core::error::Error for LimitError {}

/// A value, and why it is not the one that was wanted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limited<T> {
    /// What may be used.
    pub value: T,
    /// What limited it, if anything did.
    pub reason: Option<LimitReason>,
}

/// What limited a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LimitReason {
    /// The moment was above the joint's limit.
    Torque,
    /// The force was above the joint's limit.
    Force,
    /// The wanted value was not a finite number; nothing is asked of the joint.
    NotFinite,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_are_checked() {
        assert_eq!(Gains::critically_damped(-1.0), Err(GainsError::Negative("kp")));
        assert_eq!(Gains::critically_damped(f32::NAN), Err(GainsError::NonFinite("kp")));
        assert_eq!(Gains::new(1.0, f32::INFINITY), Err(GainsError::NonFinite("kv")));
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
