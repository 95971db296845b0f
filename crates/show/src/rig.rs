//! Which rig a show is for.

use sinew_core::JointKind;

use crate::error::ShowError;
use crate::joint::Joint;
use crate::show::Show;

impl<'a> Show<'a> {
    /// Refuses a show that was made for another rig. `crc`: the last four bytes of the rig's compact form.
    ///
    /// # Errors
    /// [`ShowError::Rig`] with both.
    pub fn check_rig(&self, crc: u32) -> Result<(), ShowError> {
        let show = self.header().rig;
        if show == crc { Ok(()) } else { Err(ShowError::Rig { show, here: crc }) }
    }

    /// Refuses a show whose joints are not those of a rig, in regular numbering.
    ///
    /// # Errors
    /// [`ShowError::Joints`] or [`ShowError::Joint`] name what is different.
    pub fn check_joints(
        &self,
        kinds: impl ExactSizeIterator<Item = JointKind>,
    ) -> Result<(), ShowError> {
        let (show, here) = (self.joints.len(), kinds.len());
        if show != here {
            return Err(ShowError::Joints { show, here });
        }
        for (index, (show, here)) in self.joints().zip(kinds.map(Joint::from)).enumerate() {
            if show != here {
                return Err(ShowError::Joint { index, show, here });
            }
        }
        Ok(())
    }

    /// The CRC of the rig it was made for; 0 if that was not said.
    pub fn rig(&self) -> u32 {
        self.header().rig
    }

    /// Its joints, in regular numbering.
    pub fn joints(&self) -> impl ExactSizeIterator<Item = Joint> + 'a {
        self.joints.iter().map(|code| Joint::of_code(*code).unwrap_or(Joint::Fixed))
    }
}
