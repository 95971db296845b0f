//! A drive with the joints and servos that it connects.

/// A drive with the joints and servos that it connects.
#[derive(Debug, Clone, PartialEq)]
pub struct JoinedDrive {
    /// The drive, in the form of the board.
    pub drive: crate::drive::Drive,
    /// Joints of the drive, as indices into the description's joints.
    pub joints: Vec<usize>,
    /// Servos of the drive, as indices into the description's servos.
    pub servos: Vec<usize>,
}
