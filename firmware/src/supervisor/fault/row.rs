//! A row of the table of faults.

use core::fmt;

use super::Fault;
use crate::supervisor::State;

/// The supervisor's reaction to a fault, from weakest to strongest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reaction {
    /// The fault is only reported. It does not latch.
    Note,
    /// The rig holds.
    Hold,
    /// The rig moves to its rest pose, is lowered, and then torque is off.
    Stop,
    /// The rig is lowered, and then torque is off.
    Lower,
    /// Torque is off in this tick.
    Limp,
}

impl fmt::Display for Reaction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Note => "note",
            Self::Hold => "hold",
            Self::Stop => "stop",
            Self::Lower => "lower",
            Self::Limp => "limp",
        })
    }
}

/// The action that clears a latched fault. A fault is not cleared while its condition is present.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Clears {
    /// The fault ends with its condition: it does not latch.
    Itself,
    /// The command that clears faults.
    Command,
    /// An upload of valid data.
    Upload,
}

impl fmt::Display for Clears {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Itself => "itself",
            Self::Command => "command",
            Self::Upload => "upload",
        })
    }
}

/// A fault's reactions and how it is cleared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Row {
    /// The fault.
    pub fault: Fault,
    /// The reaction in each state, by the state's number.
    pub reactions: [Reaction; State::COUNT],
    /// The action that clears the fault.
    pub clears: Clears,
}

impl Row {
    /// Returns the reaction in a state.
    pub fn reaction(&self, state: State) -> Reaction {
        self.reactions.get(usize::from(state.number())).copied().unwrap_or(Reaction::Limp)
    }

    /// Returns whether the fault stays until it is cleared, if it caused a reaction.
    pub const fn latches(&self) -> bool {
        !matches!(self.clears, Clears::Itself)
    }

    /// Returns whether the rig cannot be armed while the fault is latched: this is so if the fault ends the rig's
    /// motion in some state.
    #[expect(clippy::indexing_slicing, clippy::arithmetic_side_effects, reason = "at build time")]
    pub(super) const fn is_serious(&self) -> bool {
        let mut state = 0;
        while state < State::COUNT {
            if !matches!(self.reactions[state], Reaction::Note | Reaction::Hold) {
                return true;
            }
            state += 1;
        }
        false
    }
}
