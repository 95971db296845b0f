//! Hardware of the node: RAM, and the host at the other end of the message channel.

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::ops::Range;

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use heapless::Vec;
use sinew_firmware::controller::Wire;
use sinew_firmware::node::{Port, Safety, Shared};
use sinew_firmware::watchdog::Complete;
use sinew_servo_bus::Request;

use crate::built_in::Lines;
use crate::limits::LINE_IN_STEP;
use crate::message::{Bytes, End, Packets, TakeError, ToHost, ToNode};

/// Room for the packets that a line sends at once, bytes.
const OUT_LEN: usize = 2048;

/// Flash that its driver and the processor share.
#[derive(Clone, Copy)]
pub(crate) struct Chip<'m>(pub(crate) &'m RefCell<&'m mut [u8]>);

fn places(range: Range<u32>) -> Range<usize> {
    range.start as usize..range.end as usize
}

impl ErrorType for Chip<'_> {
    type Error = Infallible;
}

impl ReadNorFlash for Chip<'_> {
    const READ_SIZE: usize = 1;
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes.copy_from_slice(&self.0.borrow()[offset as usize..][..bytes.len()]);
        Ok(())
    }
    fn capacity(&self) -> usize {
        self.0.borrow().len()
    }
}

impl NorFlash for Chip<'_> {
    // Sizes of the F446's flash.
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 1024;
    fn erase(&mut self, from: u32, to: u32) -> Result<(), Infallible> {
        self.0.borrow_mut()[places(from..to)].fill(0xFF);
        Ok(())
    }
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
        let mut flash = self.0.borrow_mut();
        // Writing can only clear bits.
        for (old, new) in flash[offset as usize..][..bytes.len()].iter_mut().zip(bytes) {
            *old &= new;
        }
        Ok(())
    }
}

/// RAM for shows that the loop reads in place. A show is copied there when it is lent, because flash can be borrowed
/// only as a whole.
pub(crate) struct ShowBuffer<'m>(pub(crate) &'m mut [u8]);

impl<'m> ShowBuffer<'m> {
    fn copy(&mut self, show: &[u8]) -> Option<&'m [u8]> {
        let (copy, rest) = core::mem::take(&mut self.0).split_at_mut_checked(show.len())?;
        self.0 = rest;
        copy.copy_from_slice(show);
        Some(copy)
    }
}

/// A critical section. In one thread nothing interrupts.
pub(crate) struct SingleThreaded<T>(pub(crate) RefCell<T>);

impl<T> Shared<T> for SingleThreaded<T> {
    fn with<R>(&self, act: impl FnOnce(&mut T) -> R) -> R {
        act(&mut self.0.borrow_mut())
    }
}

/// The board as the control loop uses it: clock, emergency stop, outputs and watchdog. The clock advances while the
/// bus is used.
pub(crate) struct Pins<'c> {
    pub(crate) now_us: &'c Cell<u64>,
    pub(crate) is_stopped: bool,
    pub(crate) outputs: bool,
    pub(crate) is_fed: bool,
}

impl Safety for Pins<'_> {
    fn now_us(&self) -> u64 {
        self.now_us.get()
    }
    fn is_stopped(&mut self) -> bool {
        self.is_stopped
    }
    fn enable_outputs(&mut self, on: bool) {
        self.outputs = on;
    }
    fn feed(&mut self, _: Complete) {
        self.is_fed = true;
    }
}

/// The bus lines; their servos are simulated by the host.
pub(crate) struct Servos<'h, B> {
    pub(crate) host: &'h mut End<B>,
    pub(crate) lines: &'h RefCell<Lines>,
    pub(crate) now_us: &'h Cell<u64>,
}

impl<B: Bytes<Error = Infallible>> Wire for Servos<'_, B> {
    /// Exchanges all packets of a tick: the host asks line by line.
    fn exchange(&mut self, _: &[u8], _: u32, _: impl FnMut(&[u8]) -> bool) {
        let mut lines = self.lines.borrow_mut();
        let mut out = [0; OUT_LEN];
        put(self.host, &ToHost::Exchange);
        loop {
            let planned = match take(self.host) {
                ToNode::Plan { line } => lines.plan(line, &mut out),
                ToNode::PlanMore { line, left_us } => lines.plan_more(line, left_us, &mut out),
                ToNode::Said { line, bytes } => {
                    let is_complete = lines.reply(line, bytes);
                    put(self.host, &ToHost::IsComplete(is_complete));
                    continue;
                }
                ToNode::Over { now_us } => {
                    self.now_us.set(now_us);
                    return;
                }
                other => panic!("{other:?} in an exchange"),
            };
            let packets = planned.map(|Request { len, reply_len, time_us }| {
                let bytes = &out[..len];
                Packets { bytes, reply_len, time_us }
            });
            put(self.host, &ToHost::Planned(packets));
        }
    }

    /// The host has already asked for the optional packets of lines.
    fn left_us(&self) -> u32 {
        0
    }
}

/// Receives the host's next message.
pub(crate) fn take<B: Bytes<Error = Infallible>>(host: &mut End<B>) -> ToNode<'_> {
    match host.take() {
        Ok(message) => message,
        Err(TakeError::Message) => panic!("the host is of another version"),
    }
}

/// Sends a message to the host.
pub(crate) fn put<B: Bytes<Error = Infallible>>(host: &mut End<B>, message: &ToHost<'_>) {
    let Ok(()) = host.put(message);
}

/// The board as the background task uses it: host link and storage.
pub(crate) struct HostPort<'t, 'm> {
    pub(crate) now_us: u64,
    /// Bytes from the host that are not read yet.
    pub(crate) came: &'t [u8],
    /// Bytes for the host.
    pub(crate) said: Vec<u8, 2048>,
    pub(crate) chip: Chip<'m>,
    pub(crate) lent: &'t mut ShowBuffer<'m>,
}

impl<'a, 'm: 'a> Port<'a> for HostPort<'_, 'm> {
    fn now_us(&self) -> u64 {
        self.now_us
    }
    fn receive(&mut self, into: &mut [u8]) -> usize {
        let (taken, rest) = self.came.split_at(into.len().min(self.came.len()));
        self.came = rest;
        into[..taken.len()].copy_from_slice(taken);
        taken.len()
    }
    fn send(&mut self, bytes: &[u8]) -> usize {
        let room = self.said.capacity() - self.said.len();
        let taken = &bytes[..bytes.len().min(LINE_IN_STEP).min(room)];
        self.said.extend_from_slice(taken).expect("there is room");
        taken.len()
    }
    fn look<R>(&mut self, range: Range<u32>, look: impl FnOnce(&[u8]) -> R) -> Option<R> {
        self.chip.0.borrow().get(places(range)).map(look)
    }
    fn lend(&mut self, range: Range<u32>) -> Option<&'a [u8]> {
        self.lent.copy(self.chip.0.borrow().get(places(range))?)
    }
}
