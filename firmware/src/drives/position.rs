//! Servos in position mode: the target plus an offset that compensates the expected sag.

use sinew_core::tracker::Timing;
use sinew_rig::servo::Servo;
use sinew_servo_bus::Command;

use super::follower::Follower;
use super::{Class, Condition, CutOff, Encoder, Limit, Refused, ServoCommand, ShaftTarget};
use crate::SettingError;

/// Ratio of a profile's speed to the goal's speed. Above 1, so that the servo catches up after a lost packet.
const HASTE: f32 = 1.1;

/// Settings of a servo in position mode.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PositionSettings {
    /// Encoder of the servo.
    pub encoder: Encoder,
    /// Ratio of the servo's P gain to the factory setting, for which its stiffness is known. The P gain can be read
    /// from the servo.
    pub gain_ratio: f32,
    /// Torque per speed of the servo in addition to friction, N m s. It is the effect of the motor's back-EMF at a
    /// constant voltage: the stall torque divided by the speed without load.
    pub drag_nm_s: f32,
    /// Maximum offset in either direction, rad. 0 switches the offset off.
    pub offset_rad: f32,
    /// Maximum rate of change of the offset, rad/s.
    pub offset_rad_s: f32,
    /// Limits at which the offset is reduced; the target stays unchanged.
    pub cut_off: CutOff,
    /// Whether each goal has a speed ([`Command::PositionAt`]), so that the servo's own profile smooths the steps of
    /// its encoder. The bus must have room for it: [`Traffic::with_goal`](sinew_servo_bus::Traffic::with_goal).
    pub profile: bool,
}

/// The default offset is at most 0.35 rad (20 deg), and changes by at most 5 rad/s, which friction requires when a
/// joint reverses. Goals have a profile, and the servo has the factory's gain.
impl Default for PositionSettings {
    fn default() -> Self {
        Self {
            encoder: Encoder::default(),
            gain_ratio: 1.0,
            drag_nm_s: 0.0,
            offset_rad: 0.35,
            offset_rad_s: 5.0,
            cut_off: CutOff::default(),
            profile: true,
        }
    }
}

/// Position control by the servo itself. The goal is the target of the next tick, within range, speed and
/// acceleration, plus an offset: feed-forward effort, friction and back-EMF divided by the servo's own stiffness. A
/// servo with a stiffness of `k` N m/rad sags by `effort / k`. If its goal is that far beyond the target, it sags
/// exactly to the target.
///
/// There is no feedback effort: see [the module](super). Without fresh readings, and if the servo is hot, the offset
/// fades to zero at its own rate; the target stays. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionDrive {
    servo: Servo,
    settings: PositionSettings,
    dt_s: f32,
    stiffness_nm_rad: f32,
    follower: Follower,
    offset_rad: f32,
    goal_rad: f32,
}

impl PositionDrive {
    /// Minimum control rate, Hz: at least ten times the bandwidth of position servos, 2 to 4 Hz (`docs/drives.md`).
    pub const LEAST_HZ: f32 = Class::Position.least_hz();

    /// Creates the drive of a servo.
    ///
    /// # Errors
    /// [`Refused`] if the rate is too low, the servo's stiffness is not known, the range crosses the encoder's seam,
    /// or a number is invalid.
    pub fn new(
        servo: &Servo,
        settings: &PositionSettings,
        timing: Timing,
    ) -> Result<Self, Refused> {
        Refused::check_rate(Class::Position, timing)?;
        if servo.settings().position_gain_nm_rad <= 0.0 {
            return Err(Refused::NoStiffness);
        }
        settings.encoder.check(servo)?;
        settings.cut_off.check()?;
        SettingError::check("gain_ratio", settings.gain_ratio, [0.01, 100.0])?;
        SettingError::check("drag_nm_s", settings.drag_nm_s, [0.0, 1e4])?;
        SettingError::check("offset_rad", settings.offset_rad, [0.0, 1.0])?;
        SettingError::check("offset_rad_s", settings.offset_rad_s, [0.01, 100.0])?;
        let mut drive = Self {
            servo: *servo,
            settings: *settings,
            dt_s: timing.dt_s,
            stiffness_nm_rad: servo.settings().position_gain_nm_rad * settings.gain_ratio,
            follower: Follower::new(servo, timing.dt_s),
            offset_rad: 0.0,
            goal_rad: 0.0,
        };
        drive.begin(0.0);
        Ok(drive)
    }

    /// Restarts at the servo's own position, rad, without an offset.
    pub fn begin(&mut self, own_rad: f32) {
        self.follower.begin(own_rad);
        self.offset_rad = 0.0;
        let [least, most] = self.servo.settings().range_rad;
        self.goal_rad = own_rad.max(least).min(most);
    }

    /// Computes the command of a tick. Numbers must be finite: [`Drives`](super::Drives) checks them.
    pub fn command(&mut self, target: &ShaftTarget, condition: &Condition) -> ServoCommand {
        let gear = self.servo.settings().gear;
        // Uses the position for the time at which the next goal arrives: the servo follows this goal until then.
        let ahead_rad = target.position_rad + target.velocity_rad_s * self.dt_s;
        let own_rad = gear * ahead_rad + self.servo.settings().offset_rad;
        let (at_rad, followed) = self.follower.step(own_rad, gear * target.velocity_rad_s);
        let friction_nm = self.servo.shaft_friction(target.velocity_rad_s).unwrap_or(0.0);
        let drag_nm = self.settings.drag_nm_s * gear * gear * target.velocity_rad_s;
        let offset_limit =
            self.follow_offset(target.feedforward_nm + friction_nm + drag_nm, condition);

        let [least, most] = self.servo.settings().range_rad;
        let wanted_rad = at_rad + self.offset_rad;
        let goal_rad = wanted_rad.max(least).min(most);
        let is_held = (goal_rad - wanted_rad).abs() > 0.0;
        let way_rad = (goal_rad - self.goal_rad).abs();
        self.goal_rad = goal_rad;
        let limit = if is_held { Some(Limit::Range) } else { offset_limit.or(followed) };
        let position_rad = goal_rad + self.settings.encoder.zero_rad;
        let command = if self.settings.profile {
            let speed_rad_s = HASTE * way_rad / self.dt_s;
            Command::PositionAt { position_rad, speed_rad_s }
        } else {
            Command::Position(position_rad)
        };
        ServoCommand { command, limit }
    }

    /// Moves the offset towards the value that the effort needs. Returns the limit that was reached, if any.
    fn follow_offset(&mut self, shaft_nm: f32, condition: &Condition) -> Option<Limit> {
        let (share, mut limit) = self.settings.cut_off.share(condition, self.dt_s);
        let most = self.settings.offset_rad;
        let full = shaft_nm / self.servo.settings().gear / self.stiffness_nm_rad;
        let held = full.max(-most).min(most);
        if (held - full).abs() > 0.0 {
            limit = limit.or(Some(Limit::Offset));
        }
        let wanted = held * share;
        let step = self.settings.offset_rad_s * self.dt_s;
        let next = wanted.max(self.offset_rad - step).min(self.offset_rad + step);
        if (next - wanted).abs() > 0.0 {
            limit = limit.or(Some(Limit::OffsetRate));
        }
        self.offset_rad = next;
        limit
    }

    /// Returns the current offset of the goal beyond the target, at the servo's own shaft, rad.
    pub fn offset_rad(&self) -> f32 {
        self.offset_rad
    }

    /// Returns the last commanded position without its offset, rad.
    pub(super) fn sent_rad(&self) -> f32 {
        self.follower.position_rad()
    }

    pub(super) fn servo(&self) -> &Servo {
        &self.servo
    }

    pub(super) fn encoder(&self) -> Encoder {
        self.settings.encoder
    }
}
