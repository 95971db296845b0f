//! What a controller is made of.

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

/// Numbers of the loop. What a rig's servos bear is in [`ServoSetup`].
#[derive(Debug, Clone)]
pub struct ControllerSettings {
    /// Times and speeds of the supervisor.
    pub supervisor: Settings,
    /// Method, gains and observer.
    pub tracker: sinew_core::tracker::Settings,
    /// When a servo does not follow.
    pub following: FollowingSettings,
    /// When a servo does not answer.
    pub silence: Silence,
    /// How many ticks may take too long.
    pub overrun: OverrunSettings,
    /// A reading that is older is not valid, s. Every servo must be read more often.
    pub stale_s: f32,
    /// A servo whose voltage and temperature were not read for longer is silent, s. They are read in turn, one servo a
    /// tick, where there is time.
    pub blind_s: f32,
    /// How far beyond its range a servo may be measured, rad: what it overshoots.
    pub beyond_rad: f32,
    /// The feedback of a joint that swings is lowered to this part, from 0.1 to 1: 1 for nothing.
    pub swing_gain: f32,
    /// What the supply gives, A: a rig that takes more to be held is not armed. 0 if it is not known.
    pub supply_a: f32,
    /// What a tick takes the board besides its bus, µs.
    pub compute_us: u32,
    /// The last four bytes of the rig's compact form, which a show must carry.
    pub rig_crc: u32,
}

/// Recommended tracking, readings up to 0.1 s, health up to 2 s, 3 deg beyond a range, 500 µs a tick, a rig without a
/// CRC.
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
    /// What can be said of settings before the rig is known: the one check, at a start and of what a host writes.
    ///
    /// # Errors
    /// [`SettingError`] names the setting, and what it must be; of a reading's age that depends on the bus.
    pub fn check(&self, schedule: &Schedule) -> Result<(), SettingError> {
        self.supervisor.check()?;
        Following::new(self.following, 1e-6 * schedule.tick_us() as f32)?;
        Overrun::new(self.overrun)?;
        // Before it is read again, no reading is old. Without reads none is new enough.
        let least_s = (1.0 / schedule.read_hz()).max(1e-3);
        SettingError::check("stale_s", self.stale_s, [least_s, 10.0])?;
        SettingError::check("blind_s", self.blind_s, [0.1, 60.0])?;
        SettingError::check("beyond_rad", self.beyond_rad, [0.0, 0.5])?;
        SettingError::check("swing_gain", self.swing_gain, [0.1, 1.0])?;
        SettingError::check("supply_a", self.supply_a, [0.0, 1e3])
    }

    /// The fastest joint with which a rig is armed, rad/s: the soft speed, since nothing moves faster while it is
    /// armed; and no faster than that it is off by the following error's limit after that limit's time. Brought to
    /// rest evenly within twice that time, it is off by no more.
    pub(super) fn rest_rad_s(&self) -> f32 {
        let FollowingSettings { most_rad, time_s } = self.following;
        self.supervisor.soft_rad_s.min(most_rad / time_s)
    }
}

/// How one servo is driven, and what it bears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSetup {
    /// Its class, with settings.
    pub drive: DriveSettings,
    /// Bandwidth of its joint's observer by its gear and load, rad/s; 0 for that of the tracker's settings. Of several
    /// servos at a joint the least counts. Of a servo by current or voltage alone.
    pub bandwidth_rad_s: f32,
    /// Half the play of its gear and a step of its encoder, at its joint, rad (of slides, m); 0 for no rest zone. Those
    /// of all servos at a joint add up. Of a servo by current or voltage alone.
    pub rest_rad: f32,
    /// Temperatures.
    pub heat: HeatSettings,
    /// Voltages; of each servo, since a plug may be loose.
    pub supply: SupplySettings,
    /// Its winding.
    pub winding: WindingSettings,
    /// Current at stall, A: of a servo by position that tells its load alone, load is a part of it.
    pub stall_a: f32,
    /// Torque at stall, N m: where the rig asks for less, its own limit must be lower.
    pub stall_nm: f32,
    /// Where its kind switches itself off, degC: its own limit must be that.
    pub shutdown_c: f32,
}

impl ServoSetup {
    /// What this servo must hold in its registers: with anything else the rig is not armed.
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

/// What is known when the board starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Starts of the board, counted.
    pub count: u32,
    /// Why it starts, if that is a fault: watchdog, brown-out, panic.
    pub causes: FaultSet,
    /// Faults that storage has kept.
    pub log: FaultLog<LOGGED>,
}

/// The first start, by power.
impl Default for Start {
    fn default() -> Self {
        Self { count: 0, causes: FaultSet::EMPTY, log: FaultLog::default() }
    }
}
