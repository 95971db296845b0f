//! A rig that its servos or its supply cannot hold, and which is not armed.

use core::fmt;

/// What cannot be held: in the pose that was measured, in the first one of the show, or on the way there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Overload {
    /// A joint takes more of a servo than it can give.
    Servo {
        /// The joint's dof.
        dof: u16,
        /// What it takes at the servo's own shaft, mN m.
        mnm: u32,
        /// The most that the servo gives, mN m.
        most_mnm: u32,
    },
    /// All servos together draw more than the supply gives.
    Supply {
        /// The dof whose servos draw most.
        dof: u16,
        /// What all draw, mA.
        ma: u32,
        /// What the supply gives, mA.
        most_ma: u32,
    },
}

impl fmt::Display for Overload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Servo { dof, mnm, most_mnm } => {
                write!(f, "joint {dof} takes {mnm} mN m of its servo, which gives {most_mnm}")
            }
            Self::Supply { dof, ma, most_ma } => {
                write!(f, "all take {ma} mA, and joint {dof} most; the supply gives {most_ma}")
            }
        }
    }
}
