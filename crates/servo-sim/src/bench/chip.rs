//! A PCA9685 between a master and hobby servos.

use sinew_servo_bus::pca9685::{Device, Prescale, start};

/// Its inner clock by the data sheet, Hz.
pub const OSCILLATOR_HZ: f32 = 25e6;

/// A simulated chip, and which servo hangs on which of its channels.
#[derive(Debug, Clone)]
pub struct Chip {
    device: Device,
    /// By servo of its line.
    channels: Vec<usize>,
    /// The pin OE; high is off.
    is_oe_low: bool,
}

impl Chip {
    /// A chip that was just switched on, its pin OE pulled high. `channels`: of each servo of its line.
    pub fn new(channels: Vec<usize>) -> Self {
        Self { device: Device::new(OSCILLATOR_HZ), channels, is_oe_low: false }
    }

    /// What a board does at each of its starts: all channels off, then the chip's clock.
    pub(super) fn start(&mut self, prescale: Prescale) {
        for transfer in start(&prescale) {
            self.device.write(transfer.bytes());
        }
    }

    /// One I2C write.
    pub(super) fn write(&mut self, bytes: &[u8]) {
        self.device.write(bytes);
    }

    /// Drives the pin OE: low if `on`.
    pub(super) fn enable(&mut self, on: bool) {
        self.is_oe_low = on;
    }

    /// The pulse of a servo of its line, us; none if it gets none.
    pub(super) fn pulse_us(&self, servo: usize) -> Option<f64> {
        let pulse_us = self.device.pulse_us(*self.channels.get(servo)?)?;
        self.is_oe_low.then_some(pulse_us.into())
    }
}

/// How long a write of so many bytes takes, ns: 9 bits for each and for the address, start and stop.
pub(super) fn took_ns(bytes: usize, i2c_hz: u32) -> u64 {
    ((bytes as u64 + 1) * 9 + 2) * 1_000_000_000 / u64::from(i2c_hz.max(1))
}
