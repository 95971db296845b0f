//! Checks that a show is for a given rig.

use sinew_core::JointKind;

use crate::error::ShowError;
use crate::joint::Joint;
use crate::show::Show;

impl<'a> Show<'a> {
    /// Refuses a show that was made for another rig. `crc`: the last four bytes of the rig's compact form.
    ///
    /// # Errors
    /// [`ShowError::Rig`] with both CRCs.
    pub fn check_rig(&self, crc: u32) -> Result<(), ShowError> {
        let show = self.header().rig;
        if show == crc { Ok(()) } else { Err(ShowError::Rig { show, here: crc }) }
    }

    /// Refuses a show whose joints differ from those of a rig, in regular numbering.
    ///
    /// # Errors
    /// [`ShowError::Joints`] or [`ShowError::Joint`] with the difference.
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

    /// Returns the CRC of the rig that the show was made for; 0 if it is unknown.
    pub fn rig(&self) -> u32 {
        self.header().rig
    }

    /// Returns the kinds of the rig's joints, in regular numbering.
    pub fn joints(&self) -> impl ExactSizeIterator<Item = Joint> + 'a {
        self.joints.iter().map(|code| Joint::of_code(*code).unwrap_or(Joint::Fixed))
    }
}
