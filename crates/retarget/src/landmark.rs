//! Places of a body that performer and rig have in common.

/// A side of the body, from the body's own view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// Left side.
    Left,
    /// Right side.
    Right,
}

impl Side {
    /// Both sides, left first.
    pub const ALL: [Self; 2] = [Self::Left, Self::Right];

    /// Returns the other side.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }
}

/// A place of a body: a joint between two parts of a limb, or a part of the trunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Landmark {
    /// The body that the hips are attached to.
    Pelvis,
    /// The body that the shoulders are attached to.
    Chest,
    /// The base of the neck.
    Neck,
    /// The head.
    Head,
    /// The ball joint between chest and upper arm; the clavicle does not count.
    Shoulder(Side),
    /// The joint between upper arm and forearm.
    Elbow(Side),
    /// The joint between forearm and hand.
    Wrist(Side),
    /// The ball joint between pelvis and thigh.
    Hip(Side),
    /// The joint between thigh and shank.
    Knee(Side),
    /// The joint between shank and foot.
    Ankle(Side),
    /// The joint at the ball of the foot.
    Toe(Side),
}

impl Landmark {
    /// All landmarks, from the trunk outwards, left before right.
    pub const ALL: [Self; 18] = {
        use Side::{Left, Right};
        [
            Self::Pelvis,
            Self::Chest,
            Self::Neck,
            Self::Head,
            Self::Shoulder(Left),
            Self::Elbow(Left),
            Self::Wrist(Left),
            Self::Shoulder(Right),
            Self::Elbow(Right),
            Self::Wrist(Right),
            Self::Hip(Left),
            Self::Knee(Left),
            Self::Ankle(Left),
            Self::Toe(Left),
            Self::Hip(Right),
            Self::Knee(Right),
            Self::Ankle(Right),
            Self::Toe(Right),
        ]
    };

    /// Returns the side of the landmark; `None` for the trunk.
    pub fn side(self) -> Option<Side> {
        match self {
            Self::Pelvis | Self::Chest | Self::Neck | Self::Head => None,
            Self::Shoulder(side)
            | Self::Elbow(side)
            | Self::Wrist(side)
            | Self::Hip(side)
            | Self::Knee(side)
            | Self::Ankle(side)
            | Self::Toe(side) => Some(side),
        }
    }

    /// Returns the same place on the other side; `None` for the trunk.
    #[must_use]
    pub fn mirrored(self) -> Option<Self> {
        let other = self.side()?.other();
        Some(match self {
            Self::Shoulder(_) => Self::Shoulder(other),
            Self::Elbow(_) => Self::Elbow(other),
            Self::Wrist(_) => Self::Wrist(other),
            Self::Hip(_) => Self::Hip(other),
            Self::Knee(_) => Self::Knee(other),
            Self::Ankle(_) => Self::Ankle(other),
            Self::Toe(_) => Self::Toe(other),
            Self::Pelvis | Self::Chest | Self::Neck | Self::Head => return None,
        })
    }

    /// Returns the name in files: `pelvis`, `l_shoulder`.
    pub fn name(self) -> &'static str {
        use Side::{Left, Right};
        match self {
            Self::Pelvis => "pelvis",
            Self::Chest => "chest",
            Self::Neck => "neck",
            Self::Head => "head",
            Self::Shoulder(Left) => "l_shoulder",
            Self::Shoulder(Right) => "r_shoulder",
            Self::Elbow(Left) => "l_elbow",
            Self::Elbow(Right) => "r_elbow",
            Self::Wrist(Left) => "l_wrist",
            Self::Wrist(Right) => "r_wrist",
            Self::Hip(Left) => "l_hip",
            Self::Hip(Right) => "r_hip",
            Self::Knee(Left) => "l_knee",
            Self::Knee(Right) => "r_knee",
            Self::Ankle(Left) => "l_ankle",
            Self::Ankle(Right) => "r_ankle",
            Self::Toe(Left) => "l_toe",
            Self::Toe(Right) => "r_toe",
        }
    }

    /// Returns the landmark with this name, if there is one.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|landmark| landmark.name() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_landmark_is_found_by_its_name() {
        for landmark in Landmark::ALL {
            assert_eq!(Landmark::named(landmark.name()), Some(landmark));
        }
    }
}
