//! Options of a user for a file.

use sinew_figure::measured::UnitOverrides;

use super::error::{Refusal, refuse};

/// What a file does not tell.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// The length of its unit, and which axis points up.
    pub units: UnitOverrides,
    /// The frame of a motion whose pose is the rest pose; without, all rotations are zero.
    pub frame: Option<usize>,
}

impl Options {
    /// Refuses what only motions have a use for.
    pub(super) fn ensure_default(&self) -> Result<(), Refusal> {
        let of_motions = "a motion, or this option left out";
        if self.frame.is_some() {
            return Err(refuse("--frame", of_motions, "a file of one pose"));
        }
        Ok(())
    }
}
