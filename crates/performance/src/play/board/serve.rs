//! Serves a simulated board in real time, on a serial port of this machine.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use sinew_servo_sim::load::Plant;
use sinew_servo_sim::port::Port;

use super::SimulatedBoard;

/// A longer delay of the machine is removed from the board's time instead of being made up.
const CATCH_UP: Duration = Duration::from_millis(50);
/// Longest output that waits for a program to read it, bytes. Further output is lost.
const ROOM: usize = 1 << 16;

impl<P: Plant> SimulatedBoard<'_, P> {
    /// Serves programs at a port in real time until `stop` is true. `before` is called before each tick, to act on
    /// the rig.
    ///
    /// # Errors
    /// An I/O error of reading or writing.
    pub fn serve(
        &mut self,
        port: &Port,
        stop: &AtomicBool,
        mut before: impl FnMut(&mut Self),
    ) -> io::Result<()> {
        let (mut bytes, mut due) = ([0; 4096], Instant::now());
        while !stop.load(Ordering::Relaxed) {
            loop {
                let count = port.read(&mut bytes)?;
                let Some(came) = bytes.get(..count).filter(|came| !came.is_empty()) else { break };
                self.give(came);
            }
            let before_us = self.now_us();
            before(self);
            self.tick();
            let taken = port.write(self.said.make_contiguous())?;
            self.said.drain(..taken);
            self.said.truncate(ROOM);
            due += Duration::from_micros(self.now_us() - before_us).max(self.tick_time());
            let now = Instant::now();
            due = due.max(now.checked_sub(CATCH_UP).unwrap_or(now));
            std::thread::sleep(due.saturating_duration_since(now));
        }
        Ok(())
    }
}
