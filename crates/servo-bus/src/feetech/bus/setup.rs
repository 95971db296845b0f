//! What servos are on the bus, and how they are read.

use crate::feetech::table::Family;
use crate::table::Sign;
use crate::{Cost, Traffic};

/// Position, speed, load, voltage, temperature: 56 to 63.
const BLOCK_LEN: u8 = 8;
/// The same up to the current, 56 to 70: STS measures it.
const STS_BLOCK_LEN: u8 = 15;

/// What a servo is on the bus, and how far it may go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSetup {
    /// Its id.
    pub id: u8,
    /// What it controls; it must be set to this mode before.
    pub mode: Mode,
    /// Least and most own position, rad: within the turn that its encoder has.
    pub range_rad: [f32; 2],
    /// The most PWM, up to 1.
    pub pwm: f32,
    /// Its fastest speed, rad/s: a reading that is further away than that is not believed at once.
    pub speed_rad_s: f32,
}

/// What a servo controls: its operating mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// 0: position within a turn.
    Position,
    /// 2: PWM.
    Pwm,
}

/// How a bus is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// All servos of a bus are of one family: it decides which byte comes first.
    pub family: Family,
    /// Whether the adapter gives back what it sends; an instruction looks like a reply.
    pub echo: bool,
    /// How often servos are asked again in one tick, over all.
    pub retries: u8,
    /// Counts of position a second that one count of speed is: 50 if bit 2 of Phase (18) is 0, else 1.
    pub speed_counts: u8,
}

impl Settings {
    /// One count of speed, rad/s.
    pub(super) fn rad_s_per_count(self) -> f32 {
        f32::from(self.speed_counts) * self.family.rad_per_count()
    }
}

/// The traffic of a bus of so many servos, for a [`Schedule`](crate::Schedule): a goal to each, and what those
/// measure that are read.
///
/// A tick that also switches torque, or writes other goals, is longer by those packets:
/// [`Request::time_us`](crate::Request::time_us) counts them.
pub fn traffic(family: Family, servos: u32) -> Traffic {
    let len = u32::from(family.block_len());
    let sync = family == Family::Sts;
    Traffic {
        servos,
        write: Cost { fixed: 8, each: 3 },
        ask: if sync { Cost { fixed: 8, each: 1 } } else { Cost { fixed: 0, each: 8 } },
        answer: Cost { fixed: 0, each: len.saturating_add(6) },
        delay_each: true,
        ask_each: !sync,
        extra: 0,
    }
}

impl Family {
    pub(super) const fn block_len(self) -> u8 {
        match self {
            Self::Sts => STS_BLOCK_LEN,
            Self::Scs => BLOCK_LEN,
        }
    }

    fn number(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Sts => u16::from_le_bytes(bytes),
            Self::Scs => u16::from_be_bytes(bytes),
        }
    }

    fn bytes(self, number: u16) -> [u8; 2] {
        match self {
            Self::Sts => number.to_le_bytes(),
            Self::Scs => number.to_be_bytes(),
        }
    }

    pub(super) fn signed(self, bytes: [u8; 2], bit: u8) -> i32 {
        Sign::Magnitude(bit).decode(self.number(bytes).into(), 2)
    }

    /// Two bytes of a signed goal; what is too large for them was cut before.
    pub(super) fn goal(self, value: i32, bit: u8) -> [u8; 2] {
        self.bytes(u16::try_from(Sign::Magnitude(bit).encode(value)).unwrap_or(0))
    }
}
