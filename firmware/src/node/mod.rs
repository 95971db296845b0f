//! A node: a complete controller board except for its hardware.
//!
//! ```text
//!          main, step by step                               timer interrupt, tick by tick
//! host <── BackgroundTask ── Mail: orders, live frames ──> ControlLoop ─> MotionController ─> bus of servos
//!               │       <── Mail: answers, faults, snapshots ──   │
//!          Store (flash)                                     Safety: e-stop, OE, watchdog
//! ```
//!
//! - [`start`] reads the stored data from flash, and reports bad data as numbered faults.
//! - [`ControlLoop::tick`] runs in the timer interrupt: one tick, with requests of the mail first. Only it feeds the
//!   watchdog.
//! - [`BackgroundTask::step`] runs in `main`: bytes of the host link, storage, the log of faults, telemetry.
//! - [`Mail`] is the only shared state; [`Shared`] is the board's critical section around it.
//! - [`Safety`] and [`Port`] are the board's interface.
//!
//! # Permission to erase
//! There is only one [`Disarmed`](sinew_storage::Disarmed), and it moves. While torque is off it is in the mail. The
//! control loop takes it to arm, and gives it back when torque is off again; the background task takes it to write or
//! erase. Nothing is erased while armed, and nothing is armed while flash is erased: the types guarantee it,
//! whichever context interrupts the other.
//!
//! # Shows in flash
//! A show is read in place: the loop holds a `&'a [u8]` of memory-mapped flash, which [`Port::lend`] returns. Only
//! slots are lent. While the loop has not reported which show it reads, no slot is erased and no other slot is lent.
//! At most two are lent: the old one stays lent until the loop has the new one. An upload goes to slots that are not
//! lent. A board must therefore guarantee only `lend`.
//!
//! # Changes of rig and settings
//! Rig and settings are read only at the start. After an upload of them, or after a setting was written, the node
//! asks for a [restart](Next::Restart), so they always take effect in the same way as at power-on. The host then
//! connects again.

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
