//! Teaching by hand: a rig is led, with torque off or floating, and the measured positions become a motion.
//!
//! ```text
//! GuideTrajectory of a ScriptedHand ─> TeachSession (a simulated rig, a tick a call) ─┐
//!                      telemetry of a board ─> rows (evenly spaced) ────────────────┴─> TeachResult (cut, smooth)
//! ```
//! [`TeachResult`] accepts rows from a simulated rig and from a board.

mod guide_trajectory;
mod hand;
mod received;
mod result;
mod session;

pub use guide_trajectory::GuideTrajectory;
pub use hand::ScriptedHand;
pub use received::{ReceivedError, rows};
pub use result::{REST_RAD, TeachResult, TeachResultError, compare_with_guide};
pub use session::{Mode, TeachRecording, TeachSession, TeachSessionError, check_servos};
