//! Why a rig cannot be matched.

/// Why a rig cannot be matched.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RigMatchError {
    /// No words and no shape of a performer.
    #[error(
        "no arm, leg or head found among {joints} joints: expected names with a side and a limb (left_knee, l_arm_z), \
         or one chain without branches"
    )]
    Nothing {
        /// Number of joints.
        joints: usize,
    },
    /// A joint that does not turn.
    #[error("{landmark}: expected joints that turn, found `{joint}`, which does not")]
    DoesNotTurn {
        /// Name of the landmark.
        landmark: &'static str,
        /// Name of the joint.
        joint: String,
    },
    /// An index without a body.
    #[error(
        "{landmark}: expected joints of the rig, found index {joint}, and it has {bodies} bodies"
    )]
    NoJoint {
        /// Name of the landmark.
        landmark: &'static str,
        /// The index.
        joint: usize,
        /// Bodies of the rig.
        bodies: usize,
    },
}
