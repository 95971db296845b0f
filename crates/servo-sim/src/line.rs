//! A stream of bytes to servos and back, with the time of each byte: the equivalent of a serial port.
//!
//! [`crate::bench::Bench::exchange`] is for a master that waits for its answers in simulated time. A line is for a
//! program that writes and reads at any time: in simulated time (a test) or in real time (a pseudo-terminal).
//!
//! ```
//! use sinew_servo_bus::dynamixel::Instruction;
//! use sinew_servo_sim::bench::Bench;
//! use sinew_servo_sim::device::{MEMORY_LEN, Servo};
//! use sinew_servo_sim::line::Line;
//! use sinew_servo_sim::load::Arm;
//! use sinew_servo_sim::model::Parameters;
//! use sinew_servo_sim::supply::Supply;
//!
//! let kind = Parameters::built_in("XL330-M288-T")?;
//! let mut memory = [0; MEMORY_LEN];
//! let servo = Servo::new(&kind, 7, &mut memory)?;
//! let mut line = Line::new(Bench::new(vec![servo], vec![Arm::default()], Supply::stiff(5.0)));
//!
//! let mut packet = [0; 16];
//! let len = Instruction::Ping.encode(7, &mut packet)?;
//! line.write(&packet[..len]);
//! // At 57,600 bps the question takes 1.7 ms, the answer 2.4; the servo waits 0.5 ms between them.
//! let mut reply = [0; 64];
//! assert_eq!(line.read(&mut reply, 4_000), 0);
//! assert_eq!(line.read(&mut reply, 2_000), 14);
//! assert_eq!(reply[..5], [0xFF, 0xFF, 0xFD, 0, 7]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::VecDeque;

use crate::wire::SILENCE_US;

/// Silence, ns, after which an unfinished packet ends, and a servo no longer waits for a silent servo but answers. A
/// program in real time may be paused inside a packet by the operating system: the silence of [`crate::bench::Bench`]
/// would be too short for it.
const SILENCE_NS: u64 = 2_000_000;

/// Servos on a half-duplex wire, with their simulated time.
pub trait LineDevice {
    /// Returns the simulated time, ns.
    fn now_ns(&self) -> u64;

    /// Advances the simulation to `ns`; does nothing if this time is already over.
    fn run_until(&mut self, ns: u64);

    /// Returns the time of `bytes` bytes on the wire, ns.
    fn wire_ns(&self, bytes: usize) -> u64;

    /// Sets the baud rate of the master's port, bits per second.
    fn set_rate(&mut self, baud: u32);

    /// Passes bytes to all servos except `speaker`.
    fn hear(&mut self, bytes: &[u8], speaker: Option<usize>);

    /// Returns the servo that sends next, and the silence before its first byte, us; `None` if no servo has bytes
    /// to send.
    fn next_speaker(&self) -> Option<(usize, u32)>;

    /// Returns the bytes that a servo sends, and their additional delay, us; `None` if it stays silent.
    fn speak(&mut self, speaker: usize) -> Option<(Vec<u8>, u32)>;

    /// Informs the servos that the wire was silent for long.
    fn silence(&mut self);
}

/// Bytes that are on the wire.
struct WireEntry {
    end_ns: u64,
    /// Servo that sends; `None` for the master.
    speaker: Option<usize>,
    bytes: Vec<u8>,
}

/// A line to servos. Bytes that arrive are stored until they are read.
pub struct Line<W> {
    /// Servos on the line.
    pub servos: W,
    unsent: Vec<u8>,
    on_wire: Option<WireEntry>,
    late: Vec<(u64, Vec<u8>)>,
    silence_ns: u64,
    quiet_since_ns: u64,
    was_silent: bool,
    received: VecDeque<u8>,
}

impl<W: LineDevice> Line<W> {
    /// Creates a line for a program in real time.
    pub fn new(servos: W) -> Self {
        Self::with_silence(servos, SILENCE_NS)
    }

    /// Creates a line for a master in simulated time, which does not pause inside a packet.
    pub fn of_master(servos: W) -> Self {
        Self::with_silence(servos, u64::from(SILENCE_US) * 1000)
    }

    fn with_silence(servos: W, silence_ns: u64) -> Self {
        Self {
            servos,
            unsent: Vec::new(),
            on_wire: None,
            late: Vec::new(),
            silence_ns,
            quiet_since_ns: 0,
            was_silent: true,
            received: VecDeque::new(),
        }
    }

    /// Writes bytes from the master at the present time. They wait until the wire is free.
    pub fn write(&mut self, bytes: &[u8]) {
        self.unsent.extend_from_slice(bytes);
        self.send();
    }

    /// Returns whether bytes of the master are on the wire or wait for the wire.
    pub fn is_sending(&self) -> bool {
        let of_master = |on_wire: &WireEntry| on_wire.speaker.is_none();
        !self.unsent.is_empty() || self.on_wire.as_ref().is_some_and(of_master)
    }

    /// Returns the time at which a servo's present bytes leave the wire, ns; `None` if no servo sends.
    pub fn speaks_until_ns(&self) -> Option<u64> {
        self.on_wire.as_ref().filter(|on_wire| on_wire.speaker.is_some()).map(|said| said.end_ns)
    }

    /// Reads the bytes that have arrived so far. Returns their number: 0 if none has arrived.
    pub fn take(&mut self, out: &mut [u8]) -> usize {
        let len = out.len().min(self.received.len());
        for (to, from) in out.iter_mut().zip(self.received.drain(..len)) {
            *to = from;
        }
        len
    }

    /// Advances the simulation until bytes arrive, or for `timeout_us`. Returns the number of bytes read: 0 if none has
    /// arrived.
    pub fn read(&mut self, out: &mut [u8], timeout_us: u32) -> usize {
        let end_ns = self.servos.now_ns() + u64::from(timeout_us) * 1000;
        while self.received.is_empty() && self.next_ns().is_some_and(|next| next <= end_ns) {
            self.pass_next();
        }
        if self.received.is_empty() {
            self.servos.run_until(end_ns);
        }
        self.take(out)
    }

    /// Advances the simulation to `ns`.
    pub fn run_until(&mut self, ns: u64) {
        run_all(std::slice::from_mut(self), ns);
    }

    /// Returns the time of the next event on the wire, ns; `None` if the wire stays silent.
    pub fn next_ns(&self) -> Option<u64> {
        let late = self.late.iter().map(|(at_ns, _)| *at_ns).min();
        let wire = match &self.on_wire {
            Some(on_wire) => Some(on_wire.end_ns),
            None => match self.servos.next_speaker() {
                Some((_, delay_us)) => Some(self.quiet_since_ns + u64::from(delay_us) * 1000),
                None => (!self.was_silent).then_some(self.quiet_since_ns + self.silence_ns),
            },
        };
        late.into_iter().chain(wire).min()
    }

    /// Executes the next event on the wire.
    fn pass_next(&mut self) {
        let Some(next_ns) = self.next_ns() else { return };
        self.servos.run_until(next_ns);
        let now_ns = self.servos.now_ns();
        let is_late = |(at_ns, _): &(u64, Vec<u8>)| *at_ns <= now_ns;
        if let Some(index) = self.late.iter().position(is_late) {
            // The late reply collides with other bytes, so no servo understands it.
            let (_, bytes) = self.late.swap_remove(index);
            self.received.extend(bytes);
        } else if let Some(on_wire) = self.on_wire.take() {
            self.quiet_since_ns = now_ns;
            self.servos.hear(&on_wire.bytes, on_wire.speaker);
            if on_wire.speaker.is_some() {
                self.received.extend(on_wire.bytes);
            }
            self.send();
        } else if let Some((speaker, _)) = self.servos.next_speaker() {
            match self.servos.speak(speaker) {
                Some((bytes, 0)) => self.put_on_wire(bytes, Some(speaker)),
                Some((bytes, late_us)) => {
                    let took_ns = self.servos.wire_ns(bytes.len());
                    self.late.push((now_ns + u64::from(late_us) * 1000 + took_ns, bytes));
                }
                None => {}
            }
        } else {
            self.was_silent = true;
            self.servos.silence();
        }
    }

    fn send(&mut self) {
        if self.on_wire.is_none() && !self.unsent.is_empty() {
            let bytes = std::mem::take(&mut self.unsent);
            self.put_on_wire(bytes, None);
        }
    }

    fn put_on_wire(&mut self, bytes: Vec<u8>, speaker: Option<usize>) {
        let end_ns = self.servos.now_ns() + self.servos.wire_ns(bytes.len());
        self.on_wire = Some(WireEntry { end_ns, speaker, bytes });
        self.was_silent = false;
    }
}

/// Advances several lines together. Events on all wires are executed in the order of time, since servos on different
/// lines may move the same rig.
pub fn run_all<W: LineDevice>(lines: &mut [Line<W>], ns: u64) {
    while let Some((index, next_ns)) = next_of(lines)
        && next_ns <= ns
    {
        lines[index].pass_next();
    }
    for line in lines {
        line.servos.run_until(ns);
    }
}

/// Returns the line with the next event, and its time. If several events have the same time, the first line is chosen.
/// Returns `None` if all wires stay silent.
pub(crate) fn next_of<W: LineDevice>(lines: &[Line<W>]) -> Option<(usize, u64)> {
    let next = lines.iter().enumerate().filter_map(|(index, line)| Some((index, line.next_ns()?)));
    next.min_by_key(|(_, next_ns)| *next_ns)
}
