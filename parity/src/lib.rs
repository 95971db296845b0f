//! What exists only to compare machines, bit by bit. It is no part of a product.
//!
//! - [`run`]: a run that any machine can make, and every number that comes of it. The program `parity` makes one, on a
//!   host and as an image for an emulated board;
//! - [`replay`]: a stand-in for servos, so that a board can perform a show without any.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod replay;
pub mod run;
