//! The control loop. It connects frames, tracker, drives, supervisor and guard to a bus of servos, one tick per call.
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
//! 1. [`MotionController::begin`] evaluates the servos' readings of the tick before, decides, and gives commands to
//!    the bus. A fault that it detects takes effect at once: torque off is in the packets of this very tick.
//! 2. [`exchange`] sends these packets on the board's [`Wire`], and reads the replies.
//! 3. [`MotionController::end`] returns a [`Complete`](crate::watchdog::Complete) only if the tick was complete. A
//!    board feeds its watchdog with nothing else.
//!
//! While torque is not permitted, torque off is sent to all servos in every tick, so a lost packet changes nothing.
//! Torque on is sent in every tick of arming, after a first goal at the servo's measured position.
//!
//! # The test of the way to stop
//! A rig is armed only after torque off was sent, every servo that reports was read in a later tick, and none of them
//! drew current. The test starts again whenever torque was on.
//!
//! # Registers
//! A rig is armed only after the registers of every servo were read, and read again after torque was on or the
//! servo was silent: mode, return delay, status level, limits, shutdown, gains, as [`ServoSetup::requirements`] and
//! [`sinew_servo_bus::settings`] define. While torque is off they are read repeatedly, a few bytes per tick; while
//! torque is on, never. A difference is stored in [`Report::registers`], and arming is refused. Nothing is written:
//! `sinew servo apply` does that.
//!
//! # Outside of this module
//! The controller reads no clock and waits for nothing. A [`ServoBus`](sinew_servo_bus::ServoBus) itself sets the
//! watchdogs of its servos and reads their torque registers; it only reports the results to the controller.

#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

mod approach;
mod belief;
#[expect(clippy::module_inception, reason = "the type of the module's name")]
mod controller;
mod coordinates;
mod error;
mod estimate;
mod feed;
mod lowering;
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

pub use approach::{Approach, approach};
pub use controller::{Begun, Inputs, MotionController, check_budget};
pub use error::{ControllerError, Incomplete};
pub use estimate::{TICK_CYCLES, estimated_us};
pub use feed::{Jog, LiveSource, open_show};
pub use report::{DofReport, Following, Report, ServoReport};
pub use settings::{ControllerSettings, ServoSetup, Start};
pub use wire::{Wire, exchange};
