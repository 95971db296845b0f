//! Test of the way to stop: torque off is sent, and afterwards no servo draws current. The comparison of registers
//! (`registers.rs`) checks in addition that each servo's register reports torque off.

use sinew_servo_bus::Effort;

use crate::drives::Condition;

/// Maximum effort that a servo without torque may report, as a part of its maximum. It allows for noise, and for a
/// hand that turns the servo.
const IDLE: f32 = 0.05;

/// Counts the ticks with torque off, and checks the readings after them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct StopTest {
    ticks: u32,
    is_passed: bool,
}

impl StopTest {
    /// Records that the packets of a tick were sent completely. `off` is whether they switched torque off on all
    /// servos.
    pub(super) fn sent(&mut self, off: bool) {
        if off {
            self.ticks = self.ticks.saturating_add(1);
        } else {
            *self = Self::default();
        }
    }

    /// Checks the readings of a tick: the condition and the stall current of each servo that reports.
    pub(super) fn look(&mut self, mut servos: impl Iterator<Item = (Condition, f32)>) {
        let ticks = self.ticks;
        self.is_passed |= ticks > 1 && servos.all(|(servo, stall_a)| is_off(servo, stall_a, ticks));
    }

    pub(super) fn is_passed(self) -> bool {
        self.is_passed
    }
}

/// Returns whether a servo was read in a tick after the first torque off, and is idle. A reading of that first tick
/// was measured before torque was off.
fn is_off(servo: Condition, stall_a: f32, ticks: u32) -> bool {
    servo.feedback.is_some_and(|read| {
        let share = match read.effort {
            Effort::Current(a) => a / stall_a,
            Effort::Load(share) => share,
        };
        read.age_ticks.saturating_add(1) < ticks && share.abs() <= IDLE
    })
}
