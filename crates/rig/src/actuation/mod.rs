//! What moves a described rig: its drives and servos, checked, as a board has them; and what joints get from them.

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
    /// In the order of the description.
    pub drives: Vec<JoinedDrive>,
    /// In the order of the description.
    pub servos: Vec<crate::servo::Servo>,
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
