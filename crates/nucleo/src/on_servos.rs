//! Simulated servos at the bus of an emulated board, in lock-step: each byte at its time, there and back.
//!
//! The machine stops as soon as what it says has left; then the servos hear it, at the time at which it left. What they
//! say is told to the machine from the time on at which it begins. So neither is ahead of what it hears.

use sinew_servo_sim::line::{Line, LineDevice};

use crate::machine::{Machine, MachineError, MachineEvent, Port};

/// So far off its rate a port still talks with one of that rate, parts per thousand.
const RATE_PERMILLE: u32 = 20;
/// The longest burst of a board takes less, ns.
const BURST_NS: u64 = 50_000_000;
/// Room for what servos say at once.
const IN_LEN: usize = 1024;

/// Bytes on the bus, one behind the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Burst {
    /// Whether the board said them, or servos did.
    pub is_own: bool,
    /// When the last of them had left, ns.
    pub end_ns: u64,
    /// Which.
    pub bytes: Vec<u8>,
}

/// What happened while it ran.
#[derive(Debug, Default)]
pub struct RunLog {
    /// What went over the bus.
    pub bus: Vec<Burst>,
    /// What the board said on its link.
    pub link: Vec<u8>,
    /// All else.
    pub other: Vec<MachineEvent>,
}

/// A board, and servos on its bus.
pub struct BoardOnServos<W> {
    /// The board.
    pub machine: Machine,
    /// The bus of the servos; their time is the board's, but for `began_ns`.
    pub line: Line<W>,
    /// When the servos' time began.
    began_ns: u64,
    baud: u32,
    at_ns: u64,
}

impl<W: LineDevice> BoardOnServos<W> {
    /// Servos at a board that stands at `at_ns`, whose time begins now. `baud`: at which they listen.
    pub fn new(machine: Machine, line: Line<W>, baud: u32, at_ns: u64) -> Self {
        Self { machine, line, began_ns: at_ns, baud, at_ns }
    }

    /// Where it stands, ns since the board's power-on.
    pub fn at_ns(&self) -> u64 {
        self.at_ns
    }

    /// Both run until a time of the board.
    ///
    /// # Errors
    /// [`MachineError`].
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

    /// The servos hear what has left.
    fn hear(&mut self, end_ns: u64, baud: u32, bytes: &[u8]) {
        let is_near = baud.abs_diff(self.baud) * 1000 <= RATE_PERMILLE * self.baud;
        self.line.servos.set_rate(if is_near { self.baud } else { baud });
        let took_ns = self.line.servos.wire_ns(bytes.len());
        let begin_ns = end_ns.saturating_sub(self.began_ns + took_ns);
        self.line.run_until(begin_ns);
        self.line.write(bytes);
        self.line.run_until(end_ns.saturating_sub(self.began_ns));
    }

    /// Servos say what is due: the machine hears it from now on.
    fn answer(&mut self, happened: &mut RunLog) -> Result<(), MachineError> {
        let now_ns = self.at_ns - self.began_ns;
        // What the board says now is heard when all of it has left, and begins before: until then servos stay behind.
        self.line.run_until(now_ns.saturating_sub(BURST_NS));
        while let Some(next_ns) = self.line.next_ns().filter(|next_ns| *next_ns <= now_ns) {
            self.line.run_until(next_ns);
        }
        // What a servo begins to say is heard to its end here, and told to the machine with its beginning; so is what
        // the next one says right behind it.
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
