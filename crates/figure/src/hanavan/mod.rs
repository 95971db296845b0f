//! Hanavan's body model as modified by Kwon: the segments of a measured subject are solids of uniform density.
//!
//! E. P. Hanavan, "A Mathematical Model of the Human Body", AMRL-TR-64-102 (1964); Y.-H. Kwon, dissertation
//! (1993). Kwon's text was not available: geometry and masses are those of implementations of the model. Questions
//! that they leave open are decided here and marked in the comments.
//!
//! - Limbs are truncated cones, thighs and feet elliptical solids, head and hands ellipsoids. The trunk is, from
//!   top to bottom, an elliptical column, an elliptical solid and a column. The upper column is cut into thorax
//!   and two clavicle bodies (`cut.rs`). The head starts at its joint: the model has no neck.
//! - Masses are computed by regressions (`masses.rs`). Their sum differs from the total mass by some percent; if the
//!   subject's `normalise` is true, all masses are scaled so that their sum is the total mass.
//! - On a clip's skeleton, masses and cross-sections are the subject's. A limb is as long as its bone. All other
//!   segments have the subject's length times one factor, the ratio of the clip's legs to the subject's. The
//!   shoulder parts keep their place in the upper trunk's column: in the zero pose the three parts together are
//!   the column, wherever the skeleton has its clavicle joints.

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
