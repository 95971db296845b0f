//! Computes the capacity of a line at compile time; tests compare the results with encoded frames.
//!
//! ```
//! use sinew_link::message::TelemetryParts;
//! use sinew_link::rate::{RigSize, telemetry_hz};
//!
//! // The whole telemetry of a rig of 20 servos, over the serial port of a debugger.
//! const OP3: RigSize = RigSize { coordinates: 20, dofs: 20, servos: 20 };
//! const RATE_HZ: u32 = telemetry_hz(115_200, OP3, TelemetryParts::ALL);
//! assert_eq!(RATE_HZ, 18);
//! ```

pub use crate::frame::frame_len;
use crate::message::{
    DOFS_A_FRAME, POSE_MAX, SERVOS_A_FRAME, SUPPLIES_A_FRAME, TARGETS_A_FRAME, TelemetryParts,
};

/// Bits per byte on a serial line: start bit, eight data bits, stop bit.
const BITS_A_BYTE: u32 = 10;

/// Length of direction, kind of message, number and tick of a telemetry frame, and the kind of its part, in bytes.
const HEAD: usize = 11;
/// Length of first index and count of a list, in bytes.
const LIST: usize = 2;
/// Maximum length of a summary, in bytes.
const SUMMARY: usize = 60;
const NUMBER: usize = 4;
const DOF: usize = 6;
const SERVO: usize = 7;
const TARGET: usize = 3;
const SUPPLY: usize = 1;

/// Size of a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RigSize {
    /// Number of coordinates of its pose.
    pub coordinates: usize,
    /// Number of dofs.
    pub dofs: usize,
    /// Number of servos.
    pub servos: usize,
}

/// Returns how many frames per second with bodies of this length a serial line carries.
pub const fn frames_per_second(bits_per_second: u32, body_len: usize) -> u32 {
    per_second(bits_per_second / BITS_A_BYTE, frame_len(body_len))
}

/// Returns how many snapshots per second of these parts a serial line carries, if telemetry gets three quarters of
/// the line. The rest is for answers, faults and servo bytes.
pub const fn telemetry_hz(bits_per_second: u32, size: RigSize, parts: TelemetryParts) -> u32 {
    let bytes_per_second = bits_per_second / BITS_A_BYTE;
    let share = bytes_per_second.saturating_sub(bytes_per_second.div_ceil(4));
    per_second(share, snapshot_len(size, parts))
}

/// Returns the maximum length of a snapshot of these parts, in bytes: all its frames with their zeros.
pub const fn snapshot_len(size: RigSize, parts: TelemetryParts) -> usize {
    let summary = if parts.has(TelemetryParts::SUMMARY) {
        frame_len(HEAD.saturating_add(SUMMARY))
    } else {
        0
    };
    summary
        .saturating_add(list_len(
            parts.has(TelemetryParts::POSE),
            size.coordinates,
            POSE_MAX,
            NUMBER,
        ))
        .saturating_add(list_len(parts.has(TelemetryParts::DOFS), size.dofs, DOFS_A_FRAME, DOF))
        .saturating_add(list_len(
            parts.has(TelemetryParts::SERVOS),
            size.servos,
            SERVOS_A_FRAME,
            SERVO,
        ))
        .saturating_add(list_len(
            parts.has(TelemetryParts::TARGETS),
            size.dofs,
            TARGETS_A_FRAME,
            TARGET,
        ))
        .saturating_add(list_len(
            parts.has(TelemetryParts::SUPPLIES),
            size.servos,
            SUPPLIES_A_FRAME,
            SUPPLY,
        ))
}

const fn list_len(wanted: bool, items: usize, a_frame: usize, item_len: usize) -> usize {
    if !wanted {
        return 0;
    }
    let mut left = items;
    let mut sum = 0_usize;
    while left > 0 {
        let here = if left < a_frame { left } else { a_frame };
        let body = here.saturating_mul(item_len).saturating_add(HEAD).saturating_add(LIST);
        sum = sum.saturating_add(frame_len(body));
        left = left.saturating_sub(here);
    }
    sum
}

/// Returns how often `len` bytes fit in a second.
const fn per_second(bytes_per_second: u32, len: usize) -> u32 {
    let len = if len < 1 << 31 { len } else { 1 << 31 };
    #[expect(clippy::cast_possible_truncation, reason = "it is at most 2^31")]
    match bytes_per_second.checked_div(len as u32) {
        Some(times) => times,
        None => 0,
    }
}
