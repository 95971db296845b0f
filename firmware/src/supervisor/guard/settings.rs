//! Limits of a servo's commands, and the reasons for which the guard changes a command.

use core::fmt;

use sinew_rig::servo::Servo;
use sinew_servo_bus::Feedback;

use crate::SettingError;
use crate::drives::{CurrentSettings, DriveSettings};

/// Maximum distance of a goal from the servo in addition to the drive's offset, rad: 30 deg, twice the following
/// error.
const LEAD_RAD: f32 = 0.524;
/// Maximum time in which a drive itself fades out after an old reading, s.
pub(super) const FADE_S: f32 = 0.3;
/// Smallest plausible part of the expected supply voltage. A lower reading is not used.
const LEAST_SUPPLY: f32 = 0.5;

/// Limits of a servo's commands, all at its own shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GuardSettings {
    /// Position on the bus at which the servo's own position is zero, rad.
    pub zero_rad: f32,
    /// Minimum and maximum own position, rad.
    pub range_rad: [f32; 2],
    /// Absolute gear ratio: turns of the servo per turn of the joint. It converts a joint's speed to the servo's
    /// shaft.
    pub gear: f32,
    /// Maximum speed of the servo's goal, rad/s.
    pub speed_rad_s: f32,
    /// Maximum age of a reading, s. Without a newer reading there is no current, no voltage and no first goal.
    pub stale_s: f32,
    /// Kind of the servo's commands, with their limits.
    pub limits: GuardLimits,
}

/// The only kind of command that a servo receives from its drive, with its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GuardLimits {
    /// Position goals.
    Goal(GoalLimits),
    /// Motor currents.
    Current {
        /// Maximum current in either direction, A.
        most_a: f32,
    },
    /// PWM: parts of the supply.
    Voltage(VoltageLimits),
}

/// Limits of a position goal.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GoalLimits {
    /// Maximum acceleration, rad/s²; infinite for no limit. Deceleration to standstill is not limited.
    pub acceleration_rad_s2: f32,
    /// Maximum additional speed of the goal by an offset, rad/s.
    pub offset_rad_s: f32,
    /// Maximum distance of a goal from the measured position, rad.
    pub lead_rad: f32,
    /// Whether the servo reports its position. A hobby servo does not: its first goal is accepted unchanged.
    pub tells: bool,
}

/// Limits of a voltage: its difference from the back-EMF is limited to the voltage of the maximum current.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VoltageLimits {
    /// Maximum current in either direction, A.
    pub most_a: f32,
    /// Resistance of motor and bridge, ohm.
    pub resistance_ohm: f32,
    /// Back-EMF per speed of the servo's own shaft, V s/rad.
    pub back_emf_v_s: f32,
    /// Supply voltage that is assumed until the servo reports it, V.
    pub supply_v: f32,
}

impl VoltageLimits {
    /// Returns the supply voltage for the computation, V: the reported one, or else that of the settings; at least
    /// [`LEAST_SUPPLY`] of the latter.
    fn supply(&self, told_v: Option<f32>) -> f32 {
        told_v.unwrap_or(self.supply_v).max(LEAST_SUPPLY * self.supply_v)
    }

    /// Returns parts of the supply voltage: the part at which no current flows, so that the servo coasts, and the
    /// minimum and maximum permitted part. `effort` is the permitted part of the maximum current for driving. For
    /// braking, down to a shorted winding, the maximum current is always permitted. `is_blind` is whether the drive may
    /// have faded its voltage to zero for want of readings, which shorts the motor: the current of such braking is not
    /// limited.
    pub(super) fn parts(
        &self,
        velocity_rad_s: f32,
        told_v: Option<f32>,
        speed_rad_s: f32,
        (effort, is_blind): (f32, bool),
    ) -> (f32, [f32; 2]) {
        let supply_v = self.supply(told_v);
        let emf_v = self.back_emf_v_s * velocity_rad_s;
        let most_v = self.resistance_ohm * self.most_a;
        let (driven_v, braked_v) = (effort * most_v, if is_blind { f32::INFINITY } else { most_v });
        let least_v = (emf_v - driven_v).min(0.0).max(emf_v - braked_v);
        let largest_v = (emf_v + driven_v).max(0.0).min(emf_v + braked_v);
        // A tolerance of 1e-6 allows for the rounding of the drive's own limits.
        let room_v = 1e-6 * (emf_v.abs() + most_v);
        let most = (most_v + self.back_emf_v_s * speed_rad_s) / self.supply_v;
        let most = most.min(1.0) * (1.0 + 1e-6);
        let part = |volts: f32| (volts / supply_v).max(-most).min(most);
        (emf_v / supply_v, [part(least_v - room_v), part(largest_v + room_v)])
    }
}

impl GuardSettings {
    /// Returns the settings for a servo and its drive.
    pub fn of(servo: &Servo, drive: &DriveSettings) -> Self {
        let own = servo.settings();
        let goal = GoalLimits {
            acceleration_rad_s2: own.acceleration_rad_s2,
            offset_rad_s: 0.0,
            lead_rad: LEAD_RAD,
            tells: true,
        };
        let torque_a = own.torque_nm / own.torque_constant_nm_a;
        let (encoder, stale_s, limits) = match drive {
            DriveSettings::Current(drive) => {
                let limits = GuardLimits::Current { most_a: torque_a.min(drive.current_a) };
                (Some(drive.encoder), drive.cut_off.stale_s, limits)
            }
            DriveSettings::Position(drive) => {
                let (offset_rad_s, lead_rad) = (drive.offset_rad_s, LEAD_RAD + drive.offset_rad);
                let limits = GoalLimits { offset_rad_s, lead_rad, ..goal };
                (Some(drive.encoder), 0.0, GuardLimits::Goal(limits))
            }
            DriveSettings::Target(drive) => {
                let limits = GoalLimits { tells: drive.encoder.is_some(), ..goal };
                (drive.encoder, 0.0, GuardLimits::Goal(limits))
            }
            DriveSettings::Voltage(drive) => {
                let limits = VoltageLimits {
                    most_a: torque_a.min(drive.current.current_a),
                    resistance_ohm: drive.resistance_ohm,
                    back_emf_v_s: drive.back_emf_v_s,
                    supply_v: drive.supply_v,
                };
                let CurrentSettings { encoder, cut_off, .. } = drive.current;
                (Some(encoder), cut_off.stale_s, GuardLimits::Voltage(limits))
            }
        };
        Self {
            zero_rad: encoder.map_or(0.0, |encoder| encoder.zero_rad),
            range_rad: own.range_rad,
            gear: own.gear.abs(),
            speed_rad_s: own.speed_rad_s,
            stale_s: stale_s + FADE_S,
            limits,
        }
    }

    /// Returns whether the servo reports its position.
    pub(crate) fn tells(&self) -> bool {
        !matches!(self.limits, GuardLimits::Goal(GoalLimits { tells: false, .. }))
    }

    /// Returns the current in the winding of a servo in PWM mode, A: the part of its supply that it applies, minus
    /// the back-EMF of its speed. Returns `None` for other servos, which do not need the motor's numbers.
    pub fn winding_a(&self, part: f32, read: &Feedback, told_v: Option<f32>) -> Option<f32> {
        let GuardLimits::Voltage(limits) = &self.limits else { return None };
        let volts = part * limits.supply(told_v) - limits.back_emf_v_s * read.velocity_rad_s;
        Some(volts / limits.resistance_ohm)
    }

    /// Returns an error if a number is invalid or NaN.
    pub(super) fn check(&self) -> Result<(), SettingError> {
        let [least, most] = self.range_rad;
        let all = [
            ("zero_rad", self.zero_rad, [-1e3, 1e3]),
            ("least of range_rad", least, [-1e3, 1e3]),
            ("most of range_rad", most, [least, 1e3]),
            ("gear", self.gear, [1e-3, 1e3]),
            ("speed_rad_s", self.speed_rad_s, [0.0, 1e3]),
            ("stale_s", self.stale_s, [1e-3, 10.0]),
        ];
        let current = |most_a| ("most_a", most_a, [0.0, 1e3]);
        // The lists have equal length: the last item of a list may be repeated.
        let of_limits = match &self.limits {
            GuardLimits::Goal(goal) => [
                ("acceleration_rad_s2", goal.acceleration_rad_s2, [0.0, f32::INFINITY]),
                ("offset_rad_s", goal.offset_rad_s, [0.0, 100.0]),
                ("lead_rad", goal.lead_rad, [1e-3, 1e3]),
                ("lead_rad", goal.lead_rad, [1e-3, 1e3]),
            ],
            GuardLimits::Current { most_a } => [current(*most_a); 4],
            GuardLimits::Voltage(limits) => [
                current(limits.most_a),
                ("resistance_ohm", limits.resistance_ohm, [1e-3, 1e3]),
                ("back_emf_v_s", limits.back_emf_v_s, [0.0, 1e3]),
                ("supply_v", limits.supply_v, [1.0, 100.0]),
            ],
        };
        for (what, found, bounds) in all.into_iter().chain(of_limits) {
            SettingError::check(what, found, bounds)?;
        }
        Ok(())
    }
}

/// A reason for which the guard changed or refused a command. Drives obey all of these limits themselves, so a
/// reason shows a mistake in a drive or its caller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GuardReason {
    /// Refused: torque is not allowed.
    NotAllowed,
    /// Refused: a number is NaN or infinite.
    NotFinite,
    /// Refused: the servo's drive does not give this kind of command.
    Kind,
    /// The command was limited to the range.
    Range,
    /// The command was too fast.
    Speed,
    /// The command's acceleration was too high.
    Acceleration,
    /// The command was too far ahead of the servo.
    Lead,
    /// The current was too high.
    Current,
    /// The part of the supply would drive too much current, or was itself too large.
    Voltage,
    /// There is no reading that is new enough: no current, no voltage, and no first goal.
    Stale,
}

impl fmt::Display for GuardReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotAllowed => "refused: torque is not allowed in this state",
            Self::NotFinite => "refused: a number is NaN or infinite",
            Self::Kind => "refused: the servo's drive does not give this kind of command",
            Self::Range => "held at the end of the servo's range",
            Self::Speed => "held to the largest speed",
            Self::Acceleration => "held to the largest acceleration",
            Self::Lead => "held near to where the servo was measured",
            Self::Current => "held to the largest current",
            Self::Voltage => "held to the voltage of the largest current",
            Self::Stale => "the servo was not read, or too long ago",
        })
    }
}
