//! Maps a recorded skeleton to the 18-body figure.
//!
//! For each body of the figure, a mapping file names the joint of the recording at the body's origin, the joint
//! whose frame the body has, and the end of the body's segment. The offsets of the figure are those of the
//! recorded skeleton at rest, which makes them constant over a clip. The rotation of a body relative to its parent
//! contains the rotations of all joints between the two.

mod binding;
mod chosen;
mod file;
mod known;

pub use binding::{Binding, UnlikeSides};
pub use chosen::{ChosenMapping, Proposal, find_mapping};
pub use file::{Error, Mapping, Mistake, NoRate};
pub use known::{KnownSkeleton, choose, find_nearest, known_skeletons};

#[cfg(test)]
mod tests;
