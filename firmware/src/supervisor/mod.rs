//! The supervisor decides whether anything may move, how fast, and how faults are handled.
//!
//! ```text
//! detectors ─> Findings ─┐
//! commands, link, feeds ─┼─> Supervisor::step ─> Permission ─> tracker, drives ─> Guard ─> bus
//! time ──────────────────┘        │
//!                                 └─> answer, faults, log
//! ```
//!
//! # States
//! ```text
//! power-on ─> Off ─(all servos read)─> Limp ─(arm)─> Arming ─(time)─> Holding <─> Playing, Maintenance, Floating
//!                                     │  ^                               │
//!                  Calibrating, Teaching └────── Lowering <── Stopping <─┘
//! ```
//! A fault leads to Holding, Stopping, Lowering or at once to Faulted, as [`TABLE`] defines. From Faulted, clearing
//! leads to Limp, and from there only [`Command::Arm`] leads to torque.
//!
//! # Outside of this module
//! The supervisor reads no clock, measures nothing and moves nothing: [`Mode::next`] is a pure function, and
//! [`Supervisor`] adds the clocks. Detectors ([`detect`]) find faults; the [`Guard`] limits commands once more.
//!
//! # Source of commands
//! [`Inputs::heard`] refers to the place where commands come from. For a rig without a host that may be a panel of
//! switches on the board itself: it counts as heard as long as its readings are valid.
//!
//! ```
//! use sinew_firmware::supervisor::{
//!     Command, FaultLog, Inputs, Refused, Registers, Settings, Source, State, Supervisor,
//! };
//! let mut supervisor = Supervisor::new(Settings::default(), 1, FaultLog::default())?;
//! // All servos were read, their registers too, the stop was tested, the host is there.
//! let registers = Registers::Same;
//! let good =
//!     Inputs { heard: true, measured: true, registers, stop_tested: true, ..Inputs::default() };
//! let mut tick = |now_us, command| supervisor.step(&Inputs { now_us, command, ..good });
//! assert!(!tick(0, None).permission.torque);
//! // Torque comes on by command alone, where the servos are.
//! let armed = tick(2_000, Some(Command::Arm));
//! assert_eq!(armed.answer, Some(Ok(State::Arming)));
//! assert_eq!((armed.permission.torque, armed.permission.source), (true, Source::Measured));
//! assert_eq!(tick(1_100_000, None).state, State::Holding);
//! let stopped = tick(1_102_000, Some(Command::EStop));
//! assert_eq!((stopped.state, stopped.permission.torque), (State::Faulted, false));
//! let refused = tick(1_104_000, Some(Command::Arm)).answer;
//! assert!(matches!(refused, Some(Err(Refused::Fault(_)))));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

mod command;
pub mod detect;
mod event;
mod fault;
mod guard;
mod moving;
mod overload;
mod permission;
mod registers;
mod settings;
mod state;
#[expect(clippy::module_inception, reason = "the type of the module's name")]
mod supervisor;
mod transition;

pub use command::{Answer, Command, Refused};
pub use event::{Event, Feeds};
pub(crate) use fault::FaultNews;
pub use fault::{Clears, Fault, FaultLog, FaultRecord, FaultSet, Findings, Reaction, Row, TABLE};
pub use guard::{
    GoalLimits, Guard, GuardLimits, GuardReason, GuardSettings, Guarded, VoltageLimits,
};
pub use moving::Moving;
pub use overload::Overload;
pub use permission::Permission;
pub(crate) use permission::smooth;
pub use registers::{RegisterDiffers, Registers};
pub use settings::{LOWER_MOST, SOFT_MOST_RAD_S, Settings};
pub use state::{Allows, Feed, Mode, Operator, Source, State};
pub use supervisor::{Inputs, LOGGED, Outcome, Supervisor};
