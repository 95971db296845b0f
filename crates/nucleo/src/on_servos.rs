//! Connects simulated servos to the bus of an emulated board, in lockstep, with the time of each byte.
//!
//! The machine stops as soon as its bytes have left; then the servos receive them, at that time. The servos' answers
//! are passed to the machine with the time of their first byte. Neither side thus runs ahead of the bytes that it
//! receives.

use sinew_servo_sim::line::{Line, LineDevice};

use crate::machine::{Machine, MachineError, MachineEvent, Port};

/// Tolerance of baud rates, in parts per thousand: a port and a device within it understand each other.
const RATE_PERMILLE: u32 = 20;
/// Maximum time of a burst of the board, ns.
const BURST_NS: u64 = 50_000_000;
/// Maximum number of bytes that servos send at once.
const IN_LEN: usize = 1024;

/// Consecutive bytes on the bus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Burst {
    /// Whether the board sent the bytes; otherwise servos did.
    pub is_own: bool,
    /// Time at which the last byte had left, ns.
    pub end_ns: u64,
    /// Bytes that were sent.
    pub bytes: Vec<u8>,
}

/// The events of a run.
#[derive(Debug, Default)]
pub struct RunLog {
    /// Bytes on the bus.
    pub bus: Vec<Burst>,
    /// Bytes that the board sent on its host link.
    pub link: Vec<u8>,
    /// Other events.
    pub other: Vec<MachineEvent>,
}

/// An emulated board with servos on its bus.
pub struct BoardOnServos<W> {
    /// Emulated board.
    pub machine: Machine,
    /// Bus of the servos. Their time is the board's time minus `began_ns`.
    pub line: Line<W>,
    /// Time of the board at which the servos' time began, ns.
    began_ns: u64,
    baud: u32,
    at_ns: u64,
}

impl<W: LineDevice> BoardOnServos<W> {
    /// Connects servos, whose time begins now, to a board at time `at_ns`. `baud` is the servos' baud rate.
    pub fn new(machine: Machine, line: Line<W>, baud: u32, at_ns: u64) -> Self {
        Self { machine, line, began_ns: at_ns, baud, at_ns }
    }

    /// Returns the present time, ns since the board's power-on.
    pub fn at_ns(&self) -> u64 {
        self.at_ns
    }

    /// Runs both until a time of the board, ns.
    ///
    /// # Errors
    /// [`MachineError`] if the emulator has ended.
    pub fn run_until(&mut self, to_ns: u64) -> Result<RunLog, MachineError> {
        let mut happened = RunLog::default();
        while self.at_ns < to_ns {
            let speaks_ns = self.line.next_ns().map(|at_ns| at_ns + self.began_ns);
            let next_ns = speaks_ns.map_or(to_ns, |at_ns| at_ns.clamp(self.at_ns + 1, to_ns));
            let stopped = self.machine.run(next_ns)?;
            self.at_ns = stopped.at_ns;
            for heard in stopped.heard {
                match heard {
                    MachineEvent::Bus { end_ns, baud, bytes } => {
                        self.hear(end_ns, baud, &bytes);
                        happened.bus.push(Burst { is_own: true, end_ns, bytes });
                    }
                    MachineEvent::Link(_, bytes) => happened.link.extend(bytes),
                    other => happened.other.push(other),
                }
            }
            self.answer(&mut happened)?;
        }
        Ok(happened)
    }

    /// Passes the board's bytes to the servos.
    fn hear(&mut self, end_ns: u64, baud: u32, bytes: &[u8]) {
        let is_near = baud.abs_diff(self.baud) * 1000 <= RATE_PERMILLE * self.baud;
        self.line.servos.set_rate(if is_near { self.baud } else { baud });
        let took_ns = self.line.servos.wire_ns(bytes.len());
        let begin_ns = end_ns.saturating_sub(self.began_ns + took_ns);
        self.line.run_until(begin_ns);
        self.line.write(bytes);
        self.line.run_until(end_ns.saturating_sub(self.began_ns));
    }

    /// Passes the servos' answers that are due to the machine.
    fn answer(&mut self, happened: &mut RunLog) -> Result<(), MachineError> {
        let now_ns = self.at_ns - self.began_ns;
        // A burst of the board arrives as a whole at its end, but begins earlier: the servos' time must not pass its
        // start.
        self.line.run_until(now_ns.saturating_sub(BURST_NS));
        while let Some(next_ns) = self.line.next_ns().filter(|next_ns| *next_ns <= now_ns) {
            self.line.run_until(next_ns);
        }
        // An answer of a servo is simulated to its end, and passed to the machine with the time of its first byte. If
        // the next servo answers directly after it, its answer is passed in the same way.
        while let Some(end_ns) = self.line.speaks_until_ns() {
            let mut said = [0; IN_LEN];
            self.line.run_until(end_ns);
            let len = self.line.take(&mut said);
            if len == 0 {
                break;
            }
            let bytes = &said[..len];
            let from_ns = end_ns.saturating_sub(self.line.servos.wire_ns(len)) + self.began_ns;
            self.machine.say(Port::Bus, from_ns, bytes)?;
            let end_ns = end_ns + self.began_ns;
            happened.bus.push(Burst { is_own: false, end_ns, bytes: bytes.to_vec() });
        }
        Ok(())
    }
}
