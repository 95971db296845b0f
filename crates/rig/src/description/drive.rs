//! Drives: the relations between servos and joints.

use super::{Joint, JointType};

/// A relation by which servos move joints. Each dof and each servo belongs to at most one drive.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drive {
    /// Names of the joints; all dofs of each joint belong to the drive, in their order.
    pub joints: Vec<String>,
    /// Names of the servos.
    pub servos: Vec<String>,
    /// Kind of the relation, with its numbers.
    pub kind: DriveKind,
}

/// Kind of a drive. Servo positions `s` are those of the output shafts, after direction and offset, rad.
#[derive(Debug, Clone, PartialEq)]
pub enum DriveKind {
    /// `q = matrix · s + offset`: one row for each dof, one column for each servo, of full rank. One servo on one
    /// joint is `[[1]]`; two that face each other on one joint are `[[0.5, -0.5]]`; a mimic joint is `[[1],
    /// [0.5]]`; a differential pair is `[[0.5, 0.5], [0.5, -0.5]]`. For a spherical joint `q` is the rotation
    /// vector.
    Matrix {
        /// Rows of the matrix, rad/rad, or m/rad for slides.
        rows: Vec<Vec<f64>>,
        /// One offset for each row, rad or m. Default: zeros.
        offset: Vec<f64>,
    },
    /// A monotone curve through points `[s, q]`, in rad, or rad and m. It is used for jaws, lids and push-rods.
    Curve {
        /// At least two points; `s` rises, `q` strictly rises or strictly falls.
        points: Vec<[f64; 2]>,
    },
    /// A four-bar linkage: the servo turns the crank, the joint is the rocker.
    FourBar {
        /// Distance from the servo's axis to the joint's axis, m.
        ground_m: f64,
        /// Length of the servo's horn, m.
        crank_m: f64,
        /// Length of the rod, m.
        coupler_m: f64,
        /// Length of the lever on the joint, m.
        rocker_m: f64,
        /// Crank angle at servo position zero, from the line between the axes, rad.
        crank_zero_rad: f64,
        /// Rocker angle at joint position zero, rad.
        rocker_zero_rad: f64,
        /// Whether crank and rocker are on opposite sides of the line between the axes.
        crossed: bool,
    },
}

impl DriveKind {
    /// Returns the default of the file: each servo moves one dof, in their order.
    pub fn one_to_one(count: usize) -> Self {
        let row =
            |turned: usize| (0..count).map(|servo| f64::from(u8::from(servo == turned))).collect();
        Self::Matrix { rows: (0..count).map(row).collect(), offset: Vec::new() }
    }
}

/// A drive without servos and joints.
impl Default for DriveKind {
    fn default() -> Self {
        Self::one_to_one(0)
    }
}

/// Names of those keys of a drive that depend on the unit of its joints.
pub(crate) struct UnitKeys {
    /// Key of a matrix's offsets, in degrees or metres.
    pub(crate) offset: &'static str,
    /// Key of a curve's points, pairs of a servo position and a joint position: both in degrees, or the servo's in
    /// degrees and the joint's in metres.
    pub(crate) points: &'static str,
}

impl UnitKeys {
    /// Selects the keys: metres if all joints slide, otherwise degrees.
    pub(crate) fn of<'a>(joints: impl IntoIterator<Item = &'a Joint>) -> Self {
        let mut joints = joints.into_iter().peekable();
        if joints.peek().is_some() && joints.all(|joint| joint.kind == JointType::Prismatic) {
            Self { offset: "offset_m", points: "points_deg_m" }
        } else {
            Self { offset: "offset_deg", points: "points_deg" }
        }
    }
}
