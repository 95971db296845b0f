//! Servos that accept a target and report nothing: hobby servos.

use sinew_core::tracker::Timing;
use sinew_rig::servo::Servo;
use sinew_servo_bus::Command;

use super::follower::Follower;
use super::{Class, Encoder, Refused, ServoCommand, ShaftTarget};

/// Settings of a servo without feedback.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TargetSettings {
    /// Encoder of a servo on a bus. `None` for a hobby servo: the range of its pulses is defined in its own
    /// positions.
    pub encoder: Option<Encoder>,
}

/// Control by the target alone, within range, speed and acceleration. It is meant for hobby servos, which report
/// nothing, and for servos of unknown stiffness. Efforts are not used. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetDrive {
    servo: Servo,
    settings: TargetSettings,
    follower: Follower,
}

impl TargetDrive {
    /// Minimum control rate, Hz: the pulse rate of an analog servo.
    pub const LEAST_HZ: f32 = Class::Target.least_hz();

    /// Creates the drive of a servo.
    ///
    /// # Errors
    /// [`Refused`] if the rate is too low, a setting of the encoder is invalid, or the range crosses the encoder's
    /// seam.
    pub fn new(servo: &Servo, settings: &TargetSettings, timing: Timing) -> Result<Self, Refused> {
        Refused::check_rate(Class::Target, timing)?;
        if let Some(encoder) = settings.encoder {
            encoder.check(servo)?;
        }
        let follower = Follower::new(servo, timing.dt_s);
        Ok(Self { servo: *servo, settings: *settings, follower })
    }

    /// Restarts at the servo's own position, rad: its measured position or its last commanded position.
    pub fn begin(&mut self, own_rad: f32) {
        self.follower.begin(own_rad);
    }

    /// Computes the command of a tick. Numbers must be finite: [`Drives`](super::Drives) checks them.
    pub fn command(&mut self, target: &ShaftTarget) -> ServoCommand {
        let gear = self.servo.settings().gear;
        let own_rad = gear * target.position_rad + self.servo.settings().offset_rad;
        let (at_rad, limit) = self.follower.step(own_rad, gear * target.velocity_rad_s);
        ServoCommand { command: Command::Position(at_rad + self.encoder().zero_rad), limit }
    }

    pub(super) fn sent_rad(&self) -> f32 {
        self.follower.position_rad()
    }

    pub(super) fn servo(&self) -> &Servo {
        &self.servo
    }

    pub(super) fn encoder(&self) -> Encoder {
        // For pulses, positions on the bus are the servo's own positions.
        self.settings.encoder.unwrap_or(Encoder { zero_rad: 0.0, turn_rad: 0.0 })
    }
}
