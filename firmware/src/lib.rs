//! The hardware-free part of the firmware. It builds, runs and is tested on the host, and the host's simulator uses
//! the same code.
//!
//! - [`drives`]: convert the tracker's commands for joints to servo commands, and readings back;
//! - [`supervisor`]: decides whether anything may move, how fast, and how faults are handled;
//! - [`controller`]: the control loop, which joins all parts, one tick per call;
//! - [`node`]: a complete board: the control loop, and the background task with host link and storage;
//! - [`watchdog`]: the hardware watchdog, which only a complete tick feeds;
//! - [`indicator`]: the status light.
//!
//! # Features
//! - `defmt`: `defmt::Format` for all public types, here and in the core.
//!
//! There is no `serde` feature: stored data has its own formats ([`sinew_rig::board`], [`sinew_show`],
//! [`sinew_storage`]), and everything else is running state or an error. Settings are the core's, which has that
//! feature.
//!
//! # Files
//! - `drives/`: `rig` contains the drives of a rig. Each servo has a class (`current`, `voltage`, `position`,
//!   `target`); a `follower` keeps the limits of positions. `measured` converts readings back to joints.
//! - `supervisor/`: `state` and `transition` (a pure step from mode to mode), `supervisor` (its clocks),
//!   `permission`; `fault/table` contains the reaction to each fault in each state; `detect/` finds faults; `guard/`
//!   is the last check before the bus.
//! - `controller/`: `controller` is the tick. It joins `watch` (all detectors), `feed` (show, live, jog, hold, rest),
//!   `path` (blends, range, speed, acceleration), `performance` (tracker and drives) and `output` (guard, bus).
//!   `belief` refuses readings that a servo cannot have turned to. `registers` compares the servos' settings before
//!   they are armed; `wire` is the board's part of a tick.
//! - `node/`: `control` is the control loop, `background_task` serves host link and storage, `mail` connects them,
//!   `pending` contains commands in progress. `start` reads flash at power-on; `settings` has a key for each number;
//!   `board` is the interface to the hardware.

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
