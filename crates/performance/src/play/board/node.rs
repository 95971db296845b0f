//! The node of a simulated board between two starts, and its hardware.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::ops::Range;

use sinew_firmware::node::{
    BackgroundTask, ControlLoop, Found, Mail, Port, Safety, Setup, Shared, start,
};
use sinew_firmware::supervisor::FaultSet;
use sinew_firmware::watchdog::Complete;
use sinew_link::message::About;
use sinew_wiring::{LINES, Wiring};

use super::error::BoardError;
use super::flash::{Chip, TABLE};
use crate::play::{BODIES, COORDINATES, DOFS, RigParts, SERVOS};

/// Room for the largest rig in its compact form, bytes.
pub(super) const RIG_ROOM: usize = 1 << 16;

/// Rate of the host link, bit/s: the NUCLEO's.
const LINE_BPS: u32 = 1_000_000;

type Letters = Mail<'static, DOFS, SERVOS, COORDINATES>;

/// A critical section. In one thread nothing interrupts.
pub(super) struct SingleThreaded(RefCell<Letters>);

impl Shared<Letters> for SingleThreaded {
    fn with<R>(&self, act: impl FnOnce(&mut Letters) -> R) -> R {
        act(&mut self.0.borrow_mut())
    }
}

/// Control loop, background task, and the mailbox between them.
pub(super) struct Node {
    /// `None` without a rig that fits the servos.
    pub(super) control: Option<Box<ControlLoop<'static, BODIES, DOFS, SERVOS, COORDINATES>>>,
    pub(super) background: Box<BackgroundTask<'static, Chip, BODIES, DOFS, SERVOS, COORDINATES>>,
    pub(super) mail: Box<SingleThreaded>,
}

impl Node {
    /// Starts with the content of the flash.
    pub(super) fn start(parts: &RigParts, chip: &Chip, about: About) -> Result<Self, BoardError> {
        let defaults = parts.node_settings();
        let found = start::<_, BODIES, DOFS, SERVOS>(
            chip.clone(),
            TABLE,
            |_| defaults,
            FaultSet::EMPTY,
            &mut vec![0; RIG_ROOM],
            // Kept until the program ends: a board starts only a few times.
            Box::leak(Box::new_uninit()),
        );
        let Found { store, disarmed, settings, rig, is_bad, start } =
            found.map_err(|error| BoardError::Flash(format!("{error:?}")))?;
        // Each start has another number.
        let first_session = u16::try_from(start.count % 655).unwrap_or(0) * 100;
        let control = rig.and_then(|(rig, _)| {
            let made = ControlLoop::new(rig, &settings, &parts.setups, &parts.schedule, start);
            made.ok().map(Box::new)
        });
        let rig = rig.filter(|_| control.is_some());
        let tick_s = 1e-6 * parts.tick_us() as f32;
        let setup = Setup { about, settings, is_bad, rig, tick_s, line_bps: LINE_BPS };
        Ok(Self {
            control,
            background: Box::new(BackgroundTask::new(store, setup, first_session)),
            mail: Box::new(SingleThreaded(RefCell::new(Mail::new(disarmed)))),
        })
    }
}

/// Clock and outputs of the board.
pub(super) struct Pins<'c> {
    pub(super) clock_us: &'c Cell<u64>,
    /// State of the pin OE of a PCA9685: whether servos may get pulses.
    pub(super) has_outputs: &'c Cell<bool>,
}

impl Safety for Pins<'_> {
    fn now_us(&self) -> u64 {
        self.clock_us.get()
    }
    fn is_stopped(&mut self) -> bool {
        false
    }
    fn enable_outputs(&mut self, on: bool) {
        self.has_outputs.set(on);
    }
    fn feed(&mut self, _: Complete) {}
    /// Returns the simulated time of lines and servos, µs.
    #[expect(clippy::cast_possible_truncation, reason = "it wraps")]
    fn cycles(&self) -> u32 {
        self.clock_us.get() as u32
    }
    fn cycles_hz(&self) -> u32 {
        1_000_000
    }
}

/// Host link, and flash that is read as memory.
pub(super) struct HostPort<'d> {
    pub(super) now_us: u64,
    pub(super) came: &'d mut VecDeque<u8>,
    pub(super) said: &'d mut VecDeque<u8>,
    pub(super) chip: &'d Chip,
    pub(super) lent: &'d mut Vec<&'static [u8]>,
}

impl Port<'static> for HostPort<'_> {
    fn now_us(&self) -> u64 {
        self.now_us
    }
    fn receive(&mut self, into: &mut [u8]) -> usize {
        let count = into.len().min(self.came.len());
        into.iter_mut().zip(self.came.drain(..count)).for_each(|(to, byte)| *to = byte);
        count
    }
    fn send(&mut self, bytes: &[u8]) -> usize {
        self.said.extend(bytes);
        bytes.len()
    }
    fn look<R>(&mut self, range: Range<u32>, look: impl FnOnce(&[u8]) -> R) -> Option<R> {
        self.chip.look(range, look)
    }
    /// Accepts any valid wiring: a simulated board has the lines of its own rig.
    fn drives(behind: &[u8]) -> bool {
        behind.is_empty() || Wiring::<LINES, SERVOS>::decode(behind).is_ok()
    }
    fn lend(&mut self, range: Range<u32>) -> Option<&'static [u8]> {
        // Leaks a copy for each show, which lives until the program ends.
        let Self { chip, lent, .. } = self;
        chip.look(range, |bytes| {
            if let Some(before) = lent.iter().find(|before| **before == bytes) {
                return *before;
            }
            let copy = &*Vec::leak(bytes.to_vec());
            lent.push(copy);
            copy
        })
    }
}
