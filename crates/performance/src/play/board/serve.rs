//! Serves a simulated board in real time to a host.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use sinew_servo_sim::load::Plant;
#[cfg(unix)]
use sinew_servo_sim::port::Port;

use super::SimulatedBoard;

/// Longest delay of the machine that the board catches up. After a longer delay, the board's time is shifted.
const CATCH_UP: Duration = Duration::from_millis(50);
/// Time of a byte on a line of 1 bit/s, ns: start bit, eight bits, stop bit.
const BYTE: u128 = 10_000_000_000;
/// Longest output that waits for a program to read it, bytes. Further output is lost.
const ROOM: usize = 1 << 16;

/// A line between a simulated board and its host, from the board's point of view.
pub trait HostSide {
    /// Returns the rate of the line, bit/s.
    ///
    /// # Errors
    /// An I/O error if the line has failed.
    fn baud(&self) -> io::Result<u32>;

    /// Reads bytes of the host, without waiting. Returns their number, or 0.
    ///
    /// # Errors
    /// An I/O error if the line has failed.
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize>;

    /// Writes bytes for the host, without waiting. Returns the number of bytes for which there was room.
    ///
    /// # Errors
    /// An I/O error if the line has failed.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize>;
}

#[cfg(unix)]
impl HostSide for &Port {
    fn baud(&self) -> io::Result<u32> {
        Port::baud(self)
    }

    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        Port::read(self, into)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Port::write(self, bytes)
    }
}

impl<P: Plant> SimulatedBoard<'_, P> {
    /// Serves a host in real time until `stop` is true. `before` is called before each tick, and can act on the rig. In
    /// a tick, at most as many bytes pass in each direction as a line with the host's rate can carry. Further bytes
    /// wait, so that a program that sends too fast for a real board also sends too fast for this board.
    ///
    /// # Errors
    /// An I/O error of reading or writing.
    pub fn serve(
        &mut self,
        mut host: impl HostSide,
        stop: &AtomicBool,
        mut before: impl FnMut(&mut Self),
    ) -> io::Result<()> {
        let (mut bytes, mut due) = ([0; 4096], Instant::now());
        let [mut input, mut output] = [Share::default(); 2];
        while !stop.load(Ordering::Relaxed) {
            let (baud, tick) = (host.baud()?, self.tick_time());
            let most = input.grow(baud, tick).min(bytes.len());
            let count = host.read(&mut bytes[..most])?;
            input.take(count);
            self.give(&bytes[..count]);
            let before_us = self.now_us();
            before(self);
            self.tick();
            let most = output.grow(baud, tick).min(self.said.len());
            let taken = host.write(&self.said.make_contiguous()[..most])?;
            output.take(taken);
            self.said.drain(..taken);
            self.said.truncate(ROOM);
            due += Duration::from_micros(self.now_us() - before_us).max(tick);
            let now = Instant::now();
            due = due.max(now.checked_sub(CATCH_UP).unwrap_or(now));
            std::thread::sleep(due.saturating_duration_since(now));
        }
        Ok(())
    }
}

/// Bits that a line can still carry in one direction, times 10⁹.
#[derive(Debug, Clone, Copy, Default)]
struct Share(u128);

impl Share {
    /// Adds the share of a tick, and returns the number of whole bytes that the line can carry. The share of unused
    /// ticks is lost, as on a real line.
    fn grow(&mut self, baud: u32, tick: Duration) -> usize {
        let of_tick = u128::from(baud) * tick.as_nanos();
        self.0 = (self.0 + of_tick).min(of_tick + BYTE);
        usize::try_from(self.0 / BYTE).unwrap_or(usize::MAX)
    }

    fn take(&mut self, bytes: usize) {
        self.0 = self.0.saturating_sub(bytes as u128 * BYTE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_carries_its_rate_and_no_more() {
        let mut share = Share::default();
        let tick = Duration::from_millis(2);
        // 11.52 bytes in a tick of 2 ms.
        let carried: usize = (0..1000)
            .map(|_| {
                let bytes = share.grow(57_600, tick);
                share.take(bytes);
                bytes
            })
            .sum();
        assert!((11_519..=11_520).contains(&carried), "{carried}");
        // A line that was idle carries no burst.
        (0..1000).for_each(|_| _ = share.grow(57_600, tick));
        assert_eq!(share.grow(57_600, tick), 12);
    }
}
