//! All of a rig's wiring, as bytes and as what a controller is made of.

use heapless::Vec;
use sinew_bus::{Schedule, ScheduleError, SetupError};
use sinew_core::tracker::Settings as TrackerSettings;
use sinew_firmware::controller::{ControllerSettings, ServoSetup};
use sinew_firmware::node::join_rig;
use thiserror::Error;

use crate::{Bus, Line, Servo};

/// Lines that a rig is told with at most; boards hold fewer.
pub const LINES: usize = 4;

/// Version of the bytes.
const VERSION: u8 = 1;

/// How a rig of at most `S` servos hangs on its board, of at most `L` lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Wiring<const L: usize, const S: usize> {
    /// Ticks a second.
    pub rate_hz: u32,
    /// The line whose schedule the controller goes by.
    pub latest: usize,
    /// Method and gains.
    pub tracker: TrackerSettings,
    /// The lines.
    pub lines: Vec<Line, L>,
    /// The servos, in the rig's order.
    pub servos: Vec<Servo, S>,
}

/// Why a wiring is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum WiringError {
    /// The bytes are no wiring of this version, or not all of it.
    #[error("not a wiring of version {VERSION}")]
    Bytes,
    /// There are too many servos.
    #[error("the board holds {holds} servos; the wiring has more")]
    Servos {
        /// How many the board holds.
        holds: usize,
    },
    /// There are too many lines, none, or a servo or the loop is on one that there is not.
    #[error("there are too many lines for this board, none, or servos on one that there is not")]
    Line,
    /// A Dynamixel is of no model in the table.
    #[error("servo {id} is a Dynamixel of model {found}, which is not in the table")]
    Model {
        /// Its id.
        id: u8,
        /// Its number.
        found: u16,
    },
    /// A servo is on a line of another maker's.
    #[error("a servo is on a line where another protocol is spoken")]
    Protocol,
    /// The chip's clock cannot be divided so.
    #[error("a PCA9685 makes 24 to 1526 pulses a second at 25 MHz")]
    Pulses,
    /// A line is too slow.
    #[error(transparent)]
    Schedule(ScheduleError),
    /// A servo's setting.
    #[error(transparent)]
    Setup(SetupError),
}

/// What a controller is made of, beside the rig.
pub struct Built<const L: usize, const S: usize> {
    /// Of the controller.
    pub settings: ControllerSettings,
    /// Of each servo.
    pub servos: Vec<ServoSetup, S>,
    /// The line's that the controller goes by.
    pub schedule: Schedule,
    /// The bus of each line.
    pub buses: Vec<Bus<S>, L>,
}

impl<const L: usize, const S: usize> Wiring<L, S> {
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
            let full = WiringError::Servos { holds: S };
            wiring.servos.push(take(&mut bytes)?).map_err(|_| full)?;
        }
        if bytes.is_empty() { Ok(wiring) } else { Err(WiringError::Bytes) }
    }

    /// The line of each servo, for [`Lines::new`](crate::Lines::new).
    pub fn line_of(&self) -> impl Iterator<Item = usize> {
        self.servos.iter().map(|servo| servo.line)
    }

    /// What a controller is made of by it.
    ///
    /// # Errors
    /// [`WiringError`] names what cannot be.
    pub fn build(&self) -> Result<Built<L, S>, WiringError> {
        let count = self.lines.len();
        if self.servos.iter().any(|servo| servo.line >= count) {
            return Err(WiringError::Line);
        }
        let latest = self.lines.get(self.latest).ok_or(WiringError::Line)?;
        let mut buses = Vec::<_, L>::new();
        for (index, line) in self.lines.iter().enumerate() {
            let own = self.servos.iter().filter(|servo| servo.line == index);
            let bus = line.bus(own.map(|servo| servo.on_line), self.rate_hz)?;
            // There is as much room.
            let _ = buses.push(bus);
        }
        Ok(Built {
            settings: ControllerSettings { tracker: self.tracker, ..ControllerSettings::default() },
            servos: self.servos.iter().map(|servo| servo.setup).collect(),
            schedule: latest.schedule(self.rate_hz)?,
            buses,
        })
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
