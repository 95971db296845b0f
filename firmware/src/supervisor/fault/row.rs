//! What the table says about one fault.

use core::fmt;

use super::Fault;
use crate::supervisor::State;

/// What the supervisor does about a fault, from least to most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reaction {
    /// It is told, and nothing else. It does not latch.
    Note,
    /// The rig holds.
    Hold,
    /// The rig goes to its rest pose, is lowered, and is limp.
    Stop,
    /// The rig is lowered, and is limp.
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

/// What clears a latched fault. None is cleared while its condition is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Clears {
    /// It is over with its condition: it does not latch.
    Itself,
    /// The command to clear faults.
    Command,
    /// A new upload that is good.
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

/// What is done about one fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Row {
    /// Which.
    pub fault: Fault,
    /// The reaction in each state, by the state's number.
    pub reactions: [Reaction; State::COUNT],
    /// What clears it.
    pub clears: Clears,
}

impl Row {
    /// The reaction in a state.
    pub fn reaction(&self, state: State) -> Reaction {
        self.reactions.get(usize::from(state.number())).copied().unwrap_or(Reaction::Limp)
    }

    /// Whether it stays until it is cleared, where it had a reaction.
    pub const fn latches(&self) -> bool {
        !matches!(self.clears, Clears::Itself)
    }

    /// Whether the rig may not be armed while it is latched: it ends what the rig does in some state.
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
