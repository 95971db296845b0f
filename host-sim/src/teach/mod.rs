//! Teaching by hand: a rig is led, limp or carrying itself, and what was measured becomes a motion.
//!
//! ```text
//! Leads (where a scripted hand leads) ─> Lesson (a simulated rig, a tick a call) ─> rows ─> Taught (cut, smooth)
//! ```
//! Where rows come from makes no difference to [`Taught`].

mod leads;
mod lesson;
mod taught;

pub use leads::Leads;
pub use lesson::{Lesson, LessonError, Mode, Taken};
pub use taught::{REST_RAD, Taught, TaughtError, beside};
