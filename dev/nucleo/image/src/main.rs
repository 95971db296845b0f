//! The peripherals that our image for the NUCLEO uses, each tried by itself: see `chip.rs`. On a host, where the
//! workspace is checked, there is nothing to run.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;

#[cfg(not(target_os = "none"))]
fn main() {}
