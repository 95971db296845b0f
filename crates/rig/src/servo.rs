//! Servos in the form of a board: conversion between a drive's shaft and the servo's own position, with limits.

#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

use core::fmt;

use sinew_core::math;

use crate::limited::{LimitReason, Limited, NotFinite, hold};

/// Speed, rad/s, far below which the fed-forward Coulomb friction is proportional to the speed: a step of the full
/// friction at speed zero would shake a joint at rest. At this speed an encoder of 4096 steps takes 30 ms per step.
const CREEP_RAD_S: f32 = 0.05;

/// Settings of a servo on a board. Values are at the servo's own shaft unless stated otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSettings {
    /// Turns of the servo for one turn of the drive's shaft; negative if they turn in opposite directions.
    pub gear: f32,
    /// Servo's own position when the drive is at zero, rad.
    pub offset_rad: f32,
    /// Minimum and maximum of the servo's own position, rad.
    pub range_rad: [f32; 2],
    /// Maximum torque, N m.
    pub torque_nm: f32,
    /// Maximum speed, rad/s.
    pub speed_rad_s: f32,
    /// Maximum acceleration, rad/s²; infinite without limit.
    pub acceleration_rad_s2: f32,
    /// Torque per current, N m/A.
    pub torque_constant_nm_a: f32,
    /// Torque per position error of its own controller, N m/rad; zero without such a controller.
    pub position_gain_nm_rad: f32,
    /// Coulomb friction, N m.
    pub friction_nm: f32,
    /// Viscous friction, N m s.
    pub damping_nm_s: f32,
    /// Inertia of the rotor, seen through the servo's own gear, kg m².
    pub rotor_inertia_kg_m2: f32,
    /// Action of the servo when commands stop.
    pub on_signal_loss: SignalLoss,
}

/// Address of a servo on its bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Address {
    /// Id of a bus servo, 0 to 252.
    Id(u8),
    /// Channel of a PWM driver, 0 to 15.
    Channel(u8),
}

/// Action of a servo when commands stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SignalLoss {
    /// Torque off.
    #[default]
    Limp,
    /// The servo holds its position.
    Hold,
    /// The servo moves home slowly.
    Home,
}

/// A servo with checked settings. Converts angles and torques between the drive's shaft and the servo's own shaft.
///
/// ```
/// use sinew_rig::limited::LimitReason;
/// use sinew_rig::servo::{Servo, ServoSettings, SignalLoss};
/// let neck = Servo::new(ServoSettings {
///     gear: -2.0,
///     offset_rad: 3.0,
///     range_rad: [1.0, 5.0],
///     torque_nm: 0.5,
///     speed_rad_s: 10.0,
///     acceleration_rad_s2: f32::INFINITY,
///     torque_constant_nm_a: 0.39,
///     position_gain_nm_rad: 0.55,
///     friction_nm: 0.013,
///     damping_nm_s: 0.004,
///     rotor_inertia_kg_m2: 0.0018,
///     on_signal_loss: SignalLoss::Limp,
/// })?;
/// assert_eq!(neck.own_position(0.5)?.value, 2.0);
/// assert_eq!(neck.own_position(2.0)?.reason, Some(LimitReason::Range));
/// assert_eq!(neck.own_torque(0.4)?.value, -0.2);
/// assert!(neck.own_torque(f32::NAN).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo(ServoSettings);

impl Servo {
    /// Creates a servo from settings.
    ///
    /// # Errors
    /// [`ServoError`] names the setting, its value and the accepted range.
    pub fn new(settings: ServoSettings) -> Result<Self, ServoError> {
        let s = &settings;
        let [least, most] = s.range_rad;
        for (what, found, [least, most]) in [
            // Ratios beyond 1:1000 do not occur in addition to a servo's own gear.
            ("gear", s.gear.abs(), [1e-3, 1e3]),
            ("offset_rad", s.offset_rad, [-1e3, 1e3]),
            ("least of range_rad", least, [-1e3, 1e3]),
            ("most of range_rad", most, [least, 1e3]),
            ("torque_nm", s.torque_nm, [0.0, 1e4]),
            ("speed_rad_s", s.speed_rad_s, [0.0, 1e3]),
            ("acceleration_rad_s2", s.acceleration_rad_s2, [0.0, f32::INFINITY]),
            ("torque_constant_nm_a", s.torque_constant_nm_a, [1e-6, 1e4]),
            ("position_gain_nm_rad", s.position_gain_nm_rad, [0.0, 1e6]),
            ("friction_nm", s.friction_nm, [0.0, 1e4]),
            ("damping_nm_s", s.damping_nm_s, [0.0, 1e4]),
            ("rotor_inertia_kg_m2", s.rotor_inertia_kg_m2, [0.0, 1e3]),
        ] {
            // The comparison also refuses NaN.
            if !(found >= least && found <= most) {
                return Err(ServoError { what, found, least, most });
            }
        }
        Ok(Self(settings))
    }

    /// Returns the settings.
    pub fn settings(&self) -> &ServoSettings {
        &self.0
    }

    /// Converts an angle of the drive's shaft to the servo's own position, limited to its range, rad.
    ///
    /// # Errors
    /// [`NotFinite`] if the angle is NaN or infinite.
    pub fn own_position(&self, shaft_rad: f32) -> Result<Limited<f32>, NotFinite> {
        let own = self.0.gear * shaft_rad + self.0.offset_rad;
        hold("the servo's position", own, self.0.range_rad, LimitReason::Range)
    }

    /// Converts the servo's own position to the angle of the drive's shaft, rad.
    pub fn shaft_position(&self, own_rad: f32) -> f32 {
        (own_rad - self.0.offset_rad) / self.0.gear
    }

    /// Converts a speed of the drive's shaft to the servo's own speed, limited, rad/s.
    ///
    /// # Errors
    /// [`NotFinite`] if the speed is NaN or infinite.
    pub fn own_velocity(&self, shaft_rad_s: f32) -> Result<Limited<f32>, NotFinite> {
        self.own_rate("the servo's speed", shaft_rad_s, self.0.speed_rad_s, LimitReason::Speed)
    }

    /// Converts the servo's own speed to the speed of the drive's shaft, rad/s.
    pub fn shaft_velocity(&self, own_rad_s: f32) -> f32 {
        own_rad_s / self.0.gear
    }

    /// Converts an acceleration of the drive's shaft to the servo's own acceleration, limited, rad/s².
    ///
    /// # Errors
    /// [`NotFinite`] if the acceleration is NaN or infinite.
    pub fn own_acceleration(&self, shaft_rad_s2: f32) -> Result<Limited<f32>, NotFinite> {
        let (what, most) = ("the servo's acceleration", self.0.acceleration_rad_s2);
        self.own_rate(what, shaft_rad_s2, most, LimitReason::Acceleration)
    }

    fn own_rate(
        &self,
        what: &'static str,
        of_shaft: f32,
        most: f32,
        reason: LimitReason,
    ) -> Result<Limited<f32>, NotFinite> {
        hold(what, self.0.gear * of_shaft, [-most, most], reason)
    }

    /// Converts a torque at the drive's shaft to the servo's own torque, limited, N m. The caller adds friction
    /// first, see [`Self::shaft_friction`].
    ///
    /// # Errors
    /// [`NotFinite`] if the torque is NaN or infinite.
    pub fn own_torque(&self, shaft_nm: f32) -> Result<Limited<f32>, NotFinite> {
        let most = self.0.torque_nm;
        hold("the servo's torque", shaft_nm / self.0.gear, [-most, most], LimitReason::Torque)
    }

    /// Converts the servo's own torque to the torque at the drive's shaft, N m.
    pub fn shaft_torque(&self, own_nm: f32) -> f32 {
        own_nm * self.0.gear
    }

    /// Returns the torque at the drive's shaft that overcomes the servo's friction at a shaft speed (rad/s), N m:
    /// Coulomb friction, which grows smoothly from zero speed, and viscous friction. The result is meant for
    /// feed-forward: pass the commanded speed, which has no noise.
    ///
    /// # Errors
    /// [`NotFinite`] if the speed is NaN or infinite.
    pub fn shaft_friction(&self, shaft_rad_s: f32) -> Result<f32, NotFinite> {
        let own = self.0.gear * shaft_rad_s;
        if !own.is_finite() {
            return Err(NotFinite { what: "the servo's speed", found: own });
        }
        let ratio = own / CREEP_RAD_S;
        // For larger ratios, ratio / sqrt(1 + ratio²) is 1 in f32.
        let coulomb = if ratio.abs() < 1e4 {
            ratio / math::sqrt(1.0 + ratio * ratio)
        } else {
            ratio.signum()
        };
        Ok(self.shaft_torque(self.0.friction_nm * coulomb + self.0.damping_nm_s * own))
    }

    /// Returns the inertia of the rotor at the drive's shaft, kg m².
    pub fn shaft_inertia(&self) -> f32 {
        self.0.rotor_inertia_kg_m2 * self.0.gear * self.0.gear
    }

    /// Returns the minimum and maximum angle of the drive's shaft, rad.
    pub fn shaft_range(&self) -> [f32; 2] {
        let [a, b] = self.0.range_rad.map(|own| self.shaft_position(own));
        [a.min(b), a.max(b)]
    }
}

/// The reason why a servo's settings are invalid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoError {
    /// Name of the setting. For the gear, the absolute value is checked.
    pub what: &'static str,
    /// Value that was found.
    pub found: f32,
    /// Minimum accepted value.
    pub least: f32,
    /// Maximum accepted value.
    pub most: f32,
}

impl fmt::Display for ServoError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, found, least, most } = self;
        write!(f, "{what} is {found}; it must be a number from {least} to {most}")
    }
}

impl core::error::Error for ServoError {}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may fail by panicking")]
mod tests {
    use super::*;

    fn settings() -> ServoSettings {
        ServoSettings {
            gear: -2.5,
            offset_rad: 3.0,
            range_rad: [0.5, 6.0],
            torque_nm: 0.5,
            speed_rad_s: 10.0,
            acceleration_rad_s2: 200.0,
            torque_constant_nm_a: 0.39,
            position_gain_nm_rad: 0.55,
            friction_nm: 0.013,
            damping_nm_s: 0.004,
            rotor_inertia_kg_m2: 0.0018,
            on_signal_loss: SignalLoss::Hold,
        }
    }

    #[test]
    fn the_shaft_goes_to_the_servo_and_back_with_the_same_power() {
        let servo = Servo::new(settings()).unwrap();
        for shaft in [-0.7, 0.0, 0.3] {
            let own = servo.own_position(shaft).unwrap();
            assert_eq!(own.reason, None);
            assert!((servo.shaft_position(own.value) - shaft).abs() < 1e-6);
        }
        let (speed, torque) = (servo.own_velocity(1.6).unwrap(), servo.own_torque(-0.4).unwrap());
        // Tolerance for two roundings each.
        assert!((speed.value * torque.value + 1.6 * 0.4).abs() < 1e-6);
        assert!((servo.shaft_velocity(speed.value) - 1.6).abs() < 1e-6);
        assert!((servo.shaft_torque(torque.value) + 0.4).abs() < 1e-6);
        let [least, most] = servo.shaft_range();
        assert!((least + 1.2).abs() < 1e-6 && (most - 1.0).abs() < 1e-6);
        assert!((servo.shaft_inertia() - 0.0018 * 6.25).abs() < 1e-8);
    }

    #[test]
    fn what_is_beyond_a_limit_is_held_and_says_why() {
        let servo = Servo::new(settings()).unwrap();
        let held = |limited: Result<Limited<f32>, NotFinite>| {
            let Limited { value, reason } = limited.unwrap();
            (value, reason)
        };
        assert_eq!(held(servo.own_position(2.0)), (0.5, Some(LimitReason::Range)));
        assert_eq!(held(servo.own_velocity(-5.0)), (10.0, Some(LimitReason::Speed)));
        assert_eq!(held(servo.own_acceleration(100.0)), (-200.0, Some(LimitReason::Acceleration)));
        assert_eq!(held(servo.own_torque(2.0)), (-0.5, Some(LimitReason::Torque)));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(servo.own_position(bad).is_err() && servo.own_velocity(bad).is_err());
            assert!(servo.own_acceleration(bad).is_err() && servo.own_torque(bad).is_err());
            assert!(servo.shaft_friction(bad).is_err());
        }
    }

    #[test]
    fn friction_is_odd_smooth_and_brakes_nothing_at_rest() {
        let servo = Servo::new(settings()).unwrap();
        let friction = |speed| servo.shaft_friction(speed).unwrap();
        assert!(friction(0.0).abs() <= 0.0);
        let mut before = friction(-2.0);
        for step in -99..=100_i8 {
            let speed = 0.02 * f32::from(step);
            let now = friction(speed);
            // The friction rises with the speed, by at most its slope at rest: (Coulomb / creep + viscous) times
            // the gear squared.
            assert!(now > before && now - before < 0.02 * 6.25 * (0.013 / 0.05 + 0.004) + 1e-6);
            assert!((now + friction(-speed)).abs() < 1e-7);
            before = now;
        }
        // Far above the creep speed: 2.5 times 0.013, plus 6.25 times 0.004 times 4.
        assert!((friction(4.0) - 0.1325).abs() < 1e-5);
        assert!(friction(1e30).is_finite());
    }

    #[test]
    fn a_servo_that_cannot_be_is_refused_by_its_setting() {
        let message = |change: fn(&mut ServoSettings)| {
            let mut settings = settings();
            change(&mut settings);
            Servo::new(settings).unwrap_err().to_string()
        };
        assert_eq!(message(|s| s.gear = 0.0), "gear is 0; it must be a number from 0.001 to 1000");
        assert_eq!(
            message(|s| s.range_rad = [1.0, 0.5]),
            "most of range_rad is 0.5; it must be a number from 1 to 1000"
        );
        assert_eq!(
            message(|s| s.torque_nm = f32::NAN),
            "torque_nm is NaN; it must be a number from 0 to 10000"
        );
        assert!(message(|s| s.damping_nm_s = -0.1).starts_with("damping_nm_s is -0.1"));
    }
}
