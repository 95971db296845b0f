//! The last step: commands pass through the guards to the bus.

use heapless::Vec;
use sinew_servo_bus::{Command, ServoBus};

use super::belief::Belief;
use super::error::{ControllerError, Incomplete};
use super::report::ServoReport;
use super::settings::ServoSetup;
use crate::drives::{Condition, ServoCommand};
use crate::supervisor::{Guard, GuardReason, GuardSettings, Permission};
use sinew_rig::board::BoardServo;

/// Guards of all servos.
#[derive(Debug, Default)]
pub(super) struct Output<const SERVOS: usize> {
    guards: Vec<Guard, SERVOS>,
}

impl<const SERVOS: usize> Output<SERVOS> {
    #[inline(never)]
    pub(super) fn new(
        servos: &[BoardServo],
        setups: &[ServoSetup],
        dt_s: f32,
    ) -> Result<Self, ControllerError> {
        let mut guards = Vec::new();
        for (index, (servo, setup)) in servos.iter().zip(setups).enumerate() {
            let guard = Guard::new(GuardSettings::of(&servo.servo, &setup.drive), dt_s)
                .map_err(|why| ControllerError::Servo { servo: index, why })?;
            // There is room: `SERVOS` is the maximum number of servos.
            let _ = guards.push(guard);
        }
        Ok(Self { guards })
    }

    /// Sends the commands of a tick. If `switch_on`, torque is switched on after the first goal, which the guard
    /// permits only at the servo's measured position.
    pub(super) fn send(
        &mut self,
        bus: &mut impl ServoBus,
        (commands, conditions, beliefs): (&[Option<ServoCommand>], &[Condition], &[Belief]),
        permission: &Permission,
        switch_on: bool,
        report: &mut [ServoReport],
    ) -> Result<(), Incomplete> {
        let read = conditions.iter().zip(beliefs);
        let servos = self.guards.iter_mut().zip(commands).zip(read).zip(report);
        for (index, (((guard, command), (condition, belief)), report)) in servos.enumerate() {
            let Some(ServoCommand { command, limit }) = *command else { continue };
            let guarded = guard.check(command, condition, permission);
            (report.limit, report.guard) = (limit, guarded.reason);
            if guarded.reason == Some(GuardReason::NotFinite) {
                return Err(Incomplete::NotFinite);
            }
            let Some(command) = guarded.command else { continue };
            if switch_on {
                // This command is given first, since a Feetech accepts no goal before it. Buses still send it after
                // the goals.
                bus.command(index, Command::Torque(true)).map_err(Incomplete::Command)?;
            }
            bus.command(index, belief.sent(command)).map_err(Incomplete::Command)?;
        }
        Ok(())
    }

    /// Switches torque off on all servos.
    pub(super) fn release(
        &mut self,
        bus: &mut impl ServoBus,
        permission: &Permission,
    ) -> Result<(), Incomplete> {
        let off = Command::Torque(false);
        let mut result = Ok(());
        for (index, guard) in self.guards.iter_mut().enumerate() {
            guard.check(off, &Condition::default(), permission);
            // Whatever one servo's result is, the others must be off.
            result = result.and(bus.command(index, off).map_err(Incomplete::Command).map(|_| ()));
        }
        result
    }
}
