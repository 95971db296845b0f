//! An emulated board as a line for a client of the host link: bytes in both directions, and the board's own clock.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use sinew_board_client::Line;
use sinew_servo_sim::line::LineDevice;

use crate::machine::{MachineEvent, Port};
use crate::on_servos::{BoardOnServos, Burst};

/// Step of the emulation while the host waits, ns. A byte of the host link is noticed at most this late.
const STEP_NS: u64 = 500_000;

/// An emulated board with its servos, as seen by its host.
pub struct EmulatedBoard<W> {
    /// Board and servos.
    pub servos: BoardOnServos<W>,
    /// Bytes on the bus since the list was last taken.
    pub bus: Vec<Burst>,
    /// Other events since the list was last taken.
    pub other: Vec<MachineEvent>,
    said: VecDeque<u8>,
}

impl<W: LineDevice> EmulatedBoard<W> {
    /// Creates a board that has received nothing from a host.
    pub fn new(servos: BoardOnServos<W>) -> Self {
        Self { servos, bus: Vec::new(), other: Vec::new(), said: VecDeque::new() }
    }

    /// Runs until a time of the board, ns.
    ///
    /// # Errors
    /// An error if the emulator has ended.
    pub fn run_until(&mut self, to_ns: u64) -> io::Result<()> {
        let happened = self.servos.run_until(to_ns).map_err(io::Error::other)?;
        self.bus.extend(happened.bus);
        self.other.extend(happened.other);
        self.said.extend(happened.link);
        Ok(())
    }
}

impl<W: LineDevice> Line for EmulatedBoard<W> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let now_ns = self.servos.at_ns();
        self.servos.machine.say(Port::Link, now_ns, bytes).map_err(io::Error::other)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let wait_ns = u64::try_from(wait.as_nanos()).unwrap_or(u64::MAX);
        let end_ns = self.servos.at_ns().saturating_add(wait_ns);
        while self.said.is_empty() && self.servos.at_ns() < end_ns {
            self.run_until(end_ns.min(self.servos.at_ns() + STEP_NS))?;
        }
        let count = into.len().min(self.said.len());
        into.iter_mut().zip(self.said.drain(..count)).for_each(|(to, byte)| *to = byte);
        Ok(count)
    }

    fn now(&self) -> Duration {
        Duration::from_nanos(self.servos.at_ns())
    }
}
