//! The bus lines of a simulated board as a single bus and a single wire for the whole tick.

use std::cell::{Cell, RefCell};

use sinew_firmware::controller::Wire;
use sinew_servo_bus::settings::ServoRequirements;
use sinew_servo_bus::{
    Command, CommandError, Compared, EncodeError, Feedback, Health, Limit, Request, ServoBus,
};
use sinew_servo_sim::bench::Branch;
use sinew_servo_sim::line::{Line, LineDevice as _, run_all};
use sinew_servo_sim::load::Plant;

use crate::play::Wires;
use crate::play::bus::Buses;
use crate::play::exchange::exchange;

/// The buses of all lines. Each bus plans its own packets during [`Wire::exchange`].
pub(super) struct AllLines<'b> {
    pub(super) buses: &'b RefCell<Buses>,
    /// Error of a packet that was not sent in this tick.
    pub(super) failed: &'b Cell<Option<EncodeError>>,
}

impl ServoBus for AllLines<'_> {
    fn len(&self) -> usize {
        self.buses.borrow().len()
    }
    fn command(&mut self, servo: usize, command: Command) -> Result<Option<Limit>, CommandError> {
        self.buses.borrow_mut().command(servo, command)
    }
    fn plan(&mut self, _: &mut [u8]) -> Result<Request, EncodeError> {
        self.failed.set(None);
        Ok(Request::default())
    }
    fn plan_more(&mut self, _: u32, _: &mut [u8]) -> Result<Option<Request>, EncodeError> {
        self.failed.get().map_or(Ok(None), Err)
    }
    fn reply(&mut self, _: &[u8]) -> bool {
        true
    }
    fn compare(&mut self, asked: Option<(usize, ServoRequirements)>) {
        self.buses.borrow_mut().compare(asked);
    }
    fn compared(&self) -> Compared {
        self.buses.borrow().compared()
    }
    fn feedback(&self, servo: usize) -> Option<Feedback> {
        self.buses.borrow().feedback(servo)
    }
    fn health(&self, servo: usize) -> Option<Health> {
        self.buses.borrow().health(servo)
    }
}

/// The bus lines during a tick, with the time on them.
pub(super) struct Servos<'s, 'm, P> {
    pub(super) buses: &'s RefCell<Buses>,
    pub(super) failed: &'s Cell<Option<EncodeError>>,
    pub(super) lines: &'s mut [Line<Branch<'m, P>>],
    /// Rates of the lines, bit/s; `None` for a line with a PCA9685, to which no packet may be passed: the chip would
    /// interpret the bytes of a packet as values for its registers.
    pub(super) bauds: &'s [Option<u32>],
    pub(super) end_ns: u64,
    pub(super) clock_us: &'s Cell<u64>,
    /// Whether servos may get pulses.
    pub(super) has_outputs: &'s Cell<bool>,
    pub(super) wires: &'s mut Wires,
}

impl<P: Plant> Servos<'_, '_, P> {
    fn now_ns(&self) -> u64 {
        self.lines.first().map_or(0, |line| line.servos.now_ns())
    }

    /// Advances the board's clock by the time that an exchange on the lines took.
    fn pass_time(&self, begin_ns: u64) {
        let took_us = self.now_ns().saturating_sub(begin_ns) / 1000;
        self.clock_us.set(self.clock_us.get() + took_us);
    }
}

impl<P: Plant> Wire for Servos<'_, '_, P> {
    /// Exchanges all packets of a tick: each line has packets of its own.
    fn exchange(&mut self, _: &[u8], _: u32, _: impl FnMut(&[u8]) -> bool) {
        let begin_ns = self.now_ns();
        let is_on = self.has_outputs.get();
        for line in &mut *self.lines {
            line.servos.enable_pulses(is_on);
        }
        let lines = &mut self.buses.borrow_mut().lines;
        self.failed.set(exchange(lines, self.lines, self.end_ns, self.wires).err());
        self.pass_time(begin_ns);
    }

    fn left_us(&self) -> u32 {
        0
    }

    fn rate(&self, line: u8) -> Option<u32> {
        *self.bauds.get(usize::from(line))?
    }

    fn pass(
        &mut self,
        line: u8,
        baud: u32,
        bytes: &[u8],
        wait_us: u32,
        mut reply: impl FnMut(&[u8]),
    ) -> Option<u32> {
        let index = usize::from(line);
        let own = self.rate(line)?;
        let begin_ns = self.now_ns();
        let end_ns = begin_ns + u64::from(wait_us) * 1000;
        let (mut said, mut last_ns) = ([0; 512], begin_ns);
        let line = self.lines.get_mut(index)?;
        while line.take(&mut said) > 0 {}
        line.servos.set_rate(if baud == 0 { own } else { baud });
        line.write(bytes);
        loop {
            let line = self.lines.get_mut(index)?;
            let len = line.take(&mut said);
            if let Some(came) = said.get(..len).filter(|came| !came.is_empty()) {
                last_ns = line.servos.now_ns();
                reply(came);
            }
            if line.servos.now_ns() >= end_ns {
                line.servos.set_rate(own);
                break;
            }
            let next_ns = line.next_ns().map_or(end_ns, |next| next.min(end_ns));
            run_all(self.lines, next_ns);
        }
        self.pass_time(begin_ns);
        u32::try_from((last_ns - begin_ns) / 1000).ok()
    }
}
