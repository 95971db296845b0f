//! A PCA9685 on I2C.

use embassy_stm32::i2c::{I2c, Master};
use embassy_stm32::mode::Blocking;
use sinew_servo_bus::pca9685::{self, Prescale};

use crate::clock;

/// Its address with no solder bridge closed.
const ADDRESS: u8 = 0x40;

pub(crate) type Bus = I2c<'static, Blocking, Master>;

/// Starts the chip, if it is there: all pulses are off.
#[inline(never)]
pub(crate) fn start(i2c: &mut Bus, prescale: &Prescale) {
    for transfer in pca9685::start(prescale) {
        if i2c.blocking_write(ADDRESS, transfer.bytes()).is_err() {
            return;
        }
        clock::wait_us(transfer.wait_us.into());
    }
}

/// One write. One that is lost is made good by the next that changes its channels; OE and the servos' power are what
/// stops.
pub(crate) fn write(i2c: &mut Bus, bytes: &[u8]) {
    let _ = i2c.blocking_write(ADDRESS, bytes);
}
