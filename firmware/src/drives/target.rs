//! Servos that take a target and tell nothing: hobby servos.

use sinew_core::tracker::Timing;
use sinew_rig::servo::Servo;
use sinew_servo_bus::Command;

use super::follower::Follower;
use super::{Class, Encoder, Refused, ServoCommand, ShaftTarget};

/// How a servo without feedback is driven.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TargetSettings {
    /// Its encoder, of a servo on a bus. None of a hobby servo: the range of its pulses is in its own positions.
    pub encoder: Option<Encoder>,
}

/// The target alone, within range, speed and acceleration: for hobby servos, which tell nothing, and for any other
/// whose stiffness is not known. Nothing that such a servo does comes back, so no effort is turned into anything. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetDrive {
    servo: Servo,
    settings: TargetSettings,
    follower: Follower,
}

impl TargetDrive {
    /// The rate of the pulses of an analog servo.
    pub const LEAST_HZ: f32 = Class::Target.least_hz();

    /// A drive of a servo.
    ///
    /// # Errors
    /// [`Refused`] if the rate is too low, or the range goes over the encoder's seam.
    pub fn new(servo: &Servo, settings: &TargetSettings, timing: Timing) -> Result<Self, Refused> {
        Refused::check_rate(Class::Target, timing)?;
        if let Some(encoder) = settings.encoder {
            encoder.check(servo)?;
        }
        let follower = Follower::new(servo, timing.dt_s);
        Ok(Self { servo: *servo, settings: *settings, follower })
    }

    /// Begins anew at an own position, rad: where the servo is, or was last sent.
    pub fn begin(&mut self, own_rad: f32) {
        self.follower.begin(own_rad);
    }

    /// A tick. Numbers are finite: [`Drives`](super::Drives) checks them.
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
        // Positions of pulses are the servo's own.
        self.settings.encoder.unwrap_or(Encoder { zero_rad: 0.0, turn_rad: 0.0 })
    }
}
