//! Settings of the supervisor, which are checked once.

use crate::SettingError;

const DEG: f32 = core::f32::consts::PI / 180.0;

/// Maximum soft speed, rad/s: 20 deg/s.
pub const SOFT_MOST_RAD_S: f32 = 20.0 * DEG;

/// Maximum duration of lowering as a multiple of [`Settings::lower_s`], in general, and if the supply is low or a
/// servo is hot.
pub const LOWER_MOST: [f32; 2] = [6.0, 2.0];

/// Time-outs of the supervisor, and maximum speeds of joints.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// Time without a valid message after which the rig holds, s.
    pub link_hold_s: f32,
    /// Time without a valid message after which the rig is lowered, s. It must be more than `link_hold_s`.
    pub link_limp_s: f32,
    /// Time for which the enabling button counts as held after each of its messages, s.
    pub enable_s: f32,
    /// Duration of arming, in which torque comes on and the pose settles, s.
    pub arming_s: f32,
    /// Duration of the blend from one source to another, s.
    pub blend_s: f32,
    /// Maximum time for moving to the rest pose, s. After it the rig is lowered where it is.
    pub stop_s: f32,
    /// Time in which the carried weight fades while nothing moves, s. Torque is off after at most [`LOWER_MOST`]
    /// times this.
    pub lower_s: f32,
    /// Maximum speed of a joint from standstill until it has reached its feed, and of jogging, rad/s.
    pub soft_rad_s: f32,
    /// Maximum speed of a joint on the way to the rest pose, rad/s.
    pub stop_rad_s: f32,
    /// Maximum speed of a joint while the rig is lowered, rad/s.
    pub lower_rad_s: f32,
    /// Maximum speed of a joint in maintenance, rad/s.
    pub maintenance_rad_s: f32,
    /// Maximum speed of a joint that is led by hand while the rig carries itself, rad/s: above it the rig is lowered.
    pub float_rad_s: f32,
}

/// By default, the rig holds after 0.2 s without a message, and is lowered after 2 s. The button counts as held for
/// 0.2 s. Arming takes 1 s, a blend 1 s, the way to the rest pose at most 10 s, and lowering at least 3 s. The
/// maximum speeds are 20 deg/s from standstill, 30 deg/s to the rest pose and while lowering, 10 deg/s in
/// maintenance, and 180 deg/s by hand.
impl Default for Settings {
    fn default() -> Self {
        Self {
            link_hold_s: 0.2,
            link_limp_s: 2.0,
            enable_s: 0.2,
            arming_s: 1.0,
            blend_s: 1.0,
            stop_s: 10.0,
            lower_s: 3.0,
            soft_rad_s: SOFT_MOST_RAD_S,
            stop_rad_s: 30.0 * DEG,
            lower_rad_s: 30.0 * DEG,
            maintenance_rad_s: 10.0 * DEG,
            float_rad_s: 180.0 * DEG,
        }
    }
}

impl Settings {
    /// Returns an error if a setting is invalid or NaN.
    pub(crate) fn check(&self) -> Result<(), SettingError> {
        let least_rad_s = 0.1 * DEG;
        SettingError::check("link_hold_s", self.link_hold_s, [0.01, 2.0])?;
        SettingError::check("link_limp_s", self.link_limp_s, [self.link_hold_s + 0.01, 60.0])?;
        SettingError::check("enable_s", self.enable_s, [0.02, 0.5])?;
        SettingError::check("arming_s", self.arming_s, [0.1, 60.0])?;
        SettingError::check("blend_s", self.blend_s, [0.1, 60.0])?;
        SettingError::check("stop_s", self.stop_s, [0.1, 60.0])?;
        SettingError::check("lower_s", self.lower_s, [0.0, 60.0])?;
        SettingError::check("soft_rad_s", self.soft_rad_s, [least_rad_s, SOFT_MOST_RAD_S])?;
        SettingError::check("stop_rad_s", self.stop_rad_s, [least_rad_s, 90.0 * DEG])?;
        SettingError::check("lower_rad_s", self.lower_rad_s, [least_rad_s, 90.0 * DEG])?;
        SettingError::check(
            "maintenance_rad_s",
            self.maintenance_rad_s,
            [least_rad_s, SOFT_MOST_RAD_S],
        )?;
        SettingError::check("float_rad_s", self.float_rad_s, [least_rad_s, 360.0 * DEG])
    }
}
