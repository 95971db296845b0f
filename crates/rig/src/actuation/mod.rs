//! Drives and servos of a described rig, checked and in the form of the board, and the values that joints get from
//! them.

mod defaults;
mod drive;
mod joined_drive;
mod joint_friction;
mod servo;

use crate::description::{Description, DescriptionError};

pub use defaults::JointDefaults;
pub use joined_drive::JoinedDrive;
pub use joint_friction::JointFriction;

/// The drives and servos of a [`Description`].
#[derive(Debug, Clone, PartialEq)]
pub struct Actuation {
    /// Drives, in the order of the description.
    pub drives: Vec<JoinedDrive>,
    /// Servos, in the order of the description.
    pub servos: Vec<crate::servo::Servo>,
}

impl Description {
    /// Returns the drives and servos in the form of the board. Values that the file leaves out are those of the
    /// servo's kind.
    ///
    /// # Errors
    /// [`DescriptionError`] if a servo's kind is unknown, a number is invalid, or a drive is singular or exceeds
    /// the capacity of a board's drives.
    pub fn actuation(&self) -> Result<Actuation, DescriptionError> {
        let servos = (0..self.servos.len())
            .map(|index| servo::of(self, index))
            .collect::<Result<Vec<_>, _>>()?;
        let drives = (0..self.drives.len())
            .map(|index| drive::of(self, &servos, index))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Actuation { drives, servos })
    }
}

#[cfg(test)]
mod tests;
