//! Joints, and limits that join two of them.

/// What a joint leaves free.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum JointType {
    /// Nothing. Such joints are merged when the tree is made, see [`super::Description::mechanism`].
    Fixed,
    /// A turn about `axis`.
    #[default]
    Revolute,
    /// A slide along `axis`.
    Prismatic,
    /// A turn about `axis`, fixed in the joint frame, then about `second_axis`, fixed in the body.
    Universal,
    /// Any turn.
    Spherical,
    /// Any motion.
    Free,
}

impl JointType {
    /// How many numbers make its speed.
    pub fn dof_count(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute | Self::Prismatic => 1,
            Self::Universal => 2,
            Self::Spherical => 3,
            Self::Free => 6,
        }
    }
}

/// A joint: how a body moves on its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// What people call it; unique among joints.
    pub name: String,
    /// What it leaves free. Default: revolute.
    pub kind: JointType,
    /// The body that it hangs on.
    pub parent: String,
    /// The body that it moves.
    pub child: String,
    /// Where the joint is in the parent's frame, m.
    pub position_m: [f64; 3],
    /// Rotation of the joint frame in the parent's frame, unit quaternion x y z w.
    pub rotation_xyzw: [f64; 4],
    /// Unit axis in the joint frame; of revolute, prismatic and universal joints.
    pub axis: Option<[f64; 3]>,
    /// Unit axis in the body frame, perpendicular to `axis`; of universal joints.
    pub second_axis: Option<[f64; 3]>,
    /// Least and most angle of each axis: one pair for a revolute joint, two for a universal one; for a spherical one a
    /// pair `[0, most]` for the angle away from its zero pose. Empty: no limit.
    pub range_rad: Vec<[f64; 2]>,
    /// Least and most way of a prismatic joint, m.
    pub range_m: Option<[f64; 2]>,
    /// Position in the home pose, of a revolute joint. Default: zero, or the end of the range that is nearest to it.
    pub home_rad: Option<f64>,
    /// The same of a prismatic joint, m.
    pub home_m: Option<f64>,
    /// The largest speed that is asked for: of a turn.
    pub speed_rad_s: Option<f64>,
    /// The same of a slide, m/s.
    pub speed_m_s: Option<f64>,
    /// The largest acceleration that is asked for: of a turn.
    pub acceleration_rad_s2: Option<f64>,
    /// The same of a slide, m/s².
    pub acceleration_m_s2: Option<f64>,
    /// The largest torque (N m) or force (N) that the joint is given.
    pub effort: Option<f64>,
    /// The inertia that the drive's rotor adds to each dof, as its gear shows it: kg m², or kg of a slide.
    /// Default: that of the servos which move the joint.
    pub rotor_inertia: Option<f64>,
    /// Coulomb friction beside that of the servos: N m, or N of a slide.
    pub friction: f64,
    /// Viscous friction beside that of the servos: N m s, or N s/m of a slide.
    pub damping: f64,
}

impl Default for Joint {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: JointType::Revolute,
            parent: String::new(),
            child: String::new(),
            position_m: [0.0; 3],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
            axis: None,
            second_axis: None,
            range_rad: Vec::new(),
            range_m: None,
            home_rad: None,
            home_m: None,
            speed_rad_s: None,
            speed_m_s: None,
            acceleration_rad_s2: None,
            acceleration_m_s2: None,
            effort: None,
            rotor_inertia: None,
            friction: 0.0,
            damping: 0.0,
        }
    }
}

impl Joint {
    /// Its coordinates in the home pose, as `q` of `sinew-core` has them. Turns and slides that say nothing are at
    /// zero, or at the end of the range that is nearest to it.
    pub fn home(&self) -> Vec<f64> {
        let nearest_to_zero = |range: Option<[f64; 2]>| {
            range.map_or(0.0, |[least, most]| 0.0_f64.max(least).min(most))
        };
        let range_rad = |axis: usize| self.range_rad.get(axis).copied();
        match self.kind {
            JointType::Fixed => Vec::new(),
            JointType::Revolute => {
                vec![self.home_rad.unwrap_or_else(|| nearest_to_zero(range_rad(0)))]
            }
            JointType::Prismatic => {
                vec![self.home_m.unwrap_or_else(|| nearest_to_zero(self.range_m))]
            }
            JointType::Universal => {
                vec![nearest_to_zero(range_rad(0)), nearest_to_zero(range_rad(1))]
            }
            JointType::Spherical => vec![0.0, 0.0, 0.0, 1.0],
            JointType::Free => vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        }
    }
}

/// A limit on the sum of two joints' positions: `least <= factor · q[joint] + other_factor · q[other] <= most`.
///
/// For two lids that must not meet: `1 · upper - 1 · lower >= 0`.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkedLimit {
    /// A joint of one dof.
    pub joint: String,
    /// Another one.
    pub other: String,
    /// Factor of the first. Default: 1.
    pub factor: f64,
    /// Factor of the second. Default: -1.
    pub other_factor: f64,
    /// Least sum, of two joints that turn.
    pub least_rad: Option<f64>,
    /// Most.
    pub most_rad: Option<f64>,
    /// Least sum of two joints that slide, m.
    pub least_m: Option<f64>,
    /// Most.
    pub most_m: Option<f64>,
}

impl Default for LinkedLimit {
    fn default() -> Self {
        Self {
            joint: String::new(),
            other: String::new(),
            factor: 1.0,
            other_factor: -1.0,
            least_rad: None,
            most_rad: None,
            least_m: None,
            most_m: None,
        }
    }
}
