//! Joints, and limits that join two of them.

/// Kind of motion that a joint permits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum JointType {
    /// No motion. [`super::Description::mechanism`] merges the bodies of such joints.
    Fixed,
    /// Rotation about `axis`.
    #[default]
    Revolute,
    /// Translation along `axis`.
    Prismatic,
    /// Rotation about `axis`, which is fixed in the joint frame, then about `second_axis`, which is fixed in the
    /// body.
    Universal,
    /// Rotation about any axis.
    Spherical,
    /// Any rotation and translation.
    Free,
}

impl JointType {
    /// Returns the number of dofs: 0 to 6.
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

/// A joint, which connects a body to its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name of the joint; unique among joints.
    pub name: String,
    /// Kind of motion. Default: revolute.
    pub kind: JointType,
    /// Name of the parent body.
    pub parent: String,
    /// Name of the body that the joint moves.
    pub child: String,
    /// Position of the joint in the parent's frame, m.
    pub position_m: [f64; 3],
    /// Rotation of the joint frame in the parent's frame, unit quaternion x y z w.
    pub rotation_xyzw: [f64; 4],
    /// Unit axis in the joint frame; for revolute, prismatic and universal joints.
    pub axis: Option<[f64; 3]>,
    /// Unit axis in the body frame, perpendicular to `axis`; for universal joints.
    pub second_axis: Option<[f64; 3]>,
    /// Minimum and maximum angle of each axis: one pair for a revolute joint, two for a universal joint. A
    /// spherical joint has one pair `[0, most]`, which limits the angle from its zero pose. Empty without limit.
    pub range_rad: Vec<[f64; 2]>,
    /// Minimum and maximum position of a prismatic joint, m.
    pub range_m: Option<[f64; 2]>,
    /// Home position of a revolute joint, rad. Default: zero, or the end of the range that is nearest to zero.
    pub home_rad: Option<f64>,
    /// Home position of a prismatic joint, m. Default as for `home_rad`.
    pub home_m: Option<f64>,
    /// Maximum commanded speed of a joint that turns, rad/s. Default: the limit from its servos' speed, if they have
    /// one.
    pub speed_rad_s: Option<f64>,
    /// Maximum commanded speed of a joint that slides, m/s. Default as for `speed_rad_s`.
    pub speed_m_s: Option<f64>,
    /// Maximum commanded acceleration of a joint that turns, rad/s². Default: no limit.
    pub acceleration_rad_s2: Option<f64>,
    /// Maximum commanded acceleration of a joint that slides, m/s². Default: no limit.
    pub acceleration_m_s2: Option<f64>,
    /// Maximum commanded torque (N m) or force (N). Default: the limit from its servos' effort, if they have one.
    pub effort: Option<f64>,
    /// Inertia that the drive's rotor adds to each dof, seen through its gear: kg m², or kg for a slide. Default:
    /// that of the servos that move the joint.
    pub rotor_inertia: Option<f64>,
    /// Coulomb friction in addition to that of the servos: N m, or N for a slide.
    pub friction: f64,
    /// Viscous friction in addition to that of the servos: N m s, or N s/m for a slide.
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
    /// Returns the home pose as coordinates `q` of `sinew-core`. The default of a turn or a slide is zero, or the
    /// end of the range that is nearest to zero.
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
/// For example, two lids that must not overlap: `1 · upper - 1 · lower >= 0`. The sum is in the unit of the first
/// joint. If one joint turns and the other slides, the second factor is in rad/m or m/rad.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkedLimit {
    /// Name of the first joint, of one dof.
    pub joint: String,
    /// Name of the second joint, of one dof.
    pub other: String,
    /// Factor of the first joint. Default: 1.
    pub factor: f64,
    /// Factor of the second joint. Default: -1.
    pub other_factor: f64,
    /// Minimum sum, if the first joint turns.
    pub least_rad: Option<f64>,
    /// Maximum sum, if the first joint turns.
    pub most_rad: Option<f64>,
    /// Minimum sum, if the first joint slides, m.
    pub least_m: Option<f64>,
    /// Maximum sum, if the first joint slides, m.
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
