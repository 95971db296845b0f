//! From a recorded skeleton to the 18-body figure.
//!
//! A mapping file says for each body of the figure which joint of the recording it hangs on, which
//! joint's frame it takes, and where its segment ends. The offsets of the figure are those of the
//! recorded skeleton at rest, so that they are constant over a clip; the rotation of a body relative
//! to its parent holds the rotations of all joints between the two.

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
