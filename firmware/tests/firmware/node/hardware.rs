//! Simulated hardware of a board.

use std::cell::{Cell, RefCell};
use std::ops::Range;
use std::rc::Rc;

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use sinew_firmware::controller::Wire;
use sinew_firmware::node::{Mail, Port, Safety, Shared};
use sinew_firmware::watchdog::Complete;
use sinew_qemu_node::limits::LINE_IN_STEP;
pub(crate) use sinew_qemu_node::node::TABLE;
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::load::Arm;

use super::flash::{MockFlash, PowerFailed};
use super::host::Host;
use super::test_rig::hash_of;
use super::told::Told;

/// Flash that its driver and the processor share.
#[derive(Clone)]
pub(crate) struct Chip {
    pub(crate) flash: Rc<RefCell<MockFlash>>,
    /// Range that is lent to the loop: a write or erase there breaks the guarantee of [`Port::lend`].
    pub(crate) lent: Rc<RefCell<Option<Range<u32>>>>,
}

impl Chip {
    pub(crate) fn new() -> Self {
        Self::of(MockFlash::new(&TABLE))
    }

    pub(crate) fn of(flash: MockFlash) -> Self {
        Self { flash: Rc::new(RefCell::new(flash)), lent: Rc::default() }
    }

    fn check(&self, from: u32, to: u32) {
        let lent = self.lent.borrow();
        let is_apart = lent.as_ref().is_none_or(|lent| to <= lent.start || lent.end <= from);
        assert!(is_apart, "{from:#x}..{to:#x} changes under the loop, which reads {lent:x?}");
    }
}

impl ErrorType for Chip {
    type Error = PowerFailed;
}

impl ReadNorFlash for Chip {
    const READ_SIZE: usize = MockFlash::READ_SIZE;
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerFailed> {
        self.flash.borrow_mut().read(offset, bytes)
    }
    fn capacity(&self) -> usize {
        self.flash.borrow().capacity()
    }
}

impl NorFlash for Chip {
    const WRITE_SIZE: usize = MockFlash::WRITE_SIZE;
    const ERASE_SIZE: usize = MockFlash::ERASE_SIZE;
    fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerFailed> {
        self.check(from, to);
        self.flash.borrow_mut().erase(from, to)
    }
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerFailed> {
        self.check(offset, offset + bytes.len() as u32);
        self.flash.borrow_mut().write(offset, bytes)
    }
}

pub(crate) type Letters = Mail<'static, 8, 8, 8>;

/// A mailbox that stands for one behind a board's critical section.
pub(crate) struct Locked(pub(crate) RefCell<Letters>);

impl Shared<Letters> for Locked {
    fn with<R>(&self, act: impl FnOnce(&mut Letters) -> R) -> R {
        act(&mut self.0.borrow_mut())
    }
}

/// Clock, emergency stop, OE and watchdog.
#[derive(Default)]
pub(crate) struct Pins {
    pub(crate) clock_us: Rc<Cell<u64>>,
    pub(crate) is_stopped: bool,
    pub(crate) outputs: bool,
    pub(crate) fed: u64,
}

impl Safety for Pins {
    fn now_us(&self) -> u64 {
        self.clock_us.get()
    }
    fn is_stopped(&mut self) -> bool {
        self.is_stopped
    }
    fn enable_outputs(&mut self, on: bool) {
        self.outputs = on;
    }
    fn feed(&mut self, _: Complete) {
        self.fed += 1;
    }
}

/// Host link and memory-mapped flash.
pub(crate) struct HostPort<'w> {
    pub(crate) now_us: u64,
    pub(crate) host: &'w mut Host,
    pub(crate) chip: &'w Chip,
}

impl Port<'static> for HostPort<'_> {
    fn now_us(&self) -> u64 {
        self.now_us
    }
    fn receive(&mut self, into: &mut [u8]) -> usize {
        let count = into.len().min(self.host.there.bytes.len());
        into.iter_mut().zip(self.host.give(count)).for_each(|(to, byte)| *to = byte);
        count
    }
    fn send(&mut self, bytes: &[u8]) -> usize {
        let count = if self.host.reads { bytes.len().min(LINE_IN_STEP) } else { 0 };
        self.host.take(&bytes[..count], self.now_us);
        count
    }
    fn look<R>(&mut self, range: Range<u32>, look: impl FnOnce(&[u8]) -> R) -> Option<R> {
        let flash = self.chip.flash.borrow();
        flash.bytes.get(range.start as usize..range.end as usize).map(look)
    }
    fn lend(&mut self, range: Range<u32>) -> Option<&'static [u8]> {
        // A copy is enough, as nothing changes in the range while it is lent.
        *self.chip.lent.borrow_mut() = Some(range.clone());
        self.look(range, |bytes| &*Vec::leak(bytes.to_vec()))
    }
}

/// The bench's bus line during a tick; it advances the clock.
pub(crate) struct Servos<'b> {
    pub(crate) bench: &'b mut Bench<'static, Vec<Arm>>,
    pub(crate) base_s: f64,
    pub(crate) end_s: f64,
    pub(crate) clock_us: Rc<Cell<u64>>,
    pub(crate) start_us: u64,
    /// Time that is added to a tick's duration, µs.
    pub(crate) late_us: u64,
    pub(crate) hash: &'b mut u64,
    pub(crate) told: &'b mut Told,
    pub(crate) sent: &'b mut Vec<u8>,
}

impl Wire for Servos<'_> {
    fn exchange(&mut self, bytes: &[u8], wait_us: u32, mut reply: impl FnMut(&[u8]) -> bool) {
        let Self { bench, hash, told, sent, .. } = self;
        hash_of(hash, bytes);
        sent.extend_from_slice(bytes);
        told.asked(bytes);
        bench.exchange(bytes, wait_us, |said| {
            let said = told.told(said);
            hash_of(hash, &said);
            reply(&said)
        });
        let took_us = ((self.bench.time_s() - self.base_s) * 1e6).round() as u64;
        self.clock_us.set(self.start_us + took_us + self.late_us);
    }
    fn rate(&self, line: u8) -> Option<u32> {
        (line == 0).then_some(self.bench.baud)
    }
    fn pass(
        &mut self,
        line: u8,
        baud: u32,
        bytes: &[u8],
        wait_us: u32,
        mut reply: impl FnMut(&[u8]),
    ) -> Option<u32> {
        if line > 0 || ![0, self.bench.baud].contains(&baud) {
            return None;
        }
        let mut has_said = false;
        let took_us = self.bench.exchange(bytes, wait_us, |said| {
            has_said |= !said.is_empty();
            reply(said);
            false
        });
        Some(if has_said { took_us } else { 0 })
    }
    fn left_us(&self) -> u32 {
        ((self.end_s - self.bench.time_s()) * 1e6).max(0.0) as u32
    }
}
