//! Shared by all boards with an STM32: the node of [`sinew_firmware::node`] on the chip's hardware.
//!
//! ```text
//! TIM3, priority 8 ── the loop ── ServoLine (USART1, DMA), PCA9685 (I2C1), OE, e-stop, IWDG
//!      interrupts
//! main ── link, storage ── Serial (USART2, DMA), Chip (flash), the status light (TIM2)
//! both read the clock: TIM5, 32 bits
//! ```
//! A board provides clocks, pins and DMA channels ([`Hardware`]), and calls [`run`]; a NUCLEO provides them as
//! [`Nucleo`]. There is no executor: neither control loop nor background task waits for anything, so a node needs
//! only an interrupt and a loop.
//!
//! - [`clock`]: a clock in microseconds that loses no time during an erase of flash;
//! - [`Serial`]: the host link; [`ServoLine`]: the servos' half-duplex bus line;
//! - [`Chip`]: flash; [`watchdog`]: the hardware watchdog; [`reset`]: the causes of a reset, and the record of a
//!   panic;
//! - [`stop`]: the handler of a panic, which first makes the servos safe.
//!
//! On a host this crate is empty.
//!
//! # Files
//! - `node`, `bus`, `capacity`: the node on this hardware; the bus lines as the control loop uses them; the largest
//!   rig.
//! - `nucleo`: pins and clocks that all NUCLEO-64 boards share.
//! - `serial`, `servo_line`, `pulses`: the host link; the servos' bus line; a PCA9685 on I2C.
//! - `clock`, `flash`, `light`, `registers`, `reset`, `stop`, `watchdog`: one file for each part of the chip.

#![cfg(target_os = "none")]
#![no_std]
#![deny(missing_docs)]
#![expect(
    unsafe_code,
    reason = "registers, memory that DMA writes, and flash that is read in place"
)]

mod bus;
mod capacity;
pub mod clock;
mod flash;
mod light;
mod node;
mod nucleo;
mod pulses;
mod registers;
pub mod reset;
mod serial;
mod servo_line;
pub mod stop;
pub mod watchdog;

pub use capacity::{BODIES, CAPACITY, COORDINATES, DOFS, LINES, SERVOS};
pub use flash::Chip;
pub use light::Light;
pub use node::{Hardware, run};
pub use nucleo::Nucleo;
pub use serial::{Dma, Serial};
pub use servo_line::ServoLine;
