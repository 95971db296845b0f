//! The reason why a rig cannot be matched.

/// The reason why a rig cannot be matched.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RigMatchError {
    /// Neither names nor shape match a performer.
    #[error(
        "no arm, leg or head found among {joints} joints: expected names with a side and a limb (left_knee, l_arm_z), \
         or one chain without branches"
    )]
    Nothing {
        /// Number of joints.
        joints: usize,
    },
    /// A joint of a group does not turn.
    #[error("{landmark}: expected joints that turn, found `{joint}`, which does not")]
    DoesNotTurn {
        /// Name of the landmark.
        landmark: &'static str,
        /// Name of the joint.
        joint: String,
    },
    /// An index is beyond the rig's bodies.
    #[error(
        "{landmark}: expected joints of the rig, found index {joint}, and it has {bodies} bodies"
    )]
    NoJoint {
        /// Name of the landmark.
        landmark: &'static str,
        /// Index that was found.
        joint: usize,
        /// Number of bodies of the rig.
        bodies: usize,
    },
}
