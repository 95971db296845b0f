//! The joint of a landmark, and how sure it is.

/// The joint of a landmark.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The joint's index in the skeleton.
    pub joint: usize,
    /// How sure it is: 0 is a guess, 1 says that name, side, tree, mirror partner and lengths agree.
    pub confidence: f64,
    /// The weakest of its evidence, in plain words.
    pub reason: String,
}
