//! The body model of Hanavan as modified by Kwon: segments of a measured subject as solids of uniform
//! density.
//!
//! E. P. Hanavan, "A Mathematical Model of the Human Body", AMRL-TR-64-102 (1964); Y.-H. Kwon,
//! dissertation (1993). Kwon's text was not available: geometry and masses are those of implementations of
//! the model, and what they leave open is decided here and said where it is.
//!
//! - Limbs are truncated cones, thighs and feet elliptical solids, head and hands ellipsoids; the trunk is
//!   an elliptical column above, an elliptical solid and a column below. The upper one is cut in thorax and
//!   two clavicle bodies (`cut.rs`). The head starts at its joint: the model has no neck.
//! - Masses come from regressions (`masses.rs`). Their sum differs from the total mass by some percent; the
//!   subject's `normalise` scales that away.
//! - On a clip's skeleton mass and cross-sections are the subject's. Limbs are as long as their bones, and
//!   all other segments have the subject's length times one factor, which is the ratio of the clip's legs
//!   to the subject's. The shoulder parts stay where they are in the upper trunk's column, so that the
//!   three together are the column in the zero pose, wherever the skeleton has its clavicle joints.

mod error;
mod inputs;
mod masses;
mod segments;
mod shape;
mod skeleton;
mod subject;

pub use error::{InputError, SubjectError, Values};
pub use inputs::{Inputs, Kilograms, Metres};
pub use segments::Segment;
pub use shape::{Piece, Shape};
pub(super) use skeleton::{OwnSkeleton, bodies};
pub use subject::Subject;

#[cfg(test)]
mod tests;
