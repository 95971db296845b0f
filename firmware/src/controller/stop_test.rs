//! The test of the way to stop: torque off goes out, and no servo draws current after that. That each servo's register
//! of torque says so, too, is a part of the comparison of registers (`registers.rs`).

use sinew_servo_bus::Effort;

use crate::drives::Condition;

/// What a servo whose torque is off may still tell, as a part of its most: noise, and a hand that turns it.
const IDLE: f32 = 0.05;

/// Counts the ticks of torque off, and looks at what is read behind them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct StopTest {
    ticks: u32,
    is_passed: bool,
}

impl StopTest {
    /// A tick has gone out whole, with torque off for all servos or not.
    pub(super) fn sent(&mut self, off: bool) {
        if off {
            self.ticks = self.ticks.saturating_add(1);
        } else {
            *self = Self::default();
        }
    }

    /// Readings of a tick: of each servo that tells, and its stall current.
    pub(super) fn look(&mut self, mut servos: impl Iterator<Item = (Condition, f32)>) {
        let ticks = self.ticks;
        self.is_passed |= ticks > 1 && servos.all(|(servo, stall_a)| is_off(servo, stall_a, ticks));
    }

    pub(super) fn is_passed(self) -> bool {
        self.is_passed
    }
}

/// Read in a later tick than torque off first went out, and idle. What is read in the same tick was measured before.
fn is_off(servo: Condition, stall_a: f32, ticks: u32) -> bool {
    servo.feedback.is_some_and(|read| {
        let share = match read.effort {
            Effort::Current(a) => a / stall_a,
            Effort::Load(share) => share,
        };
        read.age_ticks.saturating_add(1) < ticks && share.abs() <= IDLE
    })
}
