//! Hobby servos, which are driven by pulses of a PCA9685.

use sinew_rig::servo::Address;
use sinew_servo_bus::pca9685::{ChannelSetup, Prescale};
use sinew_servo_bus::{Cost, Timing, Traffic};
use sinew_servo_sim::bench::{Chip, OSCILLATOR_HZ};
use sinew_wiring::Pulses;

use super::servo_part::{ServoPart, single};

/// Rate of the I2C bus to the chip, bit/s: its fast mode.
pub(super) const I2C_HZ: u32 = 400_000;
/// Pulses for analog servos: 50 per second.
pub(super) const PULSES: Pulses = Pulses { oscillator_hz: OSCILLATOR_HZ, rate_hz: 50.0 };
/// Bytes before the channels of a write: the chip's address, and the first register.
const HEAD_LEN: u32 = 2;
const CHANNEL_LEN: u32 = 4;

/// Returns the channel of a servo that is driven by pulses; `None` for other servos.
pub(super) fn channel(address: Address) -> Option<u8> {
    match address {
        Address::Channel(channel) => Some(channel),
        Address::Id(_) => None,
    }
}

/// Timing of the line: servos send no answer, so there is no wait.
pub(super) const TIMING: Timing = Timing { baud: I2C_HZ, return_delay_us: 0, turnaround_us: 0 };

/// Returns the I2C traffic of a tick: one write from the first channel to the last.
pub(super) fn traffic(servos: &[&ServoPart]) -> Traffic {
    let channels = || servos.iter().filter_map(|servo| channel(servo.own.address));
    let written = match (channels().min(), channels().max()) {
        (Some(first), Some(last)) => u32::from(last - first) + 1,
        _ => 0,
    };
    Traffic {
        servos: u32::try_from(servos.len()).unwrap_or(u32::MAX),
        write: Cost { fixed: HEAD_LEN + CHANNEL_LEN * written, each: 0 },
        ask: Cost::default(),
        answer: Cost::default(),
        delay_each: false,
        ask_each: false,
        extra: 0,
    }
}

/// Returns the setup of a servo's channel: its range, and the pulses at both ends of the range.
pub(super) fn setup(part: &ServoPart, range_rad: [f32; 2]) -> ChannelSetup {
    let channel = channel(part.own.address).unwrap_or_default();
    ChannelSetup { channel, pulse_us: range_rad.map(|rad| pulse_us(part, rad)), range_rad }
}

/// Returns the pulse for a servo's own position, us.
pub(super) fn pulse_us(part: &ServoPart, rad: f32) -> f32 {
    single(part.own.kind.pulses.pulse_us(rad.into()))
}

/// Returns the divider of the chip's clock.
pub(super) fn prescale() -> Prescale {
    PULSES.prescale().expect("the chip makes 50 pulses a second")
}

/// Returns the chip for a line's servos, in its state after power-on.
pub(super) fn chip(servos: &[&ServoPart]) -> Chip {
    let channels = servos.iter().filter_map(|servo| channel(servo.own.address));
    Chip::new(channels.map(usize::from).collect())
}
