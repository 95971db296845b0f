//! A PCA9685 on I2C.

use embassy_stm32::i2c::{I2c, Master};
use embassy_stm32::mode::Blocking;
use sinew_bus::pca9685::{self, Prescale};

use crate::clock;

/// Its address with no solder bridge closed.
const ADDRESS: u8 = 0x40;

pub(crate) type Bus = I2c<'static, Blocking, Master>;

/// Starts the chip. False: nobody answers.
pub(crate) fn start(i2c: &mut Bus, prescale: &Prescale) -> bool {
    pca9685::start(prescale).iter().all(|transfer| {
        let is_taken = i2c.blocking_write(ADDRESS, transfer.bytes()).is_ok();
        clock::wait_us(transfer.wait_us.into());
        is_taken
    })
}

/// One write. One that is lost is made good by the next that changes its channels; OE and the servos' power are what
/// stops.
pub(crate) fn write(i2c: &mut Bus, bytes: &[u8]) {
    let _ = i2c.blocking_write(ADDRESS, bytes);
}
