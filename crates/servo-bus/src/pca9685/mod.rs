//! Hobby servos on a PCA9685, a chip that makes 16 pulses from I2C writes.
//!
//! The functions of this module return the bytes of one I2C write each, without the chip's address. Outputs change when
//! the write stops (OCH 0), so a write of several channels changes them all at once. Pulling the pin OE high makes all
//! outputs low, whatever the registers contain (OUTNE 00). Connect OE to a pull-up and to a pin of the controller, to
//! have a switch that does not depend on I2C.
//!
//! Source: NXP, PCA9685 product data sheet, rev. 4.

mod bus;
mod device;
mod register;
mod setup;

pub use bus::{Bus, ChannelSetup};
pub use device::Device;
pub use setup::{Prescale, PrescaleError, Transfer, all_off, start};
