//! Teaching by hand: a rig is led, limp or carrying itself, and what was measured becomes a motion.
//!
//! ```text
//! Leads (where a ScriptedHand leads) ─> Lesson (a simulated rig, a tick a call) ─┐
//!                  telemetry of a board ─> rows (evenly spaced) ────────────────┴─> Taught (cut, smooth)
//! ```
//! Where rows come from makes no difference to [`Taught`].

mod hand;
mod leads;
mod lesson;
mod received;
mod taught;

pub use hand::ScriptedHand;
pub use leads::Leads;
pub use lesson::{Lesson, LessonError, Mode, Taken, check_servos};
pub use received::{ReceivedError, rows};
pub use taught::{REST_RAD, Taught, TaughtError, beside};
