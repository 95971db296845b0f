//! Functions that all simulated servos on a wire share.

use sinew_servo_bus::BusDevice;

use crate::device::limits::LONGEST;
use crate::fault::{self, Fault};

/// Bits of a byte on the wire, with start and stop bit.
const BITS: u64 = 10;
/// Silence, us, after which a servo no longer waits for a silent servo but answers. This is a guess, because no maker
/// states it.
pub(crate) const SILENCE_US: u32 = 100;

/// A device that listens at its own baud rate.
pub(crate) trait Listener: BusDevice {
    /// Returns the baud rate, bits per second.
    fn rate(&self) -> u32;
}

pub(crate) fn took_ns(bytes: usize, baud: u32) -> u64 {
    bytes as u64 * BITS * 1_000_000_000 / u64::from(baud.max(1))
}

/// Passes bytes to all devices except the speaker. Devices at another rate do not understand them.
pub(crate) fn hear(devices: &mut [impl Listener], baud: u32, bytes: &[u8], speaker: Option<usize>) {
    for (index, device) in devices.iter_mut().enumerate() {
        if Some(index) != speaker && device.rate() == baud {
            device.hear(bytes);
        }
    }
}

/// Returns the device that sends next, and the silence before its first byte, us; `None` if no device has bytes to
/// send.
pub(crate) fn next_speaker(devices: &[impl BusDevice]) -> Option<(usize, u32)> {
    let due = devices.iter().enumerate();
    due.filter_map(|(index, device)| Some((index, device.due_us()?)))
        .min_by_key(|(_, delay_us)| *delay_us)
}

/// Returns the bytes that a device sends, changed by the present faults of servo `place`, and their additional delay,
/// us; `None` if a fault silences the device.
pub(crate) fn speak(
    device: &mut impl BusDevice,
    place: usize,
    faults: &[Fault],
    time_s: f64,
) -> Option<(Vec<u8>, u32)> {
    let mut said = vec![0; LONGEST];
    let len = device.speak(&mut said);
    said.truncate(len);
    let now = faults.iter().filter(|fault| fault.servo == place && fault.is_on(time_s));
    let late_us = fault::damage(now.map(|fault| fault.kind), &mut said)?;
    Some((said, late_us))
}
