//! Bodies and joints of a rig by index: a tree in regular numbering, in f64, with fixed joints merged.

mod inverse_dynamics;
mod joint_model;
mod kinematics;
mod pose;
mod ties;

use glam::{DMat3, DQuat, DVec3};
use sinew_core::{Inertia, RotationalInertia, Transform, Tree, TreeError};

use crate::description::BodyShape;
use crate::number::single;

pub use inverse_dynamics::{InverseDynamics, LANES};
pub use joint_model::JointModel;
pub use pose::Pose;
pub use ties::{Tie, Ties};

/// Maximum number of bodies of a rig after merging. A tree of `sinew-core` may have more:
/// [`sinew_core::BodySet::CAPACITY`].
pub const BODY_COUNT_MAX: usize = 128;

/// Acceleration of gravity, m/s², in world axes; equal to that of `sinew-core`, in f64.
pub const GRAVITY_M_S2: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// Bodies of a rig in regular numbering, depth first in the order of the file. Body 0 is the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Mechanism {
    /// Bodies with their joints; parents before children.
    pub bodies: Vec<Link>,
    /// Limits that join two joints.
    pub linked: Vec<LinkedRange>,
}

/// A limit that joins two joints of one axis: `factor · q + other_factor · q_other` stays in a range. A range with
/// equal ends ties one joint to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkedRange {
    /// Index of the body that the first joint moves.
    pub body: usize,
    /// Index of the body that the second joint moves.
    pub other: usize,
    /// Factor of the first joint, not zero.
    pub factor: f64,
    /// Factor of the second joint.
    pub other_factor: f64,
    /// Minimum and maximum sum, rad or m; infinite without limit.
    pub range: [f64; 2],
}

/// A body and the joint that moves it.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name of the body.
    pub name: String,
    /// Name of the joint; for the base, name of the body.
    pub joint_name: String,
    /// Index of the parent body; `None` for the base, whose parent is the world.
    pub parent: Option<usize>,
    /// Kind of motion that the joint permits. For the base, [`JointModel::Fixed`], or [`JointModel::Free`] if it is
    /// driven.
    pub joint: JointModel,
    /// Position of the joint in the parent's frame, m.
    pub position_m: DVec3,
    /// Rotation of the joint frame in the parent's frame, unit quaternion.
    pub rotation: DQuat,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass in the body frame, m.
    pub center_of_mass_m: DVec3,
    /// Inertia about the centre of mass, in body axes, kg m².
    pub inertia_kg_m2: DMat3,
    /// Bodies that are merged into this body; its mass and inertia include them.
    pub merged: Vec<MergedBody>,
    /// Inertia that rotors add to each dof, kg m² (kg for a slide).
    pub rotor_inertia: f64,
    /// Coulomb friction of each dof, N m or N.
    pub friction: f64,
    /// Viscous friction of each dof, N m s or N s/m.
    pub damping: f64,
    /// Minimum and maximum position of each axis, rad or m; empty without limit. A spherical joint has one pair
    /// `[0, most]`.
    pub ranges: Vec<[f64; 2]>,
    /// Home pose, as coordinates `q` of `sinew-core`.
    pub home: Vec<f64>,
    /// Maximum commanded speed, rad/s or m/s; infinite without limit.
    pub speed: f64,
    /// Maximum commanded acceleration, rad/s² or m/s²; infinite without limit.
    pub acceleration: f64,
    /// Maximum effort, N m or N; infinite without limit.
    pub effort: f64,
    /// Solids that are drawn for this body and for the merged bodies, in this body's frame. The compact form of
    /// boards does not have them.
    pub shapes: Vec<BodyShape>,
}

/// A body that is merged into a [`Link`], because a fixed joint holds it there: for example a bracket, or a tool's
/// frame.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedBody {
    /// Name of the body in the description.
    pub name: String,
    /// Position of its frame in the link's frame, m.
    pub position_m: DVec3,
    /// Rotation of its frame in the link's frame, unit quaternion.
    pub rotation: DQuat,
}

impl Mechanism {
    /// Returns the tree for `sinew-core`, in f32. O(n · depth).
    ///
    /// # Errors
    /// [`TreeError`] if there are more than `N` bodies, or a number is invalid in f32.
    pub fn tree<const N: usize>(&self) -> Result<Tree<N>, TreeError> {
        let mut tree = Tree::new();
        for link in &self.bodies {
            tree.push(sinew_core::Body {
                parent: link.parent,
                joint: link.joint.kind(),
                placement: Transform::new(
                    link.rotation.as_quat().normalize(),
                    link.position_m.as_vec3(),
                ),
                inertia: link.inertia(),
                rotor_inertia: single(link.rotor_inertia),
            })?;
        }
        Ok(tree)
    }

    /// Returns the names of the dofs in the order of `qd` and of efforts: the joint's name if it has one dof,
    /// otherwise `NAME.0`, `NAME.1`, ...
    pub fn dof_names(&self) -> Vec<String> {
        let of_link = |link: &Link| {
            let count = link.joint.kind().dof_count();
            let name = link.joint_name.clone();
            (0..count).map(move |k| if count == 1 { name.clone() } else { format!("{name}.{k}") })
        };
        self.bodies.iter().flat_map(of_link).collect()
    }

    /// Returns the home pose as coordinates `q` of `sinew-core`.
    pub fn home(&self) -> Vec<f64> {
        self.bodies.iter().flat_map(|link| link.home.iter().copied()).collect()
    }
}

impl Link {
    /// Creates a body without name and mass, on a joint whose axes are parallel to its parent's. The joint has no
    /// range, limit, friction or rotor, and its home is its zero pose.
    pub fn on(parent: Option<usize>, joint: JointModel, position_m: DVec3) -> Self {
        Self {
            name: String::new(),
            joint_name: String::new(),
            parent,
            joint,
            position_m,
            rotation: DQuat::IDENTITY,
            mass_kg: 0.0,
            center_of_mass_m: DVec3::ZERO,
            inertia_kg_m2: DMat3::ZERO,
            merged: Vec::new(),
            rotor_inertia: 0.0,
            friction: 0.0,
            damping: 0.0,
            ranges: Vec::new(),
            home: joint.zero(),
            speed: f64::INFINITY,
            acceleration: f64::INFINITY,
            effort: f64::INFINITY,
            shapes: Vec::new(),
        }
    }

    fn inertia(&self) -> Inertia {
        let m = self.inertia_kg_m2.as_mat3();
        Inertia {
            mass_kg: single(self.mass_kg),
            center_of_mass_m: self.center_of_mass_m.as_vec3(),
            rotational_kg_m2: RotationalInertia {
                xx: m.x_axis.x,
                xy: m.y_axis.x,
                xz: m.z_axis.x,
                yy: m.y_axis.y,
                yz: m.z_axis.y,
                zz: m.z_axis.z,
            },
        }
    }
}
