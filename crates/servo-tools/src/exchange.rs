//! A line that servos hang on.

use std::io;
use std::ops::DerefMut;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// A half-duplex line: bytes out, and what comes back. A serial port is one, a simulated line is another, and a board
/// that passes packets on can be a third.
pub trait Exchange {
    /// Forgets what came before, sends `bytes`, and gives what comes to `take` until that says that it has all, or
    /// `wait` is over since the call.
    ///
    /// # Errors
    /// What the line says: it is gone. Silence is no error.
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()>;

    /// Talks and listens at this rate from now on, bits per second.
    ///
    /// # Errors
    /// If the line does not do this rate; [`io::ErrorKind::ResourceBusy`] if it does nothing now.
    fn set_baud(&mut self, baud: u32) -> io::Result<()>;

    /// Nobody talks for a while.
    fn pause(&mut self, time: Duration);

    /// Returns the time on the line since some moment that stays the same. A simulated line has a time of its own.
    fn now(&mut self) -> Duration {
        static START: OnceLock<Instant> = OnceLock::new();
        START.get_or_init(Instant::now).elapsed()
    }
}

// A box or a mutable borrow of a line is a line.
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
