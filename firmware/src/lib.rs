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
//!
//! # Files
//! - `drives/`: `rig` holds the drives of a rig. Each servo has a class (`current`, `position`, `target`) over a
//!   `follower`, which keeps its limits. `measured` is the way back.
//! - `supervisor/`: `state` and `transition` (a pure step from mode to mode), `supervisor` (its clocks), `permission`;
//!   `fault/table` has the reaction to each fault in each state; `detect/` finds faults; `guard/` is the last check
//!   before the bus.
//! - `controller/`: `controller` is the tick. It joins `watch` (all detectors), `feed` (show, live, jog, hold, rest),
//!   `path` (blends, range, speed, acceleration), `performance` (tracker and drives) and `output` (guard, bus).
//!   `registers` compares what servos hold before they are armed; `wire` is the board's part of a tick.
//! - `node/`: `control` is the control loop, `background_task` serves host link and storage, `mail` is between them,
//!   `pending` has work under way.
//!   `start` reads flash at power-on; `settings` has a key for each number; `board` is what hardware provides.

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
