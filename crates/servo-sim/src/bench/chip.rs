//! A PCA9685 between a master and hobby servos.

use sinew_servo_bus::pca9685::{Device, Prescale, start};

/// Internal clock of the chip by its data sheet, Hz.
pub const OSCILLATOR_HZ: f32 = 25e6;

/// A simulated chip, with the channels of its servos.
#[derive(Debug, Clone)]
pub struct Chip {
    device: Device,
    /// Channel of each servo of the line.
    channels: Vec<usize>,
    /// Whether the pin OE is low. If it is high, all outputs are off.
    is_oe_low: bool,
}

impl Chip {
    /// Creates a chip that was just switched on, with its pin OE pulled high. `channels` are the channels of the line's
    /// servos.
    pub fn new(channels: Vec<usize>) -> Self {
        Self { device: Device::new(OSCILLATOR_HZ), channels, is_oe_low: false }
    }

    /// Starts the chip as a board does when it starts: all channels off, then the chip's clock.
    pub(super) fn start(&mut self, prescale: Prescale) {
        for transfer in start(&prescale) {
            self.device.write(transfer.bytes());
        }
    }

    /// Executes one I2C write.
    pub(super) fn write(&mut self, bytes: &[u8]) {
        self.device.write(bytes);
    }

    /// Drives the pin OE: low if `on`.
    pub(super) fn enable(&mut self, on: bool) {
        self.is_oe_low = on;
    }

    /// Returns the pulse of a servo of the line, us, or `None` if it receives no pulse.
    pub(super) fn pulse_us(&self, servo: usize) -> Option<f64> {
        let pulse_us = self.device.pulse_us(*self.channels.get(servo)?)?;
        self.is_oe_low.then_some(pulse_us.into())
    }
}

/// Returns the time of a write of `bytes` bytes, ns: 9 bits for each byte and for the address, plus start and stop.
pub(super) fn took_ns(bytes: usize, i2c_hz: u32) -> u64 {
    ((bytes as u64 + 1) * 9 + 2) * 1_000_000_000 / u64::from(i2c_hz.max(1))
}
