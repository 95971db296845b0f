//! The last step: commands through the guards to the bus.

use heapless::Vec;
use sinew_servo_bus::{Command, ServoBus};

use super::belief::Belief;
use super::error::{ControllerError, Incomplete};
use super::report::ServoReport;
use super::settings::ServoSetup;
use crate::drives::{Condition, ServoCommand};
use crate::supervisor::{Guard, GuardReason, GuardSettings, Permission};
use sinew_rig::board::BoardServo;

/// The guards of all servos.
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
            // Servos of a rig are counted: there is room.
            let _ = guards.push(guard);
        }
        Ok(Self { guards })
    }

    /// Commands of a tick. `switch_on`: torque comes on, behind the first goal, which the guard lets pass only where
    /// the servo was measured.
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
                // First, since a Feetech takes no goal before; buses send it behind the goals.
                bus.command(index, Command::Torque(true)).map_err(Incomplete::Command)?;
            }
            bus.command(index, belief.sent(command)).map_err(Incomplete::Command)?;
        }
        Ok(())
    }

    /// Torque off, for all.
    pub(super) fn release(
        &mut self,
        bus: &mut impl ServoBus,
        permission: &Permission,
    ) -> Result<(), Incomplete> {
        let off = Command::Torque(false);
        let mut result = Ok(());
        for (index, guard) in self.guards.iter_mut().enumerate() {
            guard.check(off, &Condition::default(), permission);
            // Whatever one servo says, the others are to be off.
            result = result.and(bus.command(index, off).map_err(Incomplete::Command).map(|_| ()));
        }
        result
    }
}
