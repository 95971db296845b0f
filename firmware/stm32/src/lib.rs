//! What boards with an STM32 have in common: the node of [`sinew_firmware::node`] on the chip's hardware.
//!
//! ```text
//! TIM3, priority 8 ── the loop ── ServoLine (USART1, DMA), PCA9685 (I2C1), OE, e-stop, IWDG
//!      interrupts
//! main ── link, storage ── Serial (USART2, DMA), Chip (flash), the status light (TIM2)
//! both read the clock: TIM5, 32 bits
//! ```
//! A board gives clocks, pins and DMA channels ([`Hardware`]), and calls [`run`]; a NUCLEO gives them as [`Nucleo`].
//! There is no executor: neither control loop nor background task waits for anything, so an interrupt and a loop are
//! all that a node needs.
//!
//! - [`clock`]: microseconds that no erase of flash loses;
//! - [`Serial`]: the line to the host; [`ServoLine`]: the half-duplex line of the servos;
//! - [`Chip`]: flash; [`watchdog`]: the hardware watchdog; [`reset`]: why the chip starts, and the record of a panic;
//! - [`stop`]: what a panic does to servos.
//!
//! For a host this crate is empty.
//!
//! # Files
//! - `node`, `bus`, `capacity`: the node on this hardware; the lines as the loop drives them; the largest rig.
//! - `nucleo`: pins and clocks that all NUCLEO-64 boards share.
//! - `serial`, `servo_line`, `pulses`: the line to the host; the line of the servos; a PCA9685 on I2C.
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
