//! The complete wiring of a rig, as bytes and as settings of a controller.

use heapless::Vec;
use sinew_core::tracker::Settings as TrackerSettings;
use sinew_firmware::controller::{ControllerSettings, ServoSetup};
use sinew_firmware::node::join_rig;
use sinew_servo_bus::Schedule;

use crate::error::{VERSION, WiringError};
use crate::{Bus, BusLine, LineServo, Lines, Servo};

/// Maximum number of lines in a wiring; boards hold fewer.
pub const LINES: usize = 4;

/// Wiring of a rig with at most `SERVOS` servos, on a board with at most `L` lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Wiring<const L: usize, const SERVOS: usize> {
    /// Control rate in ticks per second.
    pub rate_hz: u32,
    /// Index of the line whose schedule the controller uses.
    pub latest: usize,
    /// Method and gains of the tracker.
    pub tracker: TrackerSettings,
    /// Lines of the board.
    pub lines: Vec<BusLine, L>,
    /// Servos, in the rig's order.
    pub servos: Vec<Servo, SERVOS>,
}

impl<const L: usize, const SERVOS: usize> Wiring<L, SERVOS> {
    /// Writes the wiring after a rig's compact form, which is the first `len` bytes of `item`. Returns the length of
    /// the whole item, or `None` if there is no room.
    #[must_use]
    pub fn append(&self, item: &mut [u8], len: usize) -> Option<usize> {
        let head = (VERSION, self.rate_hz, self.latest, self.tracker);
        let mut at = len;
        at = put(item, at, &head)?;
        at = put(item, at, &self.lines.len())?;
        for line in &self.lines {
            at = put(item, at, line)?;
        }
        at = put(item, at, &self.servos.len())?;
        for servo in &self.servos {
            at = put(item, at, servo)?;
        }
        join_rig(item, len, at)
    }

    /// Reads the wiring that is stored after a rig. O(servos).
    ///
    /// # Errors
    /// [`WiringError::Bytes`], or the error that there are too many lines or servos.
    pub fn decode(mut bytes: &[u8]) -> Result<Self, WiringError> {
        let (version, rate_hz, latest, tracker): (u8, _, _, _) = take(&mut bytes)?;
        if version != VERSION {
            return Err(WiringError::Bytes);
        }
        let mut wiring = Self { rate_hz, latest, tracker, lines: Vec::new(), servos: Vec::new() };
        for _ in 0..take::<usize>(&mut bytes)? {
            wiring.lines.push(take(&mut bytes)?).map_err(|_| WiringError::Line)?;
        }
        for _ in 0..take::<usize>(&mut bytes)? {
            let full = WiringError::Servos { holds: SERVOS };
            wiring.servos.push(take(&mut bytes)?).map_err(|_| full)?;
        }
        if bytes.is_empty() { Ok(wiring) } else { Err(WiringError::Bytes) }
    }

    /// Returns the controller's settings: the default ones, with this wiring's tracker.
    pub fn settings(&self) -> ControllerSettings {
        ControllerSettings { tracker: self.tracker, ..ControllerSettings::default() }
    }

    /// Returns the controller's settings for each servo.
    pub fn setups(&self) -> Vec<ServoSetup, SERVOS> {
        self.servos.iter().map(|servo| servo.setup).collect()
    }

    /// Returns the schedule of the line that the controller uses.
    ///
    /// # Errors
    /// [`WiringError`] if there is no such line, or the line is too slow.
    pub fn schedule(&self) -> Result<Schedule, WiringError> {
        self.lines.get(self.latest).ok_or(WiringError::Line)?.schedule(self.rate_hz)
    }

    /// Creates the bus of a line.
    ///
    /// # Errors
    /// [`WiringError`] if there is no such line; otherwise as in [`BusLine::bus`].
    // Not inlined into its caller: a bus is large, and where several are made, only one is on the stack at a time.
    #[inline(never)]
    pub fn bus(&self, line: usize) -> Result<Bus<SERVOS>, WiringError> {
        self.lines.get(line).ok_or(WiringError::Line)?.bus(self.on_line(line), self.rate_hz)
    }

    /// Returns the servos of a line, in the rig's order.
    fn on_line(&self, line: usize) -> impl Iterator<Item = LineServo> {
        let own = self.servos.iter().filter(move |servo| servo.line == line);
        own.map(|servo| servo.on_line)
    }

    /// Checks that a controller can be made with this wiring.
    ///
    /// # Errors
    /// Returns the errors of [`Self::bus`] and [`Self::schedule`], or that a servo is on a line that does not exist.
    pub fn check(&self) -> Result<(), WiringError> {
        if self.servos.iter().any(|servo| servo.line >= self.lines.len()) {
            return Err(WiringError::Line);
        }
        self.schedule()?;
        let mut lines = self.lines.iter().enumerate();
        lines.try_for_each(|(index, line)| line.check::<SERVOS>(self.on_line(index), self.rate_hz))
    }

    /// Adds the buses of all lines, and their servos, to empty `lines`.
    ///
    /// # Errors
    /// Returns the errors of [`Self::check`].
    pub fn connect(&self, lines: &mut Lines<Bus<SERVOS>, L, SERVOS>) -> Result<(), WiringError> {
        self.check()?;
        for line in 0..self.lines.len() {
            lines.add(self.bus(line)?);
        }
        self.servos.iter().for_each(|servo| lines.place(servo.line));
        Ok(())
    }
}

fn put(item: &mut [u8], at: usize, what: &impl serde::Serialize) -> Option<usize> {
    let room = item.get_mut(at..)?;
    let len = postcard::to_slice(what, room).ok()?.len();
    at.checked_add(len)
}

fn take<'b, T: serde::Deserialize<'b>>(bytes: &mut &'b [u8]) -> Result<T, WiringError> {
    let (item, rest) = postcard::take_from_bytes(bytes).map_err(|_| WiringError::Bytes)?;
    *bytes = rest;
    Ok(item)
}
