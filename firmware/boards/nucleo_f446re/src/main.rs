//! Entry of the image; its code is in `image.rs`. On a host, where only the workspace is checked, `main` does
//! nothing.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod clocks;
#[cfg(target_os = "none")]
mod image;

#[cfg(not(target_os = "none"))]
fn main() {}
