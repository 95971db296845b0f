//! Tests the peripherals that our image for the NUCLEO uses, each separately: see `chip.rs`. On a host, where the
//! workspace is checked, there is nothing to run.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;
// The clocks of the board's own image.
#[cfg(target_os = "none")]
#[path = "../../../../firmware/boards/nucleo_f446re/src/clocks.rs"]
mod clocks;

#[cfg(not(target_os = "none"))]
fn main() {}
