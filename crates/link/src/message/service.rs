//! Service of a rig in the state limp: packets to its servos, and the controller's measurements.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::finite;

/// Maximum number of bytes for servos in a command, and from servos in an answer.
pub const PASS_MAX: usize = 128;

/// Maximum number of servo bytes that a controller keeps from one exchange.
pub const PASSED_MAX: usize = 512;

/// Maximum wait for servos, and maximum time to send bytes to them, us. The loop stops for both, and its watchdog
/// must allow for that.
pub const PASS_WAIT_US: u32 = 20_000;

/// Minimum baud rate of a line, bit/s: no servo has a lower rate.
pub const PASS_LEAST_BAUD: u32 = 9_600;

/// Bytes for the servos of a line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pass {
    /// Index of the line; 0 is the first.
    pub line: u8,
    /// Bits per second; 0 for the line's own rate.
    pub baud: u32,
    /// Time to listen after the last sent byte, us, at most [`PASS_WAIT_US`].
    pub wait_us: u32,
    /// Bytes to send.
    pub bytes: Vec<u8, PASS_MAX>,
}

impl Pass {
    /// Returns the time to send the bytes at a baud rate, us, with ten bits per byte. The result is `None` if the
    /// loop would stop for too long, or the rate is too low for any servo.
    pub fn sending_us(&self, baud: u32) -> Option<u32> {
        if baud < PASS_LEAST_BAUD {
            return None;
        }
        let bits = u64::try_from(self.bytes.len()).ok()?.saturating_mul(10);
        let us = bits.saturating_mul(1_000_000).div_ceil(baud.into());
        u32::try_from(us).ok().filter(|us| *us <= PASS_WAIT_US)
    }
}

/// Bytes that the servos sent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Passed {
    /// Number of received bytes, at most [`PASSED_MAX`]; later bytes are lost.
    pub count: u16,
    /// Time from the first sent to the last received byte, us; 0 if none was received.
    pub took_us: u32,
    /// Bytes from the requested offset on.
    pub bytes: Vec<u8, PASS_MAX>,
}

/// Processor cycles of a repeated piece of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Cycles {
    /// Minimum number of cycles.
    pub least: u32,
    /// Mean number of cycles.
    pub mean: u32,
    /// Maximum number of cycles.
    pub most: u32,
    /// Number of repetitions.
    pub count: u32,
}

/// The controller's measurements of itself: cycles since they were last read, the supply since its start.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Health {
    /// Cycles per second; 0 if the controller does not count them.
    pub cycles_hz: u32,
    /// Cycles of a tick of the loop.
    pub tick: Cycles,
    /// Cycles of the exchange with the servos.
    pub bus: Cycles,
    /// Cycles of a step of link and storage.
    pub link: Cycles,
    /// Cycles between the starts of two ticks. The jitter is the maximum minus the minimum.
    pub period: Cycles,
    /// Minimum supply voltage that a servo reported while torque was on, V; 0 if none was measured.
    #[serde(with = "finite")]
    pub supply_least_v: f32,
}
