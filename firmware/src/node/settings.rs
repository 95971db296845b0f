//! Settings of a node: numbers, each with a key that never changes.

use heapless::Vec;
use sinew_link::LiveSettings;
use sinew_servo_bus::Schedule;

use crate::SettingError;
use crate::controller::ControllerSettings;

/// Version of the settings' meaning.
pub const SETTINGS_SCHEMA: u16 = 1;

/// Length of a setting: key as u16 and value as f32, little-endian, bytes.
const EACH: usize = 6;

/// Maximum length of all settings, bytes.
pub const SETTINGS_MAX: usize = EACH * SETTING_NAMES.len();

/// Names of all settings, which end with the unit. The first has key 1.
pub const SETTING_NAMES: [&str; 21] = [
    "link_hold_s",
    "link_limp_s",
    "enable_s",
    "arming_s",
    "blend_s",
    "stop_s",
    "lower_s",
    "soft_rad_s",
    "stop_rad_s",
    "maintenance_rad_s",
    "following_most_rad",
    "following_time_s",
    "stale_s",
    "blind_s",
    "beyond_rad",
    "live_delay_s",
    "live_stale_s",
    "float_rad_s",
    "swing_gain",
    "lower_rad_s",
    "supply_a",
];

/// Meaning of each of [`SETTING_NAMES`], for users. A board itself stores no texts.
pub const SETTING_TEXTS: [&str; SETTING_NAMES.len()] = [
    "time without a message of the host after which the rig holds",
    "time without a message after which the rig is lowered, and without an acknowledgement after which it is stopped",
    "time for which a `HoldToRun` and a `Jog` are valid",
    "time in which torque comes on, and the pose settles, before the rig holds",
    "time of the blend from one source of poses to another",
    "longest time of the motion to the rest pose; then the rig is lowered where it is",
    "time in which the carried weight fades while nothing moves; torque is off after six times this",
    "speed of the fastest joint from rest until it has reached its feed, and in jogging",
    "speed of the fastest joint on the way to the rest pose",
    "speed of the fastest joint in maintenance",
    "distance from its target at which a servo counts as not following",
    "time for which a servo may be that far from its target",
    "a reading older than this is not valid; at least the time between two readings",
    "a servo whose voltage and temperature were not read for longer than this is silent",
    "how far beyond its range a servo may be measured",
    "how long after the fastest frame a pose of a live source is played",
    "time without a new frame after which a live source is stale",
    "speed of the fastest joint that is led by hand while the rig carries itself",
    "factor to which the feedback of a joint that swings is lowered",
    "speed of the fastest joint while the rig is lowered",
    "current of the supply: a rig that needs more to be held is not armed; 0 if it is not known",
];

/// Settings of a node that can be changed. The rest of [`ControllerSettings`] is fixed by the board: bus, servos,
/// tracker.
#[derive(Debug, Clone)]
pub struct NodeSettings {
    /// Settings of the control loop.
    pub controller: ControllerSettings,
    /// Time from the arrival of a frame without jitter to the tick that plays its pose, s.
    pub live_delay_s: f32,
    /// Time without a new frame after which a stream is late, s.
    pub live_stale_s: f32,
    /// Schedule of the board's bus, which limits the settings.
    schedule: Schedule,
}

/// A reason why settings are refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum SettingsError {
    /// The length is not that of a whole number of settings.
    Length {
        /// Number of bytes.
        found: usize,
    },
    /// The key does not exist, or appears twice.
    Key {
        /// The key.
        found: u16,
    },
    /// A value is invalid.
    Value(SettingError),
}

impl core::fmt::Display for SettingsError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length { found } => write!(f, "settings have 6 bytes each, these are {found}"),
            Self::Key { found } => write!(f, "there is no setting {found}, or it comes twice"),
            Self::Value(why) => why.fmt(f),
        }
    }
}

impl core::error::Error for SettingsError {}

impl From<SettingError> for SettingsError {
    fn from(error: SettingError) -> Self {
        Self::Value(error)
    }
}

impl NodeSettings {
    /// Creates the board's own settings for its bus. They are used until others are stored.
    pub fn new(controller: ControllerSettings, schedule: Schedule) -> Self {
        let LiveSettings { delay_us, stale_us, .. } = LiveSettings::DEFAULT;
        let seconds = |us: u32| us as f32 * 1e-6;
        let (live_delay_s, live_stale_s) = (seconds(delay_us), seconds(stale_us));
        Self { controller, live_delay_s, live_stale_s, schedule }
    }

    /// Returns a setting by its key, or `None` if the key does not exist.
    pub fn get(&self, key: u16) -> Option<f32> {
        self.clone().field(key).copied()
    }

    /// Returns the settings with one of them changed.
    ///
    /// # Errors
    /// [`SettingsError`] if there is no such setting, or the value is invalid or NaN.
    pub fn with(&self, key: u16, value: f32) -> Result<Self, SettingsError> {
        let mut changed = self.clone();
        *changed.field(key).ok_or(SettingsError::Key { found: key })? = value;
        changed.check()?;
        Ok(changed)
    }

    /// Reads settings. Settings that are missing in the bytes keep their current values.
    ///
    /// # Errors
    /// [`SettingsError`] names the invalid setting, or the number of bytes if it is wrong.
    pub fn read(&self, bytes: &[u8]) -> Result<Self, SettingsError> {
        let mut read = self.clone();
        let (all, rest) = bytes.as_chunks::<EACH>();
        if !rest.is_empty() || all.len() > SETTING_NAMES.len() {
            return Err(SettingsError::Length { found: bytes.len() });
        }
        let mut last = 0;
        for [k0, k1, value @ ..] in all {
            let found = u16::from_le_bytes([*k0, *k1]);
            // Keys must increase, so that none appears twice.
            let field = read.field(found).filter(|_| found > last);
            *field.ok_or(SettingsError::Key { found })? = f32::from_le_bytes(*value);
            last = found;
        }
        read.check()?;
        Ok(read)
    }

    /// Returns all settings as bytes, in the order of their keys.
    pub fn bytes(&self) -> Vec<u8, SETTINGS_MAX> {
        let (mut copy, mut out) = (self.clone(), Vec::new());
        for (key, _) in (1_u16..).zip(SETTING_NAMES) {
            if let Some(value) = copy.field(key) {
                // There is room for all settings.
                let _ = out.extend_from_slice(&key.to_le_bytes());
                let _ = out.extend_from_slice(&value.to_le_bytes());
            }
        }
        out
    }

    /// Returns the settings of the live stream; its tick is the loop's.
    pub fn live(&self) -> LiveSettings {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
        let us = |seconds: f32| (seconds * 1e6 + 0.5) as u32;
        LiveSettings {
            delay_us: us(self.live_delay_s),
            stale_us: us(self.live_stale_s),
            ..LiveSettings::DEFAULT
        }
    }

    /// Returns the key of a setting by its name, or `None` if the name does not exist.
    pub(super) fn key(name: &str) -> Option<u16> {
        (1..).zip(SETTING_NAMES).find(|(_, own)| *own == name).map(|(key, _)| key)
    }

    fn field(&mut self, key: u16) -> Option<&mut f32> {
        let ControllerSettings {
            supervisor,
            following,
            stale_s,
            blind_s,
            beyond_rad,
            swing_gain,
            supply_a,
            ..
        } = &mut self.controller;
        Some(match key {
            1 => &mut supervisor.link_hold_s,
            2 => &mut supervisor.link_limp_s,
            3 => &mut supervisor.enable_s,
            4 => &mut supervisor.arming_s,
            5 => &mut supervisor.blend_s,
            6 => &mut supervisor.stop_s,
            7 => &mut supervisor.lower_s,
            8 => &mut supervisor.soft_rad_s,
            9 => &mut supervisor.stop_rad_s,
            10 => &mut supervisor.maintenance_rad_s,
            11 => &mut following.most_rad,
            12 => &mut following.time_s,
            13 => stale_s,
            14 => blind_s,
            15 => beyond_rad,
            16 => &mut self.live_delay_s,
            17 => &mut self.live_stale_s,
            18 => &mut supervisor.float_rad_s,
            19 => swing_gain,
            20 => &mut supervisor.lower_rad_s,
            21 => supply_a,
            _ => return None,
        })
    }

    /// Checks that the next start would accept the settings.
    fn check(&self) -> Result<(), SettingError> {
        self.controller.check(&self.schedule)?;
        SettingError::check("live_delay_s", self.live_delay_s, [0.0, 2.0])?;
        SettingError::check("live_stale_s", self.live_stale_s, [0.01, 2.0])
    }
}
