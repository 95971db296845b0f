//! What one servo may be commanded, and why the guard changes it.

use core::fmt;

use sinew_rig::servo::Servo;
use sinew_servo_bus::Feedback;

use crate::SettingError;
use crate::drives::{CurrentSettings, DriveSettings};

/// A goal may be ahead of a servo by this and the drive's offset, rad: 30 deg, twice the following error.
const LEAD_RAD: f32 = 0.524;
/// A drive lets go of an old reading by itself, in less than this, s.
pub(super) const FADE_S: f32 = 0.3;
/// A supply below this part of what is expected is not believed.
const LEAST_SUPPLY: f32 = 0.5;

/// What one servo may be commanded. All is of its own shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GuardSettings {
    /// Position on the bus where its own is zero, rad.
    pub zero_rad: f32,
    /// Least and most own position, rad.
    pub range_rad: [f32; 2],
    /// Its turns for a turn of the joint, either way: what a joint's speed is at its shaft.
    pub gear: f32,
    /// The largest speed of its goal, rad/s.
    pub speed_rad_s: f32,
    /// A reading that is older is none: no current, no voltage, and no first goal; s.
    pub stale_s: f32,
    /// The kind of its commands, with their limits.
    pub limits: GuardLimits,
}

/// The one kind of command that a servo gets from its drive, with its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GuardLimits {
    /// Goals.
    Goal(GoalLimits),
    /// Currents.
    Current {
        /// The most either way, A.
        most_a: f32,
    },
    /// Parts of the supply.
    Voltage(VoltageLimits),
}

/// Limits of a goal.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GoalLimits {
    /// The largest acceleration, rad/s²; infinite for no limit. To stand still it may be slower at once.
    pub acceleration_rad_s2: f32,
    /// How fast an offset may move the goal besides, rad/s.
    pub offset_rad_s: f32,
    /// How far a goal may be from where it was measured, rad.
    pub lead_rad: f32,
    /// Whether the servo tells where it is. A hobby servo does not: its first goal is taken as it is.
    pub tells: bool,
}

/// Limits of a voltage: it differs from the back-EMF by as much as drives the most current.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct VoltageLimits {
    /// The most current either way, A.
    pub most_a: f32,
    /// Resistance of motor and bridge, ohm.
    pub resistance_ohm: f32,
    /// Back-EMF at its own shaft, V s/rad.
    pub back_emf_v_s: f32,
    /// The supply, as long as the servo does not tell it, V.
    pub supply_v: f32,
}

impl VoltageLimits {
    /// Returns the supply that counts, V.
    fn supply(&self, told_v: Option<f32>) -> f32 {
        told_v.unwrap_or(self.supply_v).max(LEAST_SUPPLY * self.supply_v)
    }

    /// Returns the part of the supply with which the servo coasts, and the least and the most that it may get.
    /// `effort`: what part of its current it may get; shorted, a motor may brake with all of it. `is_blind`: its drive
    /// may have let go, and short it whatever the current.
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
        // A millionth is rounding of the drive's own limits.
        let room_v = 1e-6 * (emf_v.abs() + most_v);
        let most = (most_v + self.back_emf_v_s * speed_rad_s) / self.supply_v;
        let most = most.min(1.0) * (1.0 + 1e-6);
        let part = |volts: f32| (volts / supply_v).max(-most).min(most);
        (emf_v / supply_v, [part(least_v - room_v), part(largest_v + room_v)])
    }
}

impl GuardSettings {
    /// What a servo's own settings and its drive's say.
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

    /// Whether the servo tells where it is.
    pub(crate) fn tells(&self) -> bool {
        !matches!(self.limits, GuardLimits::Goal(GoalLimits { tells: false, .. }))
    }

    /// Returns the current in the winding of a servo that is driven by voltage, A: by the part of its supply that it
    /// applies, less the back-EMF of its speed. None of other servos: they do not need the motor's numbers.
    pub fn winding_a(&self, part: f32, read: &Feedback, told_v: Option<f32>) -> Option<f32> {
        let GuardLimits::Voltage(limits) = &self.limits else { return None };
        let volts = part * limits.supply(told_v) - limits.back_emf_v_s * read.velocity_rad_s;
        Some(volts / limits.resistance_ohm)
    }

    /// Refuses what cannot be; NaN, too.
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
        // The last may be there several times.
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

/// Why the guard changed or refused a command. Drives keep to all of it: a reason is a mistake in a drive or its
/// caller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GuardReason {
    /// Refused: torque is not allowed.
    NotAllowed,
    /// Refused: a number is NaN or infinite.
    NotFinite,
    /// Refused: the servo's drive does not give this kind of command.
    Kind,
    /// The end of the range.
    Range,
    /// Too fast.
    Speed,
    /// Faster and faster too soon.
    Acceleration,
    /// Too far ahead of the servo.
    Lead,
    /// Too much current.
    Current,
    /// A part of the supply that would drive too much current, or too large a part.
    Voltage,
    /// No reading that is new enough: no current, no voltage, and no first goal.
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
