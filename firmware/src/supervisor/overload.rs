//! An overload: the servos or the supply of a rig cannot hold it, and it is not armed.

use core::fmt;

/// An overload in the measured pose, in the first pose of the show, or on the way there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Overload {
    /// A joint needs more torque than its servo gives.
    Servo {
        /// Index of the dof.
        dof: u16,
        /// Torque at the servo's own shaft that the joint needs, mN m.
        mnm: u32,
        /// Maximum torque of the servo, mN m.
        most_mnm: u32,
    },
    /// All servos together need more current than the supply gives.
    Supply {
        /// Index of the dof whose servos need most.
        dof: u16,
        /// Current of all servos, mA.
        ma: u32,
        /// Maximum current of the supply, mA.
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
