//! Describes the servos of a bus, and how the bus reads them.

use crate::feetech::table::Family;
use crate::table::Sign;
use crate::{Cost, Traffic};

/// Length of a reading: position, speed, load, voltage, temperature; addresses 56 to 63.
const BLOCK_LEN: u8 = 8;
/// Length of a reading up to the current, addresses 56 to 70: STS servos measure current.
const STS_BLOCK_LEN: u8 = 15;

/// Setup of a servo on the bus: its id and its limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoSetup {
    /// Id of the servo.
    pub id: u8,
    /// Operating mode. The servo's register must already hold it.
    pub mode: Mode,
    /// Minimum and maximum position, rad, within the one turn of its encoder, zero where the encoder counts zero.
    pub range_rad: [f32; 2],
    /// Maximum PWM, as a fraction of full PWM, up to 1.
    pub pwm: f32,
    /// Maximum speed, rad/s. A reading that would need a higher speed is not believed at once.
    pub speed_rad_s: f32,
}

/// Operating mode: the quantity that a servo controls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Mode 0: position within one turn.
    Position,
    /// Mode 2: PWM, without position control.
    Pwm,
}

/// Settings for the reads of a bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Family of all servos on this bus: it decides the byte order.
    pub family: Family,
    /// Whether the adapter echoes all bytes that it sends. The bus must skip the echo, because an instruction looks
    /// like a reply.
    pub echo: bool,
    /// Maximum number of repeated questions in one tick, for all servos together.
    pub retries: u8,
    /// Speed of one count of the speed register, in counts of position per second: 50 if bit 2 of Phase (18) is 0,
    /// otherwise 1.
    pub speed_counts: u8,
}

impl Settings {
    /// Returns the speed of one count, rad/s.
    pub(super) fn rad_s_per_count(self) -> f32 {
        f32::from(self.speed_counts) * self.family.rad_per_count()
    }
}

/// Returns the traffic of a bus with `servos` servos, for a [`Schedule`](crate::Schedule): a goal for each servo, and
/// the readings of the servos that are read.
///
/// A tick that also switches torque or writes other goals takes longer: [`Request::time_us`](crate::Request::time_us)
/// includes those packets.
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

    /// Returns the two bytes of a signed goal. The caller has limited the value to the register's range.
    pub(super) fn goal(self, value: i32, bit: u8) -> [u8; 2] {
        self.bytes(u16::try_from(Sign::Magnitude(bit).encode(value)).unwrap_or(0))
    }
}
