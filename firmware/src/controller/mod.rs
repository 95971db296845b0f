//! The loop: what joins frames, tracker, drives, supervisor and guard to a bus of servos, one tick a call.
//!
//! ```text
//!             ┌───────────────────────────── begin ──────────────────────────────┐
//! readings ─> Watch ─> Findings ─> Supervisor ─> Permission                      │
//! commands ─────────────────────────┘               │                            │
//! show, live, jog, hold, rest ─> Path (blend, speed) ─> Tracker ─> Drives ─> Guard ─> ServoBus
//!             └──────────────────────────────────────────────────────────────────┘     │
//!  Complete (feeds the watchdog) <─ end <─ exchange (the board's wire) <───────────────┘
//! ```
//!
//! # A tick
//! 1. [`MotionController::begin`] looks at what the servos said in the tick before, decides, and gives commands to the
//!    bus. A fault that it finds acts here: torque off is in the packets of this very tick.
//! 2. [`exchange`] puts these packets on the board's [`Wire`], and takes what comes back.
//! 3. [`MotionController::end`] says whether the tick was whole. Only then there is a
//!    [`Complete`](crate::watchdog::Complete), and a board feeds its watchdog with nothing else.
//!
//! As long as torque is not permitted, torque off goes out to all servos in every tick: one lost packet changes
//! nothing. Torque on goes out in every tick of arming, behind a first goal where the servo was measured.
//!
//! # The test of the way to stop
//! A rig is armed only after torque off has gone out, every servo that tells was read in a later tick, and none of them
//! drew current. It begins anew whenever torque was on.
//!
//! # Registers
//! A rig is armed only after the registers of every servo were read since torque was on, and since the servo was
//! silent: mode, return delay, status level, limits, shutdown, gains, as [`ServoSetup::requirements`] and
//! [`sinew_servo_bus::settings`] say.
//! As long as torque is off they are read round and round, a few bytes a tick; while it is on, never. A difference is
//! in [`Report::registers`] and refuses. Nothing is written: that is `sinew servo apply`.
//!
//! # Not here
//! It reads no clock and waits for nothing. What a servo's own watchdog does, and a register of torque that is read
//! back, are not in [`ServoBus`](sinew_servo_bus::ServoBus).

#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

mod belief;
#[expect(clippy::module_inception, reason = "the type of the module's name")]
mod controller;
mod coordinates;
mod error;
mod estimate;
mod feed;
mod output;
mod path;
mod performance;
mod pose;
mod registers;
mod report;
mod settings;
mod stop_test;
mod watch;
mod wire;

pub use controller::{Begun, Inputs, MotionController, check_budget};
pub use error::{ControllerError, Incomplete};
pub use estimate::{TICK_CYCLES, estimated_us};
pub use feed::{Jog, LiveSource, open_show};
pub use report::{DofReport, Following, Report, ServoReport};
pub use settings::{ControllerSettings, ServoSetup, Start};
pub use wire::{Wire, exchange};
