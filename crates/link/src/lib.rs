//! The link between a host and a controller: bytes in, bytes out, with no I/O, no clock, no allocation, no panic.
//!
//! - [`encode`] and [`Decoder`] convert messages to frames (COBS, CRC-32) and back; any bytes may be between the
//!   frames.
//! - [`message`] defines the messages of both directions. The page `docs/link.md` describes them for programs that do
//!   not use this crate.
//! - [`Session`] numbers messages on the controller's side. It executes a command once, and answers every copy of it.
//! - [`Sender`] numbers messages on the host's side. It repeats a command until an answer arrives.
//! - [`LiveBuffer`] turns live frames with jitter into ordered, timed targets within limits of speed.
//! - [`Snapshot`](message::Snapshot) contains the state of a rig and is cut into frames of telemetry; [`rate`]
//!   computes how many snapshots per second fit on a line.
//!
//! # A command and its answer
//! ```
//! use sinew_link::message::{Applied, Command, Hello, Outcome, State, ToController, ToHost};
//! use sinew_link::{Decoder, FRAME_MAX, Intake, Sender, Session, encode};
//! # use sinew_link::message::{About, Capacities, Release, Version};
//! # let about = About {
//! #     protocol: Version::CURRENT,
//! #     firmware: Release { major: 0, minor: 1, patch: 0 },
//! #     rig: 0,
//! #     capacities: Capacities { bodies: 32, coordinates: 40, dofs: 32, servos: 24, slots: 1, slot_bytes: 131_072 },
//! # };
//!
//! // The controller answers a greeting with a session.
//! let mut session = Session::new(7);
//! let hello = Hello { protocol: Version::CURRENT, nonce: 0x1234_5678 };
//! let welcome = session.hello(hello, about, false);
//!
//! // The host sends a command.
//! let mut sender = Sender::new(welcome.session);
//! let command = ToController::Command(sender.send(Command::Arm, 0)?);
//! let mut out = [0; FRAME_MAX];
//! let wire = encode(&command, &mut out)?;
//!
//! // The controller executes it, and answers.
//! let mut decoder = Decoder::<ToController>::new();
//! let mut answer = None;
//! decoder.feed(wire, |message| {
//!     if let ToController::Command(command) = message {
//!         answer = Some(match session.command(&command) {
//!             Intake::Execute => {
//!                 let arming = Outcome::Applied(Applied::State(State::Arming));
//!                 session.answer(command.session, command.seq, arming)
//!             }
//!             Intake::Answer(answer) => answer,
//!         });
//!     }
//! });
//! let outcome = sender.take(&answer.expect("the command came"));
//! assert_eq!(outcome, Some(Outcome::Applied(Applied::State(State::Arming))));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//! - SI units and radians; quaternions xyzw, unit. The name of a value in another unit ends in that unit.
//! - No number in a message is NaN or infinite: such a message is neither written nor read.
//! - Kinds of messages, states and reasons are numbered in the order of their declaration. New items are added at
//!   the end; no item is ever removed or moved. Faults are plain numbers: those of `docs/faults.md`.
//! - This crate makes no safety decision. A supervisor does, and it does not trust the link.
//!
//! # Files
//! - `frame`, `decoder`, `finite`: a message as a frame; messages in a stream that may contain garbage; finite
//!   numbers only.
//! - `message/`: a file for each subject; `telemetry` cuts a snapshot into frames.
//! - `window`, `session`, `sender`: received numbers; the controller's side; the host's side.
//! - `live/`: the sender's clock (`timeline`), a target for each tick (`buffer`), speeds by joint (`coordinate`).
//! - `rate`: capacity of a line.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]
#![expect(
    clippy::large_enum_variant,
    reason = "there is no heap: a message has the size of its largest kind"
)]

mod decoder;
mod finite;
mod frame;
mod live;
pub mod message;
pub mod rate;
mod sender;
mod session;
mod window;

pub use decoder::{Damage, Decoder};
pub use frame::{BODY_MAX, EncodeError, FRAME_MAX, Message, encode};
pub use live::{
    Coordinate, Following, LiveBuffer, LiveCounts, LiveRefusal, LiveSettings, LiveSetupError,
    LiveTarget,
};
pub use sender::{Next, Sender, SenderBusy};
pub use session::{Intake, Session};
pub use window::{Order, Window, WindowCounts};
