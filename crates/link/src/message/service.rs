//! What one does with a rig that is limp: packets to its servos, and what the controller has measured.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::finite;

/// The most bytes for servos in a command, and of servos in an answer.
pub const PASS_MAX: usize = 128;

/// The most bytes of servos that a controller keeps of one exchange.
pub const PASSED_MAX: usize = 512;

/// The longest wait for servos, and the longest time that bytes for them may take, us: the loop stands still for both,
/// and its watchdog must bear that.
pub const PASS_WAIT_US: u32 = 20_000;

/// The lowest rate of a line, bit/s: no servo has a lower one.
pub const PASS_LEAST_BAUD: u32 = 9_600;

/// Bytes for the servos of a line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pass {
    /// Which line; 0 is the first.
    pub line: u8,
    /// Bits per second; 0 for those of the line.
    pub baud: u32,
    /// For how long to listen since the last byte out, us, at most [`PASS_WAIT_US`].
    pub wait_us: u32,
    /// They.
    pub bytes: Vec<u8, PASS_MAX>,
}

impl Pass {
    /// How long its bytes take at so many bits a second, us, ten bits each; none if the loop would stand still for too
    /// long, or no servo is so slow.
    pub fn sending_us(&self, baud: u32) -> Option<u32> {
        if baud < PASS_LEAST_BAUD {
            return None;
        }
        let bits = u64::try_from(self.bytes.len()).ok()?.saturating_mul(10);
        let us = bits.saturating_mul(1_000_000).div_ceil(baud.into());
        u32::try_from(us).ok().filter(|us| *us <= PASS_WAIT_US)
    }
}

/// What servos have said.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Passed {
    /// How many bytes came in all, at most [`PASSED_MAX`]; what came behind those is lost.
    pub count: u16,
    /// From the first byte out to the last that came, us; 0 if none came.
    pub took_us: u32,
    /// The bytes from the offset on that was asked for.
    pub bytes: Vec<u8, PASS_MAX>,
}

/// Cycles of the processor that something took which comes again and again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Cycles {
    /// The fewest.
    pub least: u32,
    /// On average.
    pub mean: u32,
    /// The most.
    pub most: u32,
    /// How often it came.
    pub count: u32,
}

/// What a controller has measured of itself: cycles since they were read last, the supply since its start.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Health {
    /// Cycles in a second; 0 if the controller does not count them.
    pub cycles_hz: u32,
    /// A tick of the loop.
    pub tick: Cycles,
    /// Its exchange with the servos.
    pub bus: Cycles,
    /// A step of link and storage.
    pub link: Cycles,
    /// From one tick to the next. Its jitter is the most without the least.
    pub period: Cycles,
    /// The lowest supply that a servo told while torque was on, V; 0 if none was measured.
    #[serde(with = "finite")]
    pub supply_least_v: f32,
}
