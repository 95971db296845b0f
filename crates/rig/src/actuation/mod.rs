//! What moves a described rig: its drives and servos, checked, as a board has them; and what joints get from them.

mod defaults;
mod drive;
mod joint_friction;
mod servo;

use crate::description::{Description, DescriptionError};

pub use defaults::JointDefaults;
pub use joint_friction::JointFriction;

/// The drives and servos of a [`Description`].
#[derive(Debug, Clone, PartialEq)]
pub struct Actuation {
    /// In the order of the description.
    pub drives: Vec<DriveOf>,
    /// In the order of the description.
    pub servos: Vec<crate::servo::Servo>,
}

/// A drive, and what it joins.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveOf {
    /// The drive.
    pub drive: crate::drive::Drive,
    /// Its joints, as indices into the description's.
    pub joints: Vec<usize>,
    /// Its servos, as indices into the description's.
    pub servos: Vec<usize>,
}

impl Description {
    /// The drives and servos as a board has them, with what their kinds say where the file says nothing.
    ///
    /// # Errors
    /// [`DescriptionError`] if a servo's kind is not known, a number does not suit, or a drive is singular or larger
    /// than a board's.
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
