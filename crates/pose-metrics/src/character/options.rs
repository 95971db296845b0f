//! Options of a user for a file.

use sinew_figure::measured::UnitOverrides;

use super::error::{Refusal, refuse};

/// The user's options for facts that a file does not contain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// Length of the unit, and the axis that points up.
    pub units: UnitOverrides,
    /// Frame of a motion whose pose becomes the rest pose; `None` for zero rotations.
    pub frame: Option<usize>,
}

impl Options {
    /// Refuses options that apply only to motions.
    pub(super) fn ensure_default(&self) -> Result<(), Refusal> {
        let of_motions = "a motion, or this option left out";
        if self.frame.is_some() {
            return Err(refuse("--frame", of_motions, "a file of one pose"));
        }
        Ok(())
    }
}
