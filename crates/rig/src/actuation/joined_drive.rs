//! A drive of a rig, and what it joins.

/// A drive, and what it joins.
#[derive(Debug, Clone, PartialEq)]
pub struct JoinedDrive {
    /// The drive.
    pub drive: crate::drive::Drive,
    /// Its joints, as indices into the description's.
    pub joints: Vec<usize>,
    /// Its servos, as indices into the description's.
    pub servos: Vec<usize>,
}
