//! Drives: how servos move joints.

use super::{Joint, JointType};

/// How some servos move some joints. A joint's dofs, and a servo, belong to one drive at most.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drive {
    /// The joints, each with all its dofs in their order.
    pub joints: Vec<String>,
    /// The servos.
    pub servos: Vec<String>,
    /// How.
    pub kind: DriveKind,
}

/// The kinds of drive. Servo positions `s` are those of the output shafts, after direction and offset, rad.
#[derive(Debug, Clone, PartialEq)]
pub enum DriveKind {
    /// `q = matrix · s + offset`, a row a dof, a column a servo; of full rank. One servo on one joint is `[[1]]`,
    /// two that face each other on one joint are `[[0.5, -0.5]]`, a mimic joint is `[[1], [0.5]]`, a differential pair
    /// is `[[0.5, 0.5], [0.5, -0.5]]`. Of a spherical joint `q` is the rotation vector.
    Matrix {
        /// Rows of numbers: rad/rad, or m/rad for slides.
        rows: Vec<Vec<f64>>,
        /// One number a row, rad or m. Default: zeros.
        offset: Vec<f64>,
    },
    /// A monotone curve through points `[s, q]`, rad, or rad and m: jaws, lids, push-rods.
    Curve {
        /// At least two, `s` rising, `q` strictly rising or falling.
        points: Vec<[f64; 2]>,
    },
    /// A four-bar linkage: the servo turns the crank, the joint is the rocker.
    FourBar {
        /// From the servo's axis to the joint's, m.
        ground_m: f64,
        /// The servo's horn, m.
        crank_m: f64,
        /// The rod, m.
        coupler_m: f64,
        /// The lever on the joint, m.
        rocker_m: f64,
        /// Crank angle where the servo is at zero, from the line of the ground, rad.
        crank_zero_rad: f64,
        /// Rocker angle where the joint is at zero, rad.
        rocker_zero_rad: f64,
        /// Whether crank and rocker lie on opposite sides of the ground.
        crossed: bool,
    },
}

impl DriveKind {
    /// Each of some servos moves one degree of freedom, in their order: the default of the file.
    pub fn one_to_one(count: usize) -> Self {
        let row =
            |turned: usize| (0..count).map(|servo| f64::from(u8::from(servo == turned))).collect();
        Self::Matrix { rows: (0..count).map(row).collect(), offset: Vec::new() }
    }
}

/// No servo, no joint.
impl Default for DriveKind {
    fn default() -> Self {
        Self::one_to_one(0)
    }
}

/// The keys of a drive whose unit is that of its joints.
pub(crate) struct UnitKeys {
    /// Of a matrix: degrees, or metres.
    pub(crate) offset: &'static str,
    /// Of a curve: degrees of servo and joint, or degrees of the servo and metres of the joint.
    pub(crate) points: &'static str,
}

impl UnitKeys {
    /// Metres if all joints slide.
    pub(crate) fn of<'a>(joints: impl IntoIterator<Item = &'a Joint>) -> Self {
        let mut joints = joints.into_iter().peekable();
        if joints.peek().is_some() && joints.all(|joint| joint.kind == JointType::Prismatic) {
            Self { offset: "offset_m", points: "points_deg_m" }
        } else {
            Self { offset: "offset_deg", points: "points_deg" }
        }
    }
}
