//! Servos that accept the whole effort: as a current, or (see `voltage`) as the voltage that drives this current.

use sinew_core::tracker::Timing;
use sinew_rig::limited::Limited;
use sinew_rig::servo::Servo;
use sinew_servo_bus::Command;

use super::{Class, Condition, CutOff, Encoder, Limit, Refused, ServoCommand, ShaftTarget};
use crate::SettingError;

/// Smallest valid torque constant of a geared servo, N m/A: the smallest hobby servo has 0.3.
const LEAST_CONSTANT_NM_A: f32 = 0.01;
/// Time in which the current fades out or in at a cut-off, s.
const FADE_S: f32 = 0.2;
/// Rate at which the shaft returns to its target, 1/s: errors decay at this rate with the tracker's gains (200 /s²,
/// critically damped).
const RETURN_PER_S: f32 = 7.07;

/// Settings of a servo in current mode.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CurrentSettings {
    /// Encoder of the servo.
    pub encoder: Encoder,
    /// Maximum distance of the shaft from its target, rad at the servo, for which the friction of the return to the
    /// target is not fed forward: half the play of the gear and a step of the encoder. If the play is not known,
    /// use 10: no error is as large.
    pub blind_rad: f32,
    /// Maximum current in either direction, A.
    pub current_a: f32,
    /// Limits at which the current is reduced.
    pub cut_off: CutOff,
}

/// Current control: the sum of feed-forward effort, feedback effort and friction at the wanted speed
/// ([`Servo::shaft_friction`]) is converted by the gear and divided by the torque constant.
///
/// The wanted speed is the target's speed plus the speed of the return to the target: 7 rad/s per rad of the error
/// beyond the encoder's uncertainty (the reference velocity of Slotine and Li, "On the Adaptive Control of Robot
/// Manipulators", 1987). Because of it, stiction does not hold a joint away from its target until the observer has
/// learnt the friction.
///
/// Beyond an end of its range the drive gives no torque outwards. Without fresh readings, and if the servo is hot,
/// the current fades to zero: the tracker closes the loop, and a servo in current mode holds nothing by itself. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurrentDrive {
    servo: Servo,
    settings: CurrentSettings,
    dt_s: f32,
    share: f32,
}

impl CurrentDrive {
    /// Minimum control rate, Hz, with the latency of one tick that a bus causes. It follows from the maximum delay
    /// of the tracker's recommended setting, see [`MAX_DELAY_S`](sinew_core::tracker::MAX_DELAY_S).
    pub const LEAST_HZ: f32 = Class::Current.least_hz();

    /// Creates the drive of a servo. `timing` is the tracker's timing. A reading of a tick takes effect in the next
    /// tick, so its latency is at least one tick; where a bus reads each servo every n ticks, the latency is n.
    ///
    /// # Errors
    /// [`Refused`] if readings arrive too late for the tracker's loop, the torque constant is not known, the range
    /// crosses the encoder's seam, or a number is invalid.
    pub fn new(servo: &Servo, settings: &CurrentSettings, timing: Timing) -> Result<Self, Refused> {
        Self::of_class(Class::Current, servo, settings, timing)
    }

    /// Creates the drive for a class that converts the current into another command.
    pub(super) fn of_class(
        class: Class,
        servo: &Servo,
        settings: &CurrentSettings,
        timing: Timing,
    ) -> Result<Self, Refused> {
        Refused::check_rate(class, timing)?;
        let late = Timing { latency_ticks: timing.latency_ticks.max(1), ..timing };
        if late.check_recommended().is_err() {
            return Err(Refused::TooSlow { class, least_hz: class.least_hz() });
        }
        if servo.settings().torque_constant_nm_a < LEAST_CONSTANT_NM_A {
            return Err(Refused::NoTorqueConstant);
        }
        settings.encoder.check(servo)?;
        settings.cut_off.check()?;
        SettingError::check("blind_rad", settings.blind_rad, [0.0, 10.0])?;
        SettingError::check("current_a", settings.current_a, [0.0, 100.0])?;
        Ok(Self { servo: *servo, settings: *settings, dt_s: timing.dt_s, share: 0.0 })
    }

    /// Restarts the drive: the current rises from zero.
    pub fn begin(&mut self) {
        self.share = 0.0;
    }

    /// Computes the command of a tick. Numbers must be finite: [`Drives`](super::Drives) checks them.
    pub fn command(&mut self, target: &ShaftTarget, condition: &Condition) -> ServoCommand {
        let (mut current_a, mut limit) = self.current(target, condition);
        let (share, cut) = self.share(condition);
        if self.is_outwards(current_a, condition) {
            (current_a, limit) = (0.0, Some(Limit::Range));
        }
        ServoCommand { command: Command::Current(current_a * share), limit: cut.or(limit) }
    }

    /// Returns the current for the effort, A, and the limit that was reached, if any.
    pub(super) fn current(
        &self,
        target: &ShaftTarget,
        condition: &Condition,
    ) -> (f32, Option<Limit>) {
        let speed_rad_s = target.velocity_rad_s + self.way_back_rad_s(target, condition);
        let friction_nm = self.servo.shaft_friction(speed_rad_s).unwrap_or(0.0);
        let shaft_nm = target.feedforward_nm + target.feedback_nm + friction_nm;
        let torque =
            self.servo.own_torque(shaft_nm).unwrap_or(Limited { value: 0.0, reason: None });
        let mut limit = torque.reason.map(Limit::from);
        let mut current_a = torque.value / self.servo.settings().torque_constant_nm_a;

        let most_a = self.settings.current_a;
        if current_a.abs() > most_a {
            (current_a, limit) = (current_a.max(-most_a).min(most_a), Some(Limit::Current));
        }
        (current_a, limit)
    }

    /// Returns the permitted part of the current, 0 to 1, and the reason if it is below 1. It depends on the age of
    /// readings and on heat, and changes gradually. Called once per tick.
    pub(super) fn share(&mut self, condition: &Condition) -> (f32, Option<Limit>) {
        let (share, cut) = self.settings.cut_off.share(condition, self.dt_s);
        let step = self.dt_s / FADE_S;
        self.share = share.max(self.share - step).min(self.share + step);
        (self.share, cut)
    }

    /// Returns the speed at which the shaft is to return to its target, rad/s.
    fn way_back_rad_s(&self, target: &ShaftTarget, condition: &Condition) -> f32 {
        let Some(read) = condition.feedback else { return 0.0 };
        let own_rad = read.position_rad - self.settings.encoder.zero_rad;
        let off_rad = target.position_rad - self.servo.shaft_position(own_rad);
        let blind_rad = self.settings.blind_rad / self.servo.settings().gear.abs();
        RETURN_PER_S * (off_rad - off_rad.max(-blind_rad).min(blind_rad))
    }

    /// Returns whether a current or a voltage drives the servo outwards beyond an end of its range.
    pub(super) fn is_outwards(&self, wanted: f32, condition: &Condition) -> bool {
        let [least, most] = self.servo.settings().range_rad;
        condition.feedback.is_some_and(|feedback| {
            let own_rad = feedback.position_rad - self.settings.encoder.zero_rad;
            own_rad > most && wanted > 0.0 || own_rad < least && wanted < 0.0
        })
    }

    pub(super) fn servo(&self) -> &Servo {
        &self.servo
    }

    pub(super) fn encoder(&self) -> Encoder {
        self.settings.encoder
    }
}
