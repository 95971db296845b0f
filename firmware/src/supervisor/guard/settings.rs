//! What one servo may be commanded, and why the guard changes it.

use core::fmt;

use sinew_rig::servo::Servo;

use crate::SettingError;
use crate::drives::DriveSettings;

/// A goal may be ahead of a servo by this and the drive's offset, rad: 30 deg, twice the following error.
const LEAD_RAD: f32 = 0.524;
/// A drive lets go of an old reading by itself, in less than this, s.
const FADE_S: f32 = 0.3;

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
    /// The largest acceleration of its goal, rad/s²; infinite for no limit. To stand still it may be slower at once.
    pub acceleration_rad_s2: f32,
    /// How fast an offset may move the goal besides, rad/s.
    pub offset_rad_s: f32,
    /// How far a goal may be from where it was measured, rad.
    pub lead_rad: f32,
    /// The most current either way, A; of a servo by voltage the most part of the supply.
    pub effort: f32,
    /// A reading that is older is none: no current, no voltage, and no first goal; s.
    pub stale_s: f32,
    /// Whether it tells where it is. A hobby servo does not: its first goal is taken as it is.
    pub tells: bool,
}

impl GuardSettings {
    /// What a servo's own settings and its drive's say.
    pub fn of(servo: &Servo, drive: &DriveSettings) -> Self {
        let own = servo.settings();
        let all = Self {
            zero_rad: 0.0,
            range_rad: own.range_rad,
            gear: own.gear.abs(),
            speed_rad_s: own.speed_rad_s,
            acceleration_rad_s2: own.acceleration_rad_s2,
            offset_rad_s: 0.0,
            lead_rad: LEAD_RAD,
            effort: own.torque_nm / own.torque_constant_nm_a,
            stale_s: FADE_S,
            tells: true,
        };
        match drive {
            DriveSettings::Current(drive) => Self {
                zero_rad: drive.encoder.zero_rad,
                effort: all.effort.min(drive.current_a),
                stale_s: drive.cut_off.stale_s + FADE_S,
                ..all
            },
            DriveSettings::Position(drive) => Self {
                zero_rad: drive.encoder.zero_rad,
                offset_rad_s: drive.offset_rad_s,
                lead_rad: LEAD_RAD + drive.offset_rad,
                ..all
            },
            DriveSettings::Target(drive) => {
                let zero_rad = drive.encoder.map_or(0.0, |encoder| encoder.zero_rad);
                Self { zero_rad, tells: drive.encoder.is_some(), ..all }
            }
            DriveSettings::Voltage(drive) => Self {
                zero_rad: drive.current.encoder.zero_rad,
                effort: drive.most_duty(servo),
                stale_s: drive.current.cut_off.stale_s + FADE_S,
                ..all
            },
        }
    }

    /// Refuses what cannot be; NaN, too.
    pub(super) fn check(&self) -> Result<(), SettingError> {
        let [least, most] = self.range_rad;
        for (what, found, bounds) in [
            ("zero_rad", self.zero_rad, [-1e3, 1e3]),
            ("least of range_rad", least, [-1e3, 1e3]),
            ("most of range_rad", most, [least, 1e3]),
            ("gear", self.gear, [1e-3, 1e3]),
            ("speed_rad_s", self.speed_rad_s, [0.0, 1e3]),
            ("acceleration_rad_s2", self.acceleration_rad_s2, [0.0, f32::INFINITY]),
            ("offset_rad_s", self.offset_rad_s, [0.0, 100.0]),
            ("lead_rad", self.lead_rad, [1e-3, 1e3]),
            ("effort", self.effort, [0.0, 1e3]),
            ("stale_s", self.stale_s, [1e-3, 10.0]),
        ] {
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
    /// Refused: no drive gives this kind of command.
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
    /// Too large a part of the supply.
    Voltage,
    /// No reading that is new enough: no current, no voltage, and no first goal.
    Stale,
}

impl fmt::Display for GuardReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotAllowed => "refused: torque is not allowed in this state",
            Self::NotFinite => "refused: a number is NaN or infinite",
            Self::Kind => "refused: no drive gives this kind of command",
            Self::Range => "held at the end of the servo's range",
            Self::Speed => "held to the largest speed",
            Self::Acceleration => "held to the largest acceleration",
            Self::Lead => "held near to where the servo was measured",
            Self::Current => "held to the largest current",
            Self::Voltage => "held to the largest part of the supply",
            Self::Stale => "the servo was not read, or too long ago",
        })
    }
}
