//! Comparison of the servos' registers with the rig's requirements, before the rig is armed.

use heapless::Vec;
use sinew_rig::board::BoardServo;
use sinew_servo_bus::settings::ServoRequirements;
use sinew_servo_bus::{Compared, Difference, ServoBus};

use super::settings::ServoSetup;
use crate::supervisor::{RegisterDiffers, Registers};

/// Compares one servo after another, repeatedly, while torque is off. After torque was on, or a servo was silent, the
/// earlier results are discarded: the servo may have restarted.
#[derive(Debug, Default)]
pub(super) struct Comparison<const SERVOS: usize> {
    servos: Vec<Servo, SERVOS>,
    /// Index of the servo that the bus compares now or next.
    at: usize,
    is_asked: bool,
    /// Whether the comparison has begun. Only then a result is stored.
    is_begun: bool,
}

#[derive(Debug)]
struct Servo {
    requirements: ServoRequirements,
    found: Option<Compared>,
    was_silent: bool,
}

impl<const SERVOS: usize> Comparison<SERVOS> {
    #[inline(never)]
    pub(super) fn new(servos: &[BoardServo], setups: &[ServoSetup]) -> Self {
        let required =
            servos.iter().zip(setups).map(|(servo, setup)| setup.requirements(&servo.servo));
        // There is room: `SERVOS` is the maximum number of servos.
        let servos = required
            .map(|requirements| Servo { requirements, found: None, was_silent: false })
            .take(SERVOS)
            .collect();
        Self { servos, at: 0, is_asked: false, is_begun: false }
    }

    /// Advances the comparison in a tick without torque.
    pub(super) fn step(&mut self, bus: &mut impl ServoBus, is_silent: impl Fn(usize) -> bool) {
        self.is_begun = true;
        for (index, servo) in self.servos.iter_mut().enumerate() {
            let is_silent = is_silent(index);
            let was_silent = core::mem::replace(&mut servo.was_silent, is_silent);
            if is_silent && !was_silent {
                servo.found = None;
                // Results that were read before the silence are discarded.
                self.is_asked &= index != self.at;
            }
        }
        // Servos without registers have a result at once, so several may be done in a tick.
        for _ in 0..self.servos.len() {
            let Some(servo) = self.servos.get_mut(self.at) else { return };
            if servo.was_silent {
                // The other servos are still compared.
                self.go_on();
                continue;
            }
            if !core::mem::replace(&mut self.is_asked, true) {
                bus.compare(Some((self.at, servo.requirements)));
            }
            match bus.compared() {
                Compared::Reading => return,
                result => servo.found = Some(result),
            }
            self.go_on();
        }
    }

    fn go_on(&mut self) {
        self.at = self.at.saturating_add(1).checked_rem(self.servos.len()).unwrap_or(0);
        self.is_asked = false;
    }

    /// Stops the comparison and discards all results: torque is on, or another program sends packets to the servos.
    pub(super) fn stop(&mut self, bus: &mut impl ServoBus) {
        if core::mem::take(&mut self.is_begun) {
            bus.compare(None);
            self.is_asked = false;
            self.servos.iter_mut().for_each(|servo| servo.found = None);
        }
    }

    /// Returns the first servo whose register reports that torque is on, or `None` if none does.
    pub(super) fn torque_stuck(&self) -> Option<u16> {
        let is_stuck = |servo: &Servo| matches!(servo.found, Some(Compared::Differs(difference)) if difference.is_torque());
        u16::try_from(self.servos.iter().position(is_stuck)?).ok()
    }

    /// Returns the result for all servos. If several differ, returns the first.
    pub(super) fn result(&self) -> Registers {
        let differs = self.servos.iter().enumerate().find_map(|(index, servo)| match servo.found {
            Some(Compared::Differs(difference)) => Some((index, difference)),
            _ => None,
        });
        match differs {
            Some((servo, Difference { item, address, found, expected })) => {
                let servo = u16::try_from(servo).unwrap_or(u16::MAX);
                Registers::Differ(RegisterDiffers { servo, item, address, found, expected })
            }
            None if self.servos.iter().all(|servo| servo.found.is_some()) => Registers::Same,
            None => Registers::Unread,
        }
    }
}
