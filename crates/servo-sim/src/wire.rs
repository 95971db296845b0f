//! What all servos on a wire do alike with bytes.

use sinew_servo_bus::BusDevice;

use crate::device::limits::LONGEST;
use crate::fault::{self, Fault};

/// Bits of a byte on the wire, with start and stop.
const BITS: u64 = 10;
/// After so long a silence, who waits for a silent servo answers. Guess: no maker states it.
pub(crate) const SILENCE_US: u32 = 100;

/// A device that listens at a rate of its own.
pub(crate) trait Listener: BusDevice {
    /// Bits per second.
    fn rate(&self) -> u32;
}

pub(crate) fn took_ns(bytes: usize, baud: u32) -> u64 {
    bytes as u64 * BITS * 1_000_000_000 / u64::from(baud.max(1))
}

/// All but the speaker hear; at another rate nobody understands.
pub(crate) fn hear(devices: &mut [impl Listener], baud: u32, bytes: &[u8], speaker: Option<usize>) {
    for (index, device) in devices.iter_mut().enumerate() {
        if Some(index) != speaker && device.rate() == baud {
            device.hear(bytes);
        }
    }
}

/// Who speaks next, and after how many us of silence.
pub(crate) fn next_speaker(devices: &[impl BusDevice]) -> Option<(usize, u32)> {
    let due = devices.iter().enumerate();
    due.filter_map(|(index, device)| Some((index, device.due_us()?)))
        .min_by_key(|(_, delay_us)| *delay_us)
}

/// What a device says with the faults that servo `place` has now, and how many us it is late by; none if they silence
/// it.
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
