//! Settings of a controller, and the inputs at its start.

use sinew_rig::servo::Servo;
use sinew_servo_bus::Schedule;
use sinew_servo_bus::settings::{Mode, ServoRequirements};

use crate::SettingError;
use crate::drives::DriveSettings;
use crate::supervisor::detect::{
    Following, FollowingSettings, HeatSettings, Overrun, OverrunSettings, Silence, SupplySettings,
    WindingSettings,
};
use crate::supervisor::{FaultLog, FaultSet, LOGGED, Settings};

/// Settings of the control loop. Settings of a rig's servos are in [`ServoSetup`].
#[derive(Debug, Clone)]
pub struct ControllerSettings {
    /// Times and speeds of the supervisor.
    pub supervisor: Settings,
    /// Method, gains and observer of the tracker.
    pub tracker: sinew_core::tracker::Settings,
    /// Limits of the following error.
    pub following: FollowingSettings,
    /// Limit of missing replies.
    pub silence: Silence,
    /// Limit of late ticks.
    pub overrun: OverrunSettings,
    /// Maximum age of a valid reading, s. Every servo must be read more often.
    pub stale_s: f32,
    /// Time without a reading of voltage and temperature after which a servo is silent, s. They are read in turn, one
    /// servo per tick, when there is time.
    pub blind_s: f32,
    /// Maximum distance of a servo's measured position from its range, rad: an allowance for overshoot.
    pub beyond_rad: f32,
    /// Factor to which the feedback of a swinging joint is reduced, from 0.1 to 1. With 1 it is not reduced.
    pub swing_gain: f32,
    /// Current of the supply, A: a rig that needs more to be held is not armed. 0 if it is not known.
    pub supply_a: f32,
    /// Computation time of the board per tick, without the bus, µs.
    pub compute_us: u32,
    /// CRC at the end of the rig's compact form, which a show must carry.
    pub rig_crc: u32,
}

/// The default settings use recommended tracking. Readings are valid for 0.1 s, voltage and temperature for 2 s. A
/// servo may be 3 deg beyond its range. The board computes for 500 µs per tick. The rig has no CRC.
impl Default for ControllerSettings {
    fn default() -> Self {
        Self {
            supervisor: Settings::default(),
            tracker: sinew_core::tracker::Settings::recommended(),
            following: FollowingSettings::default(),
            silence: Silence::default(),
            overrun: OverrunSettings::default(),
            stale_s: 0.1,
            blind_s: 2.0,
            beyond_rad: 0.052,
            swing_gain: 1.0,
            supply_a: 0.0,
            compute_us: 500,
            rig_crc: 0,
        }
    }
}

impl ControllerSettings {
    /// Checks the settings as far as possible without the rig. Used at a start, and for settings that a host writes.
    ///
    /// # Errors
    /// [`SettingError`] names the setting and its bounds; the bounds of a reading's age depend on the bus.
    pub fn check(&self, schedule: &Schedule) -> Result<(), SettingError> {
        self.supervisor.check()?;
        Following::new(self.following, 1e-6 * schedule.tick_us() as f32)?;
        Overrun::new(self.overrun)?;
        // A reading must not count as old before the servo is read again. Without reads none is new enough.
        let least_s = (1.0 / schedule.read_hz()).max(1e-3);
        SettingError::check("stale_s", self.stale_s, [least_s, 10.0])?;
        SettingError::check("blind_s", self.blind_s, [0.1, 60.0])?;
        SettingError::check("beyond_rad", self.beyond_rad, [0.0, 0.5])?;
        SettingError::check("swing_gain", self.swing_gain, [0.1, 1.0])?;
        SettingError::check("supply_a", self.supply_a, [0.0, 1e3])
    }

    /// Returns the maximum speed of a joint at which a rig is armed, rad/s: the soft speed, since nothing moves
    /// faster during arming, and at most the speed that causes the maximum following error within its permitted time.
    /// A joint that is stopped evenly within twice that time has at most this error.
    pub(super) fn rest_rad_s(&self) -> f32 {
        let FollowingSettings { most_rad, time_s } = self.following;
        self.supervisor.soft_rad_s.min(most_rad / time_s)
    }
}

/// Settings of a servo for the controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSetup {
    /// Class of the servo's drive, with its settings.
    pub drive: DriveSettings,
    /// Bandwidth of the joint's observer for its gear and load, rad/s; 0 for that of the tracker's settings. The
    /// minimum of all servos at a joint is used. Only for servos in current or PWM mode.
    pub bandwidth_rad_s: f32,
    /// Half the play of the gear and a step of the encoder, at the joint, rad (m for a prismatic joint); 0 for no rest
    /// zone. The values of a drive's servos are added; a joint with several drives gets the largest sum. Only for
    /// servos in current or PWM mode.
    pub rest_rad: f32,
    /// Limits of the temperature.
    pub heat: HeatSettings,
    /// Limits of the voltage, for each servo, since a plug may be loose.
    pub supply: SupplySettings,
    /// Limits of the winding.
    pub winding: WindingSettings,
    /// Stall current, A. If a servo in position mode reports only its load, the current is this multiplied by the
    /// load.
    pub stall_a: f32,
    /// Stall torque, N m. If the rig requires less, the servo's own limit must be lower.
    pub stall_nm: f32,
    /// Temperature at which this kind of servo switches itself off, degC. The servo's own limit must be equal.
    pub shutdown_c: f32,
}

impl ServoSetup {
    /// Returns the required registers of this servo. With different registers the rig is not armed.
    pub fn requirements(&self, servo: &Servo) -> ServoRequirements {
        let servo = servo.settings();
        let (mode, encoder, gain_ratio) = match &self.drive {
            DriveSettings::Current(own) => (Mode::Current, Some(own.encoder), 1.0),
            DriveSettings::Position(own) => (Mode::Position, Some(own.encoder), own.gain_ratio),
            DriveSettings::Target(own) => (Mode::Position, own.encoder, 1.0),
            DriveSettings::Voltage(own) => (Mode::Pwm, Some(own.current.encoder), 1.0),
        };
        let zero_rad = encoder.unwrap_or_default().zero_rad;
        ServoRequirements {
            mode,
            range_rad: servo.range_rad.map(|own| own + zero_rad),
            torque_nm: servo.torque_nm,
            stall_nm: self.stall_nm,
            friction_nm: servo.friction_nm,
            torque_constant_nm_a: servo.torque_constant_nm_a,
            shutdown_c: self.shutdown_c,
            gain_ratio,
        }
    }
}

/// Data that is known when the board starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Number of the board's start.
    pub count: u32,
    /// Reasons for the start that are faults: watchdog, brown-out, panic.
    pub causes: FaultSet,
    /// Faults from storage.
    pub log: FaultLog<LOGGED>,
}

/// The first start, by power-on.
impl Default for Start {
    fn default() -> Self {
        Self { count: 0, causes: FaultSet::EMPTY, log: FaultLog::default() }
    }
}
