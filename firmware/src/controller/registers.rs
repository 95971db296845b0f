//! What servos hold in their registers, against what the rig asks: before it is armed.

use heapless::Vec;
use sinew_rig::board::BoardServo;
use sinew_servo_bus::settings::ServoRequirements;
use sinew_servo_bus::{Compared, Difference, ServoBus};

use super::settings::ServoSetup;
use crate::supervisor::{RegisterDiffers, Registers};

/// Compares servo after servo, again and again, as long as torque is off. When torque was on, and when a servo was
/// silent, nothing is known any more: it may have started anew.
#[derive(Debug, Default)]
pub(super) struct Comparison<const SERVOS: usize> {
    servos: Vec<Servo, SERVOS>,
    /// Which one the bus compares, or will.
    at: usize,
    is_asked: bool,
    /// Something may be known.
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
        // Servos of a rig are counted: there is room.
        let servos = required
            .map(|requirements| Servo { requirements, found: None, was_silent: false })
            .take(SERVOS)
            .collect();
        Self { servos, at: 0, is_asked: false, is_begun: false }
    }

    /// A tick without torque.
    pub(super) fn step(&mut self, bus: &mut impl ServoBus, is_silent: impl Fn(usize) -> bool) {
        self.is_begun = true;
        for (index, servo) in self.servos.iter_mut().enumerate() {
            let is_silent = is_silent(index);
            let was_silent = core::mem::replace(&mut servo.was_silent, is_silent);
            if is_silent && !was_silent {
                servo.found = None;
                // What was read of it before counts no more.
                self.is_asked &= index != self.at;
            }
        }
        // As many as are known at once, which are those without registers.
        for _ in 0..self.servos.len() {
            let Some(servo) = self.servos.get_mut(self.at) else { return };
            if servo.was_silent {
                // The others are looked at all the same.
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

    /// Torque is on, or somebody else talks to servos: nothing is compared, and nothing known.
    pub(super) fn stop(&mut self, bus: &mut impl ServoBus) {
        if core::mem::take(&mut self.is_begun) {
            bus.compare(None);
            self.is_asked = false;
            self.servos.iter_mut().for_each(|servo| servo.found = None);
        }
    }

    /// The first servo whose register of torque says that it is on.
    pub(super) fn torque_stuck(&self) -> Option<u16> {
        let is_stuck = |servo: &Servo| matches!(servo.found, Some(Compared::Differs(difference)) if difference.is_torque());
        u16::try_from(self.servos.iter().position(is_stuck)?).ok()
    }

    /// What is known of all servos: of several that differ, the first.
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
