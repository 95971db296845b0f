//! The hardware's interface to a node. Each method states its duty. Writable flash is a `NorFlash`, a bus of servos
//! is a [`Wire`](crate::controller::Wire).

use core::ops::Range;

use crate::supervisor::FaultSet;
use crate::watchdog::Complete;

/// The board as the control loop uses it. All methods return at once.
pub trait Safety {
    /// Returns the time since the board's start, µs. It never decreases, and continues while flash is erased.
    fn now_us(&self) -> u64;

    /// Returns whether the emergency stop's circuit is open, or its wire is cut. That circuit cuts the servos'
    /// power by itself; this method only reports its state.
    fn is_stopped(&mut self) -> bool;

    /// Switches the line that enables the servos' signals (OE), if there is one. It is off from reset on, and while
    /// the processor does not drive it.
    fn enable_outputs(&mut self, on: bool);

    /// Feeds the hardware watchdog, a [`Watchdog`](crate::watchdog::Watchdog) that is started before the first tick.
    fn feed(&mut self, tick: Complete);

    /// Returns the number of bytes of the stack that were never used; 0 if that is not known.
    fn stack_free(&self) -> u32 {
        0
    }

    /// Returns a counter of the processor's cycles, which wraps; 0 if there is none.
    fn cycles(&self) -> u32 {
        0
    }

    /// Returns the frequency of [`Self::cycles`], Hz; 0 if there is no counter.
    fn cycles_hz(&self) -> u32 {
        0
    }
}

/// The board as the background task uses it: host link and flash.
pub trait Port<'a> {
    /// Returns the same clock as [`Safety::now_us`].
    fn now_us(&self) -> u64;

    /// Returns the same counter as [`Safety::cycles`].
    fn cycles(&self) -> u32 {
        0
    }

    /// Reads bytes that arrived from the host, as many as fit, and returns their number. Does not wait.
    fn receive(&mut self, into: &mut [u8]) -> usize;

    /// Sends bytes to the host, as many as there is room for, and returns their number. Does not wait.
    fn send(&mut self, bytes: &[u8]) -> usize;

    /// Calls `look` with a range of flash. Returns `None` if flash is not readable as memory.
    fn look<R>(&mut self, range: Range<u32>, look: impl FnOnce(&[u8]) -> R) -> Option<R>;

    /// Returns a range of flash as memory, to be read in place as long as the board runs, or `None` if that is not
    /// possible.
    ///
    /// **Guarantee of the node**: it writes and erases nothing in this range until the loop has released the show
    /// that is stored there. It requests only shows, and requests another one only after the loop has answered.
    fn lend(&mut self, range: Range<u32>) -> Option<&'a [u8]>;

    /// Returns whether this board can drive servos as described by the bytes [after a rig](super::split_rig). By
    /// default there must be no such bytes.
    fn drives(behind: &[u8]) -> bool {
        behind.is_empty()
    }
}

/// Returns the faults that were found at reset, before anything else ran: the reset's cause, and the record of a
/// panic in RAM. The board clears both after reading them.
pub fn causes(watchdog: bool, brown_out: bool, panic: bool) -> FaultSet {
    use crate::supervisor::Fault::{BrownOut, Panic, WatchdogReset};
    let all = [(watchdog, WatchdogReset), (brown_out, BrownOut), (panic, Panic)];
    all.into_iter().filter(|(is, _)| *is).map(|(_, fault)| fault).collect()
}
