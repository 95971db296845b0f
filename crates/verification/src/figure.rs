//! Converts the rigs of golden files to trees of the core.

use glam::{DMat3, DQuat, DVec3};
use serde::Deserialize;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::{Body, Inertia, JointKind, JointState, RotationalInertia, Transform};
use sinew_figure::plant::MassProperties;

use super::error::CaseError;
use super::golden::{Rotation, Scalar, Vector, expect_count};
use super::rounding::{self, Joint, Link, Motion, Number};

/// Tree with the core's largest capacity. Golden trees have up to 32 bodies.
pub(super) type Tree = sinew_core::Tree<128>;

/// The connection of body 0 to the world.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Root {
    Free,
    Spherical,
    Welded,
}

/// A body as in `rnea` and `control` files.
#[derive(Deserialize)]
pub(super) struct GoldenBody {
    pub(super) parent: i64,
    pub(super) offset: Vector,
    pub(super) rot: Rotation,
    mass: Scalar,
    com: Vector,
    inertia: [Scalar; 6],
}

impl GoldenBody {
    /// Returns the pose of the joint frame in the parent's body frame.
    pub(super) fn placement(&self) -> Transform {
        Transform::new(self.rot.rounded(), self.offset.rounded())
    }

    /// Returns the mass properties unrounded, in f64.
    pub(super) fn mass_properties(&self) -> MassProperties {
        let [xx, xy, xz, yy, yz, zz] = self.inertia.map(|element| element.0);
        MassProperties {
            mass_kg: self.mass.0,
            center_of_mass_m: self.com.0,
            rotational_kg_m2: DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]),
        }
    }
}

/// Returns the bodies of a golden tree with their rounding. The joints are those of the core's tree.
pub(super) fn links(tree: &Tree, bodies: &[GoldenBody]) -> Vec<Link> {
    let link = |(body, of_tree): (&GoldenBody, &Body)| Link {
        parent: of_tree.parent,
        joint: of_tree.joint,
        mass: Number::given(body.mass.0),
        center: rounding::Vector::given(body.com.0),
        inertia: rounding::symmetric(body.inertia.map(|element| Number::given(element.0))),
        rotor: Number::ZERO,
        placement: rounding::Rotation::given(body.rot.0),
    };
    bodies.iter().zip(tree.bodies()).map(link).collect()
}

/// Returns the joint of a golden body with its rounding, corresponding to [`joint_state`].
pub(super) fn joint(
    link: &Link,
    offset: rounding::Vector,
    rotation: DQuat,
    position_m: DVec3,
    omega_rad_s: DVec3,
    velocity_m_s: DVec3,
) -> Joint {
    let given = rounding::Vector::given;
    let turns = !matches!(link.joint, JointKind::Fixed);
    let turn = if turns { rotation } else { DQuat::IDENTITY };
    let arm = link.placement.turn(given(if link.joint == JointKind::Free {
        position_m
    } else {
        DVec3::ZERO
    }));
    let velocity = match link.joint {
        JointKind::Fixed => Motion::ZERO,
        JointKind::Free => Motion { angular: given(omega_rad_s), linear: given(velocity_m_s) },
        _ => Motion { angular: given(omega_rad_s), ..Motion::ZERO },
    };
    Joint {
        rotation: link.placement.after(rounding::Rotation::given(turn)),
        arm: arm + offset,
        velocity,
    }
}

/// Converts a parent index; -1 is the world.
pub(super) fn parent(index: i64, field: &str) -> Result<Option<usize>, CaseError> {
    match index {
        -1 => Ok(None),
        _ => usize::try_from(index)
            .map(Some)
            .map_err(|_| CaseError::new(field, format!("{index} is no body; -1 is the world"))),
    }
}

/// Refuses a rig without bodies.
pub(super) fn expect_bodies(n: usize) -> Result<(), CaseError> {
    if n == 0 { Err(CaseError::new("n", "no bodies; expected one or more")) } else { Ok(()) }
}

/// Returns the tree of `rnea` and `control` cases. `root` selects the joint of body 0; all other joints are spherical.
pub(super) fn tree(n: usize, root: Root, bodies: &[GoldenBody]) -> Result<Tree, CaseError> {
    expect_count("bodies", bodies.len(), n)?;
    expect_bodies(n)?;
    let mut tree = Tree::new();
    for (index, body) in bodies.iter().enumerate() {
        let field = format!("bodies[{index}]");
        let joint = match root {
            Root::Free if index == 0 => JointKind::Free,
            Root::Welded if index == 0 => JointKind::Fixed,
            _ => JointKind::Spherical,
        };
        let [xx, xy, xz, yy, yz, zz] = body.inertia.map(Scalar::rounded);
        tree.push(Body {
            parent: parent(body.parent, &field)?,
            joint,
            placement: body.placement(),
            inertia: Inertia {
                mass_kg: body.mass.rounded(),
                center_of_mass_m: body.com.rounded(),
                rotational_kg_m2: RotationalInertia { xx, xy, xz, yy, yz, zz },
            },
            rotor_inertia: 0.0,
        })
        .map_err(|error| CaseError::new(field, error))?;
    }
    Ok(tree)
}

/// Returns the state of a golden joint. Components that are not dofs of the joint are ignored, as in the files.
pub(super) fn joint_state(
    joint: JointKind,
    placement: Transform,
    rotation: Quat,
    position_m: Vec3,
    omega_rad_s: Vec3,
    velocity_m_s: Vec3,
) -> Result<JointState, CaseError> {
    let position = [rotation.to_array().as_slice(), &position_m.to_array()].concat();
    let speed = [omega_rad_s.to_array(), velocity_m_s.to_array()].concat();
    let (position_count, speed_count) = (joint.coordinate_count(), joint.dof_count());
    joint
        .state(placement, &position[..position_count], &speed[..speed_count])
        .map_err(|error| CaseError::new("quat", error))
}
