//! What hardware gives to a node. Each method states its duty. Flash to write is a `NorFlash`, a bus of servos a
//! [`Wire`](crate::controller::Wire).

use core::ops::Range;

use crate::supervisor::FaultSet;
use crate::watchdog::Complete;

/// The board as the loop sees it. All methods come back at once.
pub trait Safety {
    /// Time since the board's start, µs; it never goes back, and goes on while flash is erased.
    fn now_us(&self) -> u64;

    /// Whether the loop of the emergency stop is open, or its wire is cut. The loop cuts the servos' power by itself;
    /// this only tells.
    fn is_stopped(&mut self) -> bool;

    /// The line that lets servos have their signals (OE), if there is one. It is off from reset on, and while the
    /// processor does not drive it.
    fn enable_outputs(&mut self, on: bool);

    /// Feeds the hardware watchdog, a [`Watchdog`](crate::watchdog::Watchdog) that is started before the first tick.
    fn feed(&mut self, tick: Complete);

    /// Bytes of the stack that were never used; 0 if that is not known.
    fn stack_free(&self) -> u32 {
        0
    }

    /// A counter of the processor's cycles, which wraps; 0 where there is none.
    fn cycles(&self) -> u32 {
        0
    }

    /// How fast [`Self::cycles`] counts, Hz; 0 where it does not.
    fn cycles_hz(&self) -> u32 {
        0
    }
}

/// The board as link and storage see it.
pub trait Port<'a> {
    /// The clock of [`Safety::now_us`].
    fn now_us(&self) -> u64;

    /// The counter of [`Safety::cycles`].
    fn cycles(&self) -> u32 {
        0
    }

    /// Bytes of the host that came, as many as fit: how many. It does not wait.
    fn receive(&mut self, into: &mut [u8]) -> usize;

    /// Takes bytes for the host, as many as there is room for: how many. It does not wait.
    fn send(&mut self, bytes: &[u8]) -> usize;

    /// Shows a range of flash to `look`, which is all that reads it; none if it cannot be read as memory.
    fn look<R>(&mut self, range: Range<u32>, look: impl FnOnce(&[u8]) -> R) -> Option<R>;

    /// A range of flash as memory, to be read in place for as long as the board runs; none if that cannot be.
    ///
    /// **Promise of the node**: it writes and erases nothing in this range until the loop has let go of the show that
    /// lies there. It asks for shows alone, and for another one only when the loop has answered.
    fn lend(&mut self, range: Range<u32>) -> Option<&'a [u8]>;

    /// Whether this board can drive servos as the bytes [behind a rig](super::split_rig) say. By default there must be
    /// none.
    fn drives(behind: &[u8]) -> bool {
        behind.is_empty()
    }
}

/// What was found at reset, before anything else ran: the reset's cause, and the record of a panic that RAM has kept.
/// The board clears both when it has read them.
pub fn causes(watchdog: bool, brown_out: bool, panic: bool) -> FaultSet {
    use crate::supervisor::Fault::{BrownOut, Panic, WatchdogReset};
    let all = [(watchdog, WatchdogReset), (brown_out, BrownOut), (panic, Panic)];
    all.into_iter().filter(|(is, _)| *is).map(|(_, fault)| fault).collect()
}
