//! The bodies and joints of a rig by index: a tree in regular numbering, f64, fixed joints merged.

mod inverse_dynamics;
mod joint_model;
mod kinematics;
mod pose;

use glam::{DMat3, DQuat, DVec3};
use sinew_core::{Inertia, RotationalInertia, Transform, Tree, TreeError};

use crate::number::single;

pub use inverse_dynamics::{InverseDynamics, LANES};
pub use joint_model::JointModel;
pub use pose::Pose;

/// The most bodies of a rig, those on fixed joints not counted: what `sinew-core` holds on any machine.
pub const BODY_COUNT_MAX: usize = 128;

/// Acceleration of gravity, m/s², world axes: that of `sinew-core`, f64.
pub const GRAVITY_M_S2: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// A rig's bodies in regular numbering, depth first in the order of the file. Body 0 is the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Mechanism {
    /// Parents before children.
    pub bodies: Vec<Link>,
    /// Limits that join two joints.
    pub linked: Vec<LinkedRange>,
}

/// A limit that joins two joints of one axis: `factor · q + other_factor · q_other` stays in a range. Equal ends tie
/// the joint to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkedRange {
    /// Body of the joint.
    pub body: usize,
    /// Body of the other joint.
    pub other: usize,
    /// Factor of the joint, not zero.
    pub factor: f64,
    /// Factor of the other.
    pub other_factor: f64,
    /// Least and most of the sum, rad or m; infinite where there is no limit.
    pub range: [f64; 2],
}

/// A body and the joint that moves it.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name of the body.
    pub name: String,
    /// Name of the joint; of the base the body's.
    pub joint_name: String,
    /// Index of the parent body; `None` of the base, whose parent is the world.
    pub parent: Option<usize>,
    /// The motion that the joint leaves free. The base's is [`JointModel::Fixed`], or [`JointModel::Free`] if it is
    /// driven.
    pub joint: JointModel,
    /// Position of the joint in the parent's frame, m.
    pub position_m: DVec3,
    /// Rotation of the joint frame in the parent's frame, unit.
    pub rotation: DQuat,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass in the body frame, m.
    pub center_of_mass_m: DVec3,
    /// Inertia about the centre of mass, body axes, kg m².
    pub inertia_kg_m2: DMat3,
    /// The bodies on fixed joints that this one carries; their mass is in the numbers above.
    pub merged: Vec<MergedBody>,
    /// The inertia that rotors add to each dof: kg m², or kg of a slide.
    pub rotor_inertia: f64,
    /// Coulomb friction of each dof: N m, or N.
    pub friction: f64,
    /// Viscous friction of each dof: N m s, or N s/m.
    pub damping: f64,
    /// Least and most position of each axis, rad or m; empty if there is no limit. Of a spherical joint `[0, most]`.
    pub ranges: Vec<[f64; 2]>,
    /// Position in the home pose, as `q` of `sinew-core` has it.
    pub home: Vec<f64>,
    /// The largest speed asked for, rad/s or m/s; infinite if there is no limit.
    pub speed: f64,
    /// The largest acceleration asked for, rad/s² or m/s²; infinite if there is no limit.
    pub acceleration: f64,
    /// The largest effort, N m or N; infinite if there is no limit.
    pub effort: f64,
}

/// A body that is part of a [`Link`], since a fixed joint holds it there: a bracket, or the frame of a tool.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedBody {
    /// Its name in the description.
    pub name: String,
    /// Position of its frame in the link's, m.
    pub position_m: DVec3,
    /// Rotation of its frame in the link's, unit.
    pub rotation: DQuat,
}

impl Mechanism {
    /// The tree that `sinew-core` takes, f32. O(n · depth).
    ///
    /// # Errors
    /// [`TreeError`] if there are more than `N` bodies, or a number does not survive f32.
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

    /// Names of the degrees of freedom in the order of `qd` and of efforts: the joint's name if it has one, else
    /// `NAME.0`, `NAME.1`, ...
    pub fn dof_names(&self) -> Vec<String> {
        let of_link = |link: &Link| {
            let count = link.joint.kind().dof_count();
            let name = link.joint_name.clone();
            (0..count).map(move |k| if count == 1 { name.clone() } else { format!("{name}.{k}") })
        };
        self.bodies.iter().flat_map(of_link).collect()
    }

    /// The home pose, as `q` of `sinew-core` has it.
    pub fn home(&self) -> Vec<f64> {
        self.bodies.iter().flat_map(|link| link.home.iter().copied()).collect()
    }
}

impl Link {
    /// A body without a name and without mass, on a joint in its parent's axes that has no range, limit, friction or
    /// rotor; its home is where nothing has moved.
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
