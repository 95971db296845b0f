//! Shows of a rig: splines of its coordinates, read in place from flash. The format: `docs/show-format.md`.
//!
//! - [`Show`] opens a show in place. [`Player`] plays it: position, speed and acceleration of the same curve.
//! - [`ShowFrames`] supplies a [`Tracker`](sinew_core::tracker::Tracker) with frames. [`Blend`] leads into a show and
//!   out of it.
//! - `write` (with `std`) creates shows from samples, with few knots for a given maximum error.
//!
//! Everything except `write` is `no_std`: fixed capacity, no allocation, no `unsafe`, no panic, no f64.
//!
//! ```
//! # #[cfg(feature = "std")] {
//! use sinew_show::write::{Motion, Settings, write};
//! use sinew_show::{Joint, Player, Rate, Show};
//!
//! // On the host: an elbow that swings for two seconds, with 100 samples per second.
//! let q: Vec<f64> = (0..=200).map(|k| 0.8 * (0.03 * f64::from(k)).sin()).collect();
//! let motion = Motion {
//!     joints: &[Joint::Revolute],
//!     q: &q,
//!     rate: Rate { samples: 100, seconds: 1 },
//!     is_loop: false,
//!     rig: 0x1234_abcd,
//!     cues: &[(150, "lights out")],
//!     time_code: None,
//!     course: &[],
//! };
//! let written = write(&motion, &Settings::default())?;
//! assert!(written.angles.largest <= 0.25_f64.to_radians());
//!
//! // On the board: for this rig, with room for eight coordinates.
//! let show = Show::open(&written.bytes)?;
//! show.check_rig(0x1234_abcd)?;
//! let mut player = Player::<8>::new(show)?;
//! let (mut q, mut qd, mut qdd) = ([0.0; 1], [0.0; 1], [0.0; 1]);
//! player.state_at(show.pace(0.002).position(250), &mut q, &mut qd, &mut qdd)?;
//! // After half a second: 0.8 sin 1.5, with derivatives as accurate as the bound allows.
//! assert!((q[0] - 0.798).abs() < 0.005 && qd[0].abs() < 0.5 && qdd[0] < -5.0);
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Files
//! - `show`, `layout`, `rig`, `joint`, `error`: the head of a show, checked when it is opened.
//! - `position`: the position in a show to 2⁻³² of a sample; f32 seconds would lose 30 µs after ten minutes.
//! - `bits`, `span_lengths`, `channel`: one channel, from bits to the six knots around a position.
//! - `span`, `chart`: a span as a cubic; channels to joint coordinates (a ball joint is p / |p|).
//! - `player`, `frames`, `blend`: all channels at a position; frames for the tracker; blends.
//! - `cue`, `time_code`, `time_warp`: cues; the clock of a production; a slowed show's time in its performance.
//! - `sound`: the section for a sound, which follows a show in its file and is read by hosts.
//! - `write/`: a `motion` and `settings` to `channels`, knots (`refine`, `curve`), least squares (`fit`), bits
//!   (`pack`), and the error of the decoder's result (`measure`).

#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

mod bits;
mod blend;
mod channel;
mod chart;
mod cue;
mod error;
mod frames;
mod joint;
mod layout;
mod player;
mod position;
mod rig;
mod show;
#[cfg(feature = "std")]
pub mod sound;
mod span;
mod span_lengths;
mod time_code;
mod time_warp;
#[cfg(feature = "std")]
#[expect(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects,
    reason = "the host may stop at a fault of its own"
)]
pub mod write;

pub use blend::{Blend, BlendError, State};
pub use cue::{Cue, Cues};
pub use error::ShowError;
pub use frames::ShowFrames;
pub use joint::Joint;
pub use player::Player;
pub use position::{Pace, Position, Rate};
pub use show::Show;
pub use time_code::{TimeCode, TimeCodeKind};
pub use time_warp::TimeWarp;
