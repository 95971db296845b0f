//! A line that connects servos.

use std::io;
use std::ops::DerefMut;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// A half-duplex line: it sends bytes and returns the answer. Examples: a serial port, a simulated line, a board that
/// passes packets on.
pub trait Exchange {
    /// Discards earlier bytes, sends `bytes`, and passes received bytes to `take`. Ends when `take` returns true, or
    /// `wait` after the call.
    ///
    /// # Errors
    /// An error means that the line failed. Silence is not an error.
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()>;

    /// Sets the baud rate, bits per second.
    ///
    /// # Errors
    /// An error if the line does not support this rate; [`io::ErrorKind::ResourceBusy`] if the line is not available
    /// now.
    fn set_baud(&mut self, baud: u32) -> io::Result<()>;

    /// Waits without any traffic.
    fn pause(&mut self, time: Duration);

    /// Returns the time on the line since a fixed moment. A simulated line has its own time.
    fn now(&mut self) -> Duration {
        static START: OnceLock<Instant> = OnceLock::new();
        START.get_or_init(Instant::now).elapsed()
    }
}

// A box or a mutable borrow of a line is itself a line.
impl<P: DerefMut> Exchange for P
where
    P::Target: Exchange,
{
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()> {
        (**self).exchange(bytes, wait, take)
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        (**self).set_baud(baud)
    }

    fn pause(&mut self, time: Duration) {
        (**self).pause(time);
    }

    fn now(&mut self) -> Duration {
        (**self).now()
    }
}
