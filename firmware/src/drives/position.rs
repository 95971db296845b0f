//! Servos in position mode: the target, and what gravity makes it sag taken off in advance.

use sinew_core::tracker::Timing;
use sinew_rig::servo::Servo;
use sinew_servo_bus::Command;

use super::follower::Follower;
use super::{Class, Condition, CutOff, Encoder, Limit, Refused, ServoCommand, ShaftTarget};
use crate::SettingError;

/// A profile is this much faster than the goal moves, so that the servo catches up after a packet that was lost.
const HASTE: f32 = 1.1;

/// How a servo in position mode is driven.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PositionSettings {
    /// Its encoder.
    pub encoder: Encoder,
    /// The servo's P gain over that which its stiffness is known for, as it left the factory: it may be read from the
    /// servo.
    pub gain_ratio: f32,
    /// Torque that a speed of the servo takes besides friction, N m s: the back-EMF of a motor at a voltage, which is
    /// its torque at stall over its speed without load.
    pub drag_nm_s: f32,
    /// The largest offset either way, rad. 0 for none.
    pub offset_rad: f32,
    /// The fastest change of the offset, rad/s.
    pub offset_rad_s: f32,
    /// When the offset is cut off; the target stays.
    pub cut_off: CutOff,
    /// Whether each goal comes with a speed ([`Command::PositionAt`]), so that the servo's own profile makes a smooth
    /// way of the steps of its encoder. The bus must have room for it:
    /// [`Traffic::with_goal`](sinew_servo_bus::Traffic::with_goal).
    pub profile: bool,
}

/// Offsets up to 0.35 rad (20 deg) at 5 rad/s, which friction asks for where a joint turns back, by profile, with the
/// gain as shipped.
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

/// Position control by the servo itself: the target a tick ahead, within range, speed and acceleration, and an offset
/// of the feed-forward effort, friction and back-EMF over the servo's own stiffness. A servo that holds `k` N m/rad
/// sags by `effort / k`; sent as far beyond its target, it sags onto it.
///
/// There is no feedback effort in it: see [the module](super). Without fresh readings, and where it is hot, the offset
/// fades to nothing at its own rate; the target stays. O(1).
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
    /// Ten times and more what servos follow by themselves: 2 to 4 Hz (`docs/drives.md`).
    pub const LEAST_HZ: f32 = Class::Position.least_hz();

    /// A drive of a servo.
    ///
    /// # Errors
    /// [`Refused`] if the rate is too low, the servo's stiffness is not known, the range goes over the encoder's seam,
    /// or a number cannot be.
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

    /// Begins anew from where the servo is, its own position in rad: without an offset.
    pub fn begin(&mut self, own_rad: f32) {
        self.follower.begin(own_rad);
        self.offset_rad = 0.0;
        let [least, most] = self.servo.settings().range_rad;
        self.goal_rad = own_rad.max(least).min(most);
    }

    /// A tick. Numbers are finite: [`Drives`](super::Drives) checks them.
    pub fn command(&mut self, target: &ShaftTarget, condition: &Condition) -> ServoCommand {
        let gear = self.servo.settings().gear;
        // Where it is to be when the next goal comes: until then the servo has this one.
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

    /// Brings the offset nearer to what the effort needs; says what limits it.
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

    /// How far beyond its target the servo is sent now, at its own shaft, rad.
    pub fn offset_rad(&self) -> f32 {
        self.offset_rad
    }

    /// Without its offset.
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
