//! The joint of a landmark, with its confidence.

/// The joint of a landmark.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Index of the joint in the skeleton.
    pub joint: usize,
    /// Confidence: 0 is a guess; at 1, name, side, tree, mirror partner and lengths agree.
    pub confidence: f64,
    /// The weakest evidence for this joint, in plain words.
    pub reason: String,
}
