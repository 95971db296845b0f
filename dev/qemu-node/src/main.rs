//! The node as an image for QEMU's `mps2-an386`. On a host, where the workspace is checked, there is nothing to run.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "../../bit-parity/src/files.rs"]
mod files;
#[cfg(target_os = "none")]
mod image;
#[cfg(target_os = "none")]
mod persistent_ram;

#[cfg(not(target_os = "none"))]
fn main() {}
