//! A simulated board in real time, on a serial port of this machine.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use sinew_servo_sim::load::Plant;
use sinew_servo_sim::port::Port;

use super::SimulatedBoard;

/// What the machine is late by beyond this is taken out of the board's time, not made good.
const CATCH_UP: Duration = Duration::from_millis(50);
/// What programs do not read in time is lost beyond this, bytes.
const ROOM: usize = 1 << 16;

impl<P: Plant> SimulatedBoard<'_, P> {
    /// Serves programs at a port in real time until `stop` is true. `before`: what happens to the rig before each tick.
    ///
    /// # Errors
    /// What the system says if reading or writing fails.
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
