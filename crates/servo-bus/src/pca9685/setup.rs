//! Starts the chip.

use core::fmt;

use super::register::{
    ALL_CHANNELS, AUTO_INCREMENT, MODE1, MODE2, OUTDRV, PERIOD, PRESCALE, RESTART, SLEEP,
};

/// The pulse rate, as a divider of the chip's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prescale {
    divider: u8,
    oscillator_hz: f32,
}

/// The error that no divider gives the requested rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PrescaleError;

impl fmt::Display for PrescaleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "the chip's clock cannot be divided to this rate; 24 to 1526 Hz are possible at 25 MHz",
        )
    }
}

impl core::error::Error for PrescaleError {}

impl Prescale {
    /// Computes the divider for `rate_hz`. The internal clock is 25 MHz by the data sheet, but differs by some per
    /// cent: measure it for each chip, since 3 % of a pulse are 4 degrees.
    ///
    /// # Errors
    /// [`PrescaleError`] if no divider gives the rate.
    ///
    /// ```
    /// use sinew_servo_bus::pca9685::Prescale;
    /// assert_eq!(Prescale::new(25e6, 50.0)?.divider(), 121);
    /// # Ok::<(), sinew_servo_bus::pca9685::PrescaleError>(())
    /// ```
    pub fn new(oscillator_hz: f32, rate_hz: f32) -> Result<Self, PrescaleError> {
        let divider = oscillator_hz / (f32::from(PERIOD) * rate_hz) - 1.0;
        if !(rate_hz > 0.0
            && oscillator_hz > 0.0
            && oscillator_hz.is_finite()
            && (2.5..255.5).contains(&divider))
        {
            return Err(PrescaleError);
        }
        let divider =
            u8::try_from(crate::counts::round(divider, [3, 255])).map_err(|_| PrescaleError)?;
        Ok(Self { divider, oscillator_hz })
    }

    /// Returns the value of the divider register.
    pub const fn divider(&self) -> u8 {
        self.divider
    }

    /// Returns the length of one count of a pulse, us.
    pub fn step_us(&self) -> f32 {
        (f32::from(self.divider) + 1.0) * 1e6 / self.oscillator_hz
    }

    /// Returns the pulse rate, Hz.
    pub fn rate_hz(&self) -> f32 {
        1e6 / (self.step_us() * f32::from(PERIOD))
    }
}

/// One I2C write, and the wait after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transfer {
    bytes: [u8; 5],
    len: usize,
    /// Minimum wait before the next write, us.
    pub wait_us: u32,
}

impl Transfer {
    const fn register(register: u8, value: u8, wait_us: u32) -> Self {
        Self { bytes: [register, value, 0, 0, 0], len: 2, wait_us }
    }

    /// Returns the bytes to write.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }
}

/// Returns the writes that start the chip: sleep, all channels off, clock, outputs, wake up. The chip then no longer
/// answers to the common address of all chips.
pub const fn start(prescale: &Prescale) -> [Transfer; 6] {
    [
        Transfer::register(MODE1, AUTO_INCREMENT | SLEEP, 0),
        all_off(),
        Transfer::register(PRESCALE, prescale.divider, 0),
        Transfer::register(MODE2, OUTDRV, 0),
        // The oscillator takes up to 500 us to start.
        Transfer::register(MODE1, AUTO_INCREMENT, 500),
        Transfer::register(MODE1, AUTO_INCREMENT | RESTART, 0),
    ]
}

/// Returns the write that stops all pulses at once. Servos may react to missing pulses in different ways, so a stop
/// must also cut their supply.
pub const fn all_off() -> Transfer {
    let [a, b, c, d] = super::register::OFF;
    Transfer { bytes: [ALL_CHANNELS, a, b, c, d], len: 5, wait_us: 0 }
}
