//! The hardware-free part of the firmware: it builds, runs and is tested on the host, and the host's
//! simulator uses the same code.
//!
//! - [`drives`]: from what a tracker asks of joints to what servos are commanded, and back;
//! - [`supervisor`]: may anything move, how fast, and what happens on a fault;
//! - [`controller`]: the loop that joins all of it, one tick a call;
//! - [`node`]: the whole of a board: the loop above, link and storage below it;
//! - [`watchdog`]: the hardware watchdog, which a whole tick alone feeds;
//! - [`indicator`]: the status light.
//!
//! # Features
//! - `defmt`: `defmt::Format` for all public types, here and in the core.
//!
//! There is no `serde` here: what is stored has formats of its own ([`sinew_rig::board`], [`sinew_show`],
//! [`sinew_storage`]), and all else is running state or an error. Settings are the core's, which has that feature.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod controller;
pub mod drives;
pub mod indicator;
pub mod node;
mod setting;
pub mod supervisor;
pub mod watchdog;

pub use setting::SettingError;
