//! A simulated PCA9685.

use super::register::{
    ALL_CALL, ALL_CHANNELS, ALL_CHANNELS_LAST, AUTO_INCREMENT, CHANNEL_0, CHANNELS, FULL, MODE1,
    OFF, PERIOD, PRESCALE, RESTART, SLEEP, channel,
};

/// A simulated chip. Each call of [`write`](Self::write) is one I2C write, from start to stop.
#[derive(Debug, Clone)]
pub struct Device {
    registers: [u8; 256],
    pointer: u8,
    oscillator_hz: f32,
}

impl Device {
    /// Creates a chip that was just switched on, with this clock rate.
    pub fn new(oscillator_hz: f32) -> Self {
        let mut device = Self { registers: [0; 256], pointer: 0, oscillator_hz };
        device.set(MODE1, SLEEP | ALL_CALL);
        device.set(0x01, 1 << 2);
        for (register, value) in
            [(0x02, 0xE2), (0x03, 0xE4), (0x04, 0xE8), (0x05, 0xE0), (PRESCALE, 0x1E)]
        {
            device.set(register, value);
        }
        for index in 0..CHANNELS {
            device.set_channel(channel(index), OFF);
        }
        device
    }

    /// Executes one I2C write: the first byte is the register; the others are values for it and, with auto-increment,
    /// for the registers that follow.
    pub fn write(&mut self, bytes: &[u8]) {
        let Some((register, values)) = bytes.split_first() else { return };
        self.pointer = *register;
        for value in values {
            self.put(self.pointer, *value);
            self.advance();
        }
    }

    /// Executes one I2C read, from the register that the last write pointed to.
    pub fn read(&mut self, out: &mut [u8]) {
        for byte in out {
            *byte = self.get(self.pointer);
            self.advance();
        }
    }

    /// Returns the pulse length of a channel, us, or `None` if the channel gives no pulse or the chip sleeps.
    pub fn pulse_us(&self, index: usize) -> Option<f32> {
        if index >= CHANNELS || self.get(MODE1) & SLEEP != 0 {
            return None;
        }
        let at = channel(index);
        let word = |offset: u8| {
            let at = at.saturating_add(offset);
            u16::from_le_bytes([self.get(at), self.get(at.saturating_add(1)) & 0x1F])
        };
        let (on, off) = (word(0), word(2));
        let full = u16::from(FULL) << 8;
        if off & full != 0 || (on & full == 0 && on == off) {
            return None;
        }
        let counts = if on & full == 0 { off.wrapping_sub(on) % PERIOD } else { PERIOD };
        Some(f32::from(counts) * (f32::from(self.get(PRESCALE)) + 1.0) * 1e6 / self.oscillator_hz)
    }

    fn put(&mut self, register: u8, value: u8) {
        match register {
            // Writing 1 to RESTART clears it.
            MODE1 => self.set(MODE1, value & !RESTART),
            PRESCALE if self.get(MODE1) & SLEEP == 0 => {}
            PRESCALE => self.set(PRESCALE, value.max(3)),
            ALL_CHANNELS..=ALL_CHANNELS_LAST => {
                for index in 0..CHANNELS {
                    self.set(
                        channel(index).saturating_add(register.saturating_sub(ALL_CHANNELS)),
                        value,
                    );
                }
            }
            _ => self.set(register, value),
        }
    }

    fn advance(&mut self) {
        if self.get(MODE1) & AUTO_INCREMENT != 0 {
            // After the last channel, the pointer continues at the first register.
            let last = CHANNEL_0.saturating_add(63);
            self.pointer = if self.pointer == last || self.pointer == PRESCALE {
                0
            } else {
                self.pointer.wrapping_add(1)
            };
        }
    }

    fn set_channel(&mut self, at: u8, bytes: [u8; 4]) {
        for (register, byte) in (at..).zip(bytes) {
            self.set(register, byte);
        }
    }

    fn get(&self, register: u8) -> u8 {
        self.registers.get(usize::from(register)).copied().unwrap_or(0)
    }

    fn set(&mut self, register: u8, value: u8) {
        if let Some(slot) = self.registers.get_mut(usize::from(register)) {
            *slot = value;
        }
    }
}
