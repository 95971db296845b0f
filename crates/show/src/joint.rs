//! Kinds of joints in a show, and their channels.

use sinew_core::JointKind;

/// Kind of a joint, without its axes: all that a show needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joint {
    /// A joint without dofs.
    Fixed,
    /// A joint with an angle, rad.
    Revolute,
    /// A joint with a displacement, m.
    Prismatic,
    /// A joint with two angles, rad.
    Universal,
    /// A joint with any rotation.
    Spherical,
    /// A joint with any rotation and position, m.
    Free,
}

impl Joint {
    const ALL: [Self; 6] = [
        Self::Fixed,
        Self::Revolute,
        Self::Prismatic,
        Self::Universal,
        Self::Spherical,
        Self::Free,
    ];

    /// Returns the number of the kind in a show.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Returns the kind with this number, or `None` if there is none.
    pub fn of_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }

    /// Returns the number of the joint's coordinates in `q`, which is also its number of channels.
    pub const fn coordinate_count(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute | Self::Prismatic => 1,
            Self::Universal => 2,
            Self::Spherical => 4,
            Self::Free => 7,
        }
    }

    /// Returns the number of the joint's dofs in `qd` and `qdd`.
    pub const fn dof_count(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute | Self::Prismatic => 1,
            Self::Universal => 2,
            Self::Spherical => 3,
            Self::Free => 6,
        }
    }

    /// Returns `true` if the joint's first four channels are a quaternion.
    pub const fn turns_freely(self) -> bool {
        matches!(self, Self::Spherical | Self::Free)
    }
}

impl From<JointKind> for Joint {
    fn from(kind: JointKind) -> Self {
        match kind {
            JointKind::Fixed => Self::Fixed,
            JointKind::Revolute { .. } => Self::Revolute,
            JointKind::Prismatic { .. } => Self::Prismatic,
            JointKind::Universal { .. } => Self::Universal,
            JointKind::Spherical => Self::Spherical,
            JointKind::Free => Self::Free,
        }
    }
}

impl core::fmt::Display for Joint {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Fixed => "fixed",
            Self::Revolute => "revolute",
            Self::Prismatic => "prismatic",
            Self::Universal => "universal",
            Self::Spherical => "spherical",
            Self::Free => "free",
        })
    }
}
