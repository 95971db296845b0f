//! Servos that take the whole effort: as a current, or (`voltage`) as the voltage that drives that current.

use sinew_core::tracker::Timing;
use sinew_rig::limited::Limited;
use sinew_rig::servo::Servo;
use sinew_servo_bus::Command;

use super::{Class, Condition, CutOff, Encoder, Limit, Refused, ServoCommand, ShaftTarget};
use crate::SettingError;

/// What is less than this is no torque constant of a geared servo, N m/A: the smallest hobby servo has 0.3.
const LEAST_CONSTANT_NM_A: f32 = 0.01;
/// Time in which the current comes and goes where it is cut off, s.
const FADE_S: f32 = 0.2;
/// How fast the shaft is to return, 1/s: an error of the tracker's gains (200 /s², critically damped) decays so.
const RETURN_PER_S: f32 = 7.07;

/// How a servo in current mode is driven.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CurrentSettings {
    /// Its encoder.
    pub encoder: Encoder,
    /// How far the shaft may be from its target before friction on the way back is fed forward, rad at the servo: half
    /// the play of its gear and a step of its encoder. 10 for a play that is not known: no error is as large.
    pub blind_rad: f32,
    /// The most current either way, A.
    pub current_a: f32,
    /// When it gives less.
    pub cut_off: CutOff,
}

/// Current control: feed-forward and feedback effort, and the friction at the wanted speed
/// ([`Servo::shaft_friction`]), through the gear and over the torque constant.
///
/// The wanted speed is that of the target, and of the way back to it: 7 /s of the error beyond what the encoder tells
/// (the reference velocity of Slotine and Li, "On the Adaptive Control of Robot Manipulators", 1987). So stiction does
/// not hold a joint that is off until the observer has learnt it.
///
/// Beyond an end of its range it gives no torque outwards. Without fresh readings, and where it is hot, the current
/// fades to nothing: the loop is closed by the tracker, and a servo in current mode holds nothing by itself. O(1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurrentDrive {
    servo: Servo,
    settings: CurrentSettings,
    dt_s: f32,
    share: f32,
}

impl CurrentDrive {
    /// At one tick of latency, which a bus takes: what the tracker's recommended setting bears, see
    /// [`MAX_DELAY_S`](sinew_core::tracker::MAX_DELAY_S).
    pub const LEAST_HZ: f32 = Class::Current.least_hz();

    /// A drive of a servo. `timing`: the tracker's. What is read in one tick acts in the next, so its latency is at
    /// least one tick; where a bus reads each servo every n ticks it is n.
    ///
    /// # Errors
    /// [`Refused`] if readings come too late for the tracker's loop, the torque constant is not known, the range goes
    /// over the encoder's seam, or a number cannot be.
    pub fn new(servo: &Servo, settings: &CurrentSettings, timing: Timing) -> Result<Self, Refused> {
        Self::of_class(Class::Current, servo, settings, timing)
    }

    /// The same of a class that turns the current into something else.
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

    /// Begins anew: the current rises from nothing.
    pub fn begin(&mut self) {
        self.share = 0.0;
    }

    /// A tick. Numbers are finite: [`Drives`](super::Drives) checks them.
    pub fn command(&mut self, target: &ShaftTarget, condition: &Condition) -> ServoCommand {
        let (mut current_a, mut limit) = self.current(target, condition);
        let (share, cut) = self.share(condition);
        if self.is_outwards(current_a, condition) {
            (current_a, limit) = (0.0, Some(Limit::Range));
        }
        ServoCommand { command: Command::Current(current_a * share), limit: cut.or(limit) }
    }

    /// The current that gives the effort, A, and what limits it.
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

    /// Returns what part of the current age of readings and heat allow, 0 to 1, and why it is not all; it fades. Called
    /// once a tick.
    pub(super) fn share(&mut self, condition: &Condition) -> (f32, Option<Limit>) {
        let (share, cut) = self.settings.cut_off.share(condition, self.dt_s);
        let step = self.dt_s / FADE_S;
        self.share = share.max(self.share - step).min(self.share + step);
        (self.share, cut)
    }

    /// The speed at which the shaft is to return to its target.
    fn way_back_rad_s(&self, target: &ShaftTarget, condition: &Condition) -> f32 {
        let Some(read) = condition.feedback else { return 0.0 };
        let own_rad = read.position_rad - self.settings.encoder.zero_rad;
        let off_rad = target.position_rad - self.servo.shaft_position(own_rad);
        let blind_rad = self.settings.blind_rad / self.servo.settings().gear.abs();
        RETURN_PER_S * (off_rad - off_rad.max(-blind_rad).min(blind_rad))
    }

    /// Whether a current or a voltage drives the servo on, beyond an end of its range.
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
