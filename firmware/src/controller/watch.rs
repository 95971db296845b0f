//! All fault detectors of a rig.

use heapless::Vec;
use sinew_core::tracker::STANDS_RAD_S;
use sinew_rig::board::{BoardDof, BoardRig};
use sinew_servo_bus::{Effort, Health};

use super::controller::Readings;
use super::error::ControllerError;
use super::path::Path;
use super::report::{DofReport, Following as Error, ServoReport};
use super::settings::{ControllerSettings, ServoSetup};
use crate::SettingError;
use crate::drives::{Condition, Measured};
use crate::supervisor::detect::{
    Derated, Following, Heat, Overrun, Silence, Supply, Swing, SwingSettings, Winding,
};
use crate::supervisor::{Fault, Findings, GuardSettings};

/// Time after which an unchanged target counts as standing still, s: the error of a movement has then decayed.
const STANDS_S: f32 = 0.5;

/// Checks every servo and dof, once per tick.
#[derive(Debug, Default)]
pub(super) struct Watch<const DOFS: usize, const SERVOS: usize> {
    servos: Vec<Servo, SERVOS>,
    dofs: Vec<Dof, DOFS>,
    swing: SwingSettings,
    silence: Silence,
    pub(super) overrun: Overrun,
    stale_ticks: u32,
    blind_ticks: u32,
    stands_ticks: u16,
    beyond_rad: f32,
    /// Maximum speed of a joint at which a rig is armed, rad/s.
    pub(super) rest_rad_s: f32,
    /// Maximum current of the supply, A; 0 if it is not known.
    pub(super) supply_a: f32,
}

/// Detectors of a dof.
#[derive(Debug, Clone)]
struct Dof {
    following: Following,
    swing: Swing,
    /// Index of its first servo.
    servo: u16,
    /// Number of ticks for which its target has stood still.
    stood_ticks: u16,
}

/// Detectors of a servo.
#[derive(Debug)]
struct Servo {
    guard: GuardSettings,
    stall_a: f32,
    heat: Heat,
    supply: Supply,
    winding: Winding,
    derated: Derated,
}

impl<const DOFS: usize, const SERVOS: usize> Watch<DOFS, SERVOS> {
    #[inline(never)]
    pub(super) fn new<const BODIES: usize>(
        rig: &BoardRig<BODIES, DOFS, SERVOS>,
        settings: &ControllerSettings,
        setups: &[ServoSetup],
        dt_s: f32,
    ) -> Result<Self, ControllerError> {
        let mut servos = Vec::new();
        for (index, (servo, setup)) in rig.servos().iter().zip(setups).enumerate() {
            let of = |why| ControllerError::Servo { servo: index, why };
            SettingError::check("stall_a", setup.stall_a, [1e-3, 100.0]).map_err(of)?;
            SettingError::check("stall_nm", setup.stall_nm, [1e-3, 1e4]).map_err(of)?;
            SettingError::check("shutdown_c", setup.shutdown_c, [0.0, 150.0]).map_err(of)?;
            if let Some(drive) = setup.drive.effort() {
                // Otherwise the rig would fall when the fault starts to lower it.
                let least = setup.heat.off_c;
                SettingError::check("cut_off.warm_c", drive.cut_off.warm_c, [least, 150.0])
                    .map_err(of)?;
            }
            // There is room: `SERVOS` is the maximum number of servos.
            let _ = servos.push(Servo {
                guard: GuardSettings::of(&servo.servo, &setup.drive),
                stall_a: setup.stall_a,
                heat: Heat::new(setup.heat).map_err(of)?,
                supply: Supply::new(setup.supply, dt_s).map_err(of)?,
                winding: Winding::new(setup.winding, dt_s).map_err(of)?,
                derated: Derated::FULL,
            });
        }
        let mut dofs: Vec<Dof, DOFS> = Vec::new();
        let following = Following::new(settings.following, dt_s)?;
        let dof = Dof { following, swing: Swing::default(), servo: u16::MAX, stood_ticks: 0 };
        let _ = dofs.resize(rig.dofs().len(), dof);
        for drive in rig.drives() {
            for dof in &drive.dofs {
                if let (Some(of), Some(servo)) =
                    (dofs.get_mut(usize::from(*dof)), drive.servos.first())
                {
                    of.servo = *servo;
                }
            }
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
        let ticks = |seconds: f32| (seconds / dt_s + 1e-3) as u32;
        Ok(Self {
            servos,
            dofs,
            swing: SwingSettings::new(dt_s, settings.swing_gain),
            silence: settings.silence,
            overrun: Overrun::new(settings.overrun)?,
            stale_ticks: ticks(settings.stale_s),
            blind_ticks: ticks(settings.blind_s),
            stands_ticks: u16::try_from(ticks(STANDS_S)).unwrap_or(u16::MAX),
            beyond_rad: settings.beyond_rad,
            rest_rad_s: settings.rest_rad_s(),
            supply_a: settings.supply_a,
        })
    }

    /// Restarts the detectors of dofs when the rig is armed.
    pub(super) fn begin(&mut self) {
        self.dofs.iter_mut().for_each(Dof::begin);
    }

    /// Returns the permitted part of a servo's effort.
    pub(super) fn share(&self, servo: usize) -> f32 {
        self.servos.get(servo).map_or(0.0, |servo| servo.derated.share)
    }

    /// Returns the stall current of a servo, A.
    pub(super) fn stall_a(&self, servo: usize) -> f32 {
        self.servos.get(servo).map_or(f32::INFINITY, |servo| servo.stall_a)
    }

    /// Returns the first servo of a dof, or `None` if there is no such dof. If no servo moves the dof, the index is
    /// beyond all servos.
    pub(super) fn servo(&self, dof: usize) -> Option<usize> {
        self.dofs.get(dof).map(|dof| dof.servo.into())
    }

    /// Returns whether every servo that reports has a reading that is new enough.
    pub(super) fn is_measured(&self, conditions: &[Condition]) -> bool {
        self.servos.iter().zip(conditions).all(|(servo, condition)| {
            let read = condition.feedback;
            !servo.guard.tells() || read.is_some_and(|read| read.age_ticks <= self.stale_ticks)
        })
    }

    /// Returns whether a reading is new enough.
    pub(super) fn is_fresh(&self, measured: &Measured) -> bool {
        measured.age_ticks <= self.stale_ticks
    }

    /// Returns whether a servo is silent, judged by its replies.
    pub(super) fn is_silent(&self, health: &Health) -> bool {
        self.silence.step(health.missed_in_a_row).is_some()
    }

    /// Returns the servos that report, with their stall currents.
    pub(super) fn telling(
        &self,
        conditions: &[Condition],
    ) -> impl Iterator<Item = (Condition, f32)> {
        let all = self.servos.iter().zip(conditions);
        all.filter(|(servo, _)| servo.guard.tells()).map(|(servo, read)| (*read, servo.stall_a))
    }

    /// Checks the servos in a tick. `is_on` is whether torque is on.
    pub(super) fn servos<const COORDS: usize>(
        &mut self,
        is_on: bool,
        readings: &Readings<DOFS, SERVOS, COORDS>,
        findings: &mut Findings,
        out: &mut [ServoReport],
    ) {
        let (silence, beyond_rad) = (self.silence, self.beyond_rad);
        let Readings { healths, conditions, beliefs, .. } = readings;
        let read = conditions.iter().zip(healths).zip(beliefs);
        for (index, ((servo, ((condition, health), belief)), out)) in
            self.servos.iter_mut().zip(read).zip(out).enumerate()
        {
            let name = u16::try_from(index).unwrap_or(u16::MAX);
            let mut note = |fault: Option<Fault>| {
                if let Some(fault) = fault {
                    findings.note_of(fault, name);
                }
            };
            if servo.guard.tells() {
                note(silence.step(health.missed_in_a_row));
                // Voltage and temperature are read in the time that is left.
                note((health.age_ticks > self.blind_ticks).then_some(Fault::ServoSilent));
            }
            if health.alert || health.hardware_error != 0 {
                note(Some(Fault::ServoError));
            }
            if belief.is_jumped() {
                note(Some(Fault::Jump));
            }
            if health.has_stopped {
                note(Some(Fault::ServoStopped));
            }
            if let Some(read) = condition.feedback {
                let [least, most] = servo.guard.range_rad;
                let own_rad = read.position_rad - servo.guard.zero_rad;
                if own_rad < least - beyond_rad || own_rad > most + beyond_rad {
                    note(Some(Fault::Range));
                }
            }
            let current_a = condition.feedback.map_or(0.0, |read| match read.effort {
                Effort::Current(a) => a,
                Effort::Load(part) => {
                    let by_voltage = servo.guard.winding_a(part, &read, health.voltage_v);
                    // Without torque nothing shorts the winding of a servo in PWM mode.
                    let by_voltage = by_voltage.map(|a| if is_on { a } else { 0.0 });
                    by_voltage.unwrap_or(part * servo.stall_a)
                }
            });
            let found = [
                servo.supply.step(health.voltage_v),
                servo.heat.step(health.temperature_c),
                servo.winding.step(current_a),
            ];
            for found in found {
                note(found.fault);
            }
            servo.derated = found.into_iter().fold(Derated::FULL, Derated::and);
            *out = ServoReport {
                limit: None,
                guard: None,
                share: servo.derated.share,
                concern: servo.derated.reason,
                temperature_c: health.temperature_c,
                heat: servo.winding.heat(),
                voltage_v: servo.supply.filtered_v(),
                missed: health.missed,
                not_believed: health.not_believed.saturating_add(belief.count()),
                last_error: health.last_error,
            };
        }
    }

    /// Adds a fault if a joint is beyond its range, for its first servo.
    pub(super) fn range<const COORDS: usize>(
        &self,
        path: &Path<DOFS, COORDS>,
        q: &[f32],
        findings: &mut Findings,
    ) {
        if let Some(dof) = path.beyond(q, self.beyond_rad).and_then(|dof| self.dofs.get(dof)) {
            findings.note_of(Fault::Range, dof.servo);
        }
    }

    /// Checks the distance of the measured dofs from the commands (`report`), at the commanded speeds `qd`, and whether
    /// they swing. `is_held` is whether they have their full effort. Returns the mean and the largest distance.
    pub(super) fn dofs(
        &mut self,
        own: &[BoardDof],
        qd: &[f32],
        measured: &[Option<Measured>],
        is_held: bool,
        findings: &mut Findings,
        report: &mut [DofReport],
    ) -> Error {
        let (mut error, mut sum, mut count) = (Error::default(), 0.0, 0.0);
        let dofs = self.dofs.iter_mut().zip(own.iter().zip(qd)).zip(measured).zip(report);
        for (index, (((dof, (own, speed)), measured), report)) in dofs.enumerate() {
            let Some(measured) = measured else { continue };
            let off = report.error;
            (sum, count) = (sum + off.abs(), count + 1.0);
            if off.abs() > error.most_rad {
                error.most_rad = off.abs();
                error.dof = u16::try_from(index).unwrap_or(u16::MAX);
            }
            if !is_held {
                dof.begin();
                continue;
            }
            if let Some(fault) = dof.following.step(off) {
                findings.note_of(fault, dof.servo);
            }
            let still = speed.abs() < STANDS_RAD_S;
            dof.stood_ticks = if still { dof.stood_ticks.saturating_add(1) } else { 0 };
            let stands = dof.stood_ticks > self.stands_ticks;
            dof.swing.step(&self.swing, (off, stands), measured.effort, own.effort);
            (report.swings, report.gain) = (dof.swing.is_found(), dof.swing.gain());
            if report.swings {
                findings.note_of(Fault::Swing, dof.servo);
            }
        }
        error.mean_rad = if count > 0.0 { sum / count } else { 0.0 };
        error
    }
}

impl Dof {
    /// Restarts the detectors.
    fn begin(&mut self) {
        self.following.begin();
        self.swing = Swing::default();
        self.stood_ticks = 0;
    }
}
