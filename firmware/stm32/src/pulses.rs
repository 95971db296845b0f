//! A PCA9685 on I2C.

use embassy_stm32::i2c::{I2c, Master};
use embassy_stm32::mode::Blocking;
use sinew_servo_bus::pca9685::{self, Prescale};

use crate::clock;

/// Address of the chip when no solder bridge is closed.
const ADDRESS: u8 = 0x40;

pub(crate) type Bus = I2c<'static, Blocking, Master>;

/// Starts the chip, with all pulses off. Does nothing if the chip does not answer.
#[inline(never)]
pub(crate) fn start(i2c: &mut Bus, prescale: &Prescale) {
    for transfer in pca9685::start(prescale) {
        if i2c.blocking_write(ADDRESS, transfer.bytes()).is_err() {
            return;
        }
        clock::wait_us(transfer.wait_us.into());
    }
}

/// Writes to the chip. A lost write is repaired by the next one that changes its channels; for a stop, OE and the
/// servos' power supply are used instead.
pub(crate) fn write(i2c: &mut Bus, bytes: &[u8]) {
    let _ = i2c.blocking_write(ADDRESS, bytes);
}
