//! A node: the whole of a controller's board, but for its hardware.
//!
//! ```text
//!          main, step by step                               timer interrupt, tick by tick
//! host <── BackgroundTask ── Mail: orders, live frames ──> ControlLoop ─> MotionController ─> bus of servos
//!               │       <── Mail: answers, faults, snapshots ──   │
//!          Store (flash)                                     Safety: e-stop, OE, watchdog
//! ```
//!
//! - [`start`] reads back what flash keeps, and says what is bad as numbered faults.
//! - [`ControlLoop::tick`] runs in the timer interrupt: one tick, requests of the mail first. It alone feeds the
//!   watchdog.
//! - [`BackgroundTask::step`] runs in `main`: bytes of the host link, storage, the log of faults, telemetry.
//! - [`Mail`] is all that both share; [`Shared`] is the board's critical section round it.
//! - [`Safety`] and [`Port`] are what a board provides.
//!
//! # Who may erase
//! There is one [`Disarmed`](sinew_storage::Disarmed), and it moves. While torque is off it is in the mail. The
//! control loop takes it away to arm, and gives it back when torque is off again; the background task takes it to write
//! or erase. Nothing is erased while armed, and nothing is armed while flash is erased: the types say so,
//! whoever interrupts whom.
//!
//! # Shows in flash
//! A show is read in place: the loop holds a `&'a [u8]` of memory-mapped flash, which [`Port::lend`] gives. Only
//! slots are lent. While the loop has not said which show it reads, none is erased and no other is lent: two are lent
//! at most, the old one until the loop has the new one. An upload goes to slots that hold none. So the one place that a
//! board must vouch for is `lend`.
//!
//! # Another rig, other settings
//! They are read at the start alone. After an upload of them, or a setting that was written, the node asks for a
//! [restart](Next::Restart): one way in, the same that power-on takes. The host says hello again.

#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

mod background_task;
mod board;
mod commands;
mod control;
mod faults;
mod items;
mod live;
mod mail;
mod mark;
mod min_supply;
mod outbox;
mod pending;
mod service;
mod settings;
mod snapshot;
mod start;
mod telemetry;
mod text;
mod timing;

pub use background_task::{BackgroundTask, Next, Setup};
pub use board::{Port, Safety, causes};
pub use control::{ControlError, ControlLoop};
pub use items::SHOW_SCHEMA;
pub use mail::{Mail, Shared};
pub use mark::link_version;
pub use settings::{
    NodeSettings, SETTING_NAMES, SETTING_TEXTS, SETTINGS_MAX, SETTINGS_SCHEMA, SettingsError,
};
pub use start::{Found, RIG_SCHEMA, join_rig, split_rig, start};
pub use text::limiter;
pub use timing::{Spread, Timing, Timings};
