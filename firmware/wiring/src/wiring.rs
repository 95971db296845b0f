//! All of a rig's wiring, as bytes and as what a controller is made of.

use heapless::Vec;
use sinew_core::tracker::Settings as TrackerSettings;
use sinew_firmware::controller::{ControllerSettings, ServoSetup};
use sinew_firmware::node::join_rig;
use sinew_servo_bus::Schedule;

use crate::error::{VERSION, WiringError};
use crate::{Bus, BusLine, LineServo, Lines, Servo};

/// Lines that a rig is told with at most; boards hold fewer.
pub const LINES: usize = 4;

/// How a rig of at most `SERVOS` servos hangs on its board, of at most `L` lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Wiring<const L: usize, const SERVOS: usize> {
    /// Ticks a second.
    pub rate_hz: u32,
    /// The line whose schedule the controller goes by.
    pub latest: usize,
    /// Method and gains.
    pub tracker: TrackerSettings,
    /// The lines.
    pub lines: Vec<BusLine, L>,
    /// The servos, in the rig's order.
    pub servos: Vec<Servo, SERVOS>,
}

impl<const L: usize, const SERVOS: usize> Wiring<L, SERVOS> {
    /// Writes it behind the `len` bytes of a rig's compact form that `item` begins with, and says how long the whole
    /// item is. None if there is no room.
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

    /// Reads what is behind a rig. O(servos).
    ///
    /// # Errors
    /// [`WiringError::Bytes`], or that there are too many lines or servos.
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

    /// Settings of a controller by it.
    pub fn settings(&self) -> ControllerSettings {
        ControllerSettings { tracker: self.tracker, ..ControllerSettings::default() }
    }

    /// What a controller knows of each servo.
    pub fn setups(&self) -> Vec<ServoSetup, SERVOS> {
        self.servos.iter().map(|servo| servo.setup).collect()
    }

    /// The schedule of the line that the controller goes by.
    ///
    /// # Errors
    /// [`WiringError`] if there is no such line, or it is too slow.
    pub fn schedule(&self) -> Result<Schedule, WiringError> {
        self.lines.get(self.latest).ok_or(WiringError::Line)?.schedule(self.rate_hz)
    }

    /// The bus of a line.
    ///
    /// # Errors
    /// [`WiringError`] names what cannot be on it.
    // Not within its caller: a bus is large, and where several are made, one is on the stack at a time.
    #[inline(never)]
    pub fn bus(&self, line: usize) -> Result<Bus<SERVOS>, WiringError> {
        self.lines.get(line).ok_or(WiringError::Line)?.bus(self.on_line(line), self.rate_hz)
    }

    /// The servos of a line.
    fn on_line(&self, line: usize) -> impl Iterator<Item = LineServo> {
        let own = self.servos.iter().filter(move |servo| servo.line == line);
        own.map(|servo| servo.on_line)
    }

    /// That a controller can be made by it.
    ///
    /// # Errors
    /// As [`Self::bus`] and [`Self::schedule`], or that a servo is on a line that there is not.
    pub fn check(&self) -> Result<(), WiringError> {
        if self.servos.iter().any(|servo| servo.line >= self.lines.len()) {
            return Err(WiringError::Line);
        }
        self.schedule()?;
        let mut lines = self.lines.iter().enumerate();
        lines.try_for_each(|(index, line)| line.check::<SERVOS>(self.on_line(index), self.rate_hz))
    }

    /// Puts the buses of all lines, and their servos, into lines that have none.
    ///
    /// # Errors
    /// As [`Self::check`].
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
