//! Mechanisms for tests.

use glam::{DMat3, DQuat, DVec3};
use sinew_host_util::random::{Random, Subject};

use super::{Drive, JointModel, Link, Mechanism, MovingPose, Pose, link};
use crate::plant::MassProperties;

pub(super) fn solid(
    mass_kg: f64,
    center_of_mass_m: DVec3,
    rotational_kg_m2: DMat3,
) -> MassProperties {
    MassProperties { mass_kg, center_of_mass_m, rotational_kg_m2 }
}

pub(super) fn at_rest(position_m: DVec3, rotation: DQuat) -> MovingPose {
    MovingPose {
        pose: Pose { rotation, position_m },
        angular_rad_s: DVec3::ZERO,
        linear_m_s: DVec3::ZERO,
    }
}

pub(super) fn diagonal(x: f64, y: f64, z: f64) -> DMat3 {
    DMat3::from_diagonal(DVec3::new(x, y, z))
}

/// Returns `R D Rᵀ`.
pub(super) fn tilted(moments: DMat3, rotation_vector: DVec3) -> DMat3 {
    let axes = DMat3::from_quat(DQuat::from_scaled_axis(rotation_vector));
    axes * moments * axes.transpose()
}

/// Returns a body attached to a bolted body, with its joint at the world's origin.
pub(super) fn hung(mass: MassProperties) -> Mechanism {
    let block = solid(1.0, DVec3::ZERO, DMat3::IDENTITY);
    Mechanism {
        bodies: vec![
            link(None, JointModel::Fixed, DVec3::ZERO, &block),
            link(Some(0), JointModel::Spherical, DVec3::ZERO, &mass),
        ],
        linked: Vec::new(),
    }
}

/// Returns a drive without force and torque.
pub(super) fn passive(bodies: usize) -> Drive {
    Drive::none(bodies)
}

/// Returns a random tree of 18 bodies of 0.5 to 5 kg on ball joints. They turn relative to each other with random
/// velocities of up to 2 rad/s about each axis; the root is free or fixed.
pub(super) fn random_tree(root: JointModel, seed: u64) -> (Mechanism, Vec<MovingPose>) {
    let mut random = Random::new(seed, Subject::Masses);
    let mut vector = |size: f64| DVec3::from_array([(); 3].map(|()| random.between(-size, size)));
    let mut bodies: Vec<Link> = Vec::new();
    let mut start: Vec<MovingPose> = Vec::new();
    for index in 0..18 {
        // Chains and forks: the parent is the previous body or an earlier body.
        let parent = (index > 0).then(|| index - 1 - (index * index) % index.min(4));
        let mass_kg = 2.75 + vector(2.25).x;
        // Half-axes of a box of that mass.
        let box_m = vector(0.1).abs() + 0.05;
        let moments = mass_kg / 3.0 * (DVec3::splat(box_m.length_squared()) - box_m * box_m);
        let mass = solid(mass_kg, vector(0.15), tilted(DMat3::from_diagonal(moments), vector(3.0)));
        let offset_m = vector(0.3);
        let (turn, spin) = (DQuat::from_scaled_axis(vector(1.5)), vector(2.0));
        start.push(match parent.map(|parent: usize| start[parent]) {
            None => MovingPose { angular_rad_s: spin, ..at_rest(vector(1.0), turn) },
            Some(parent) => {
                let arm = parent.pose.rotation * offset_m;
                MovingPose {
                    pose: parent.pose.child(offset_m, turn),
                    angular_rad_s: parent.angular_rad_s + spin,
                    linear_m_s: parent.linear_m_s + parent.angular_rad_s.cross(arm),
                }
            }
        });
        let joint = if parent.is_some() { JointModel::Spherical } else { root };
        bodies.push(link(parent, joint, offset_m, &mass));
    }
    if root == JointModel::Fixed {
        // Velocities relative to the root, which then does not move.
        let root = start[0];
        for body in &mut start {
            let arm = body.pose.position_m - root.pose.position_m;
            body.linear_m_s -= root.linear_m_s + root.angular_rad_s.cross(arm);
            body.angular_rad_s -= root.angular_rad_s;
        }
    }
    (Mechanism { bodies, linked: Vec::new() }, start)
}

/// Returns random torques of up to 0.5 N m about each axis of each joint, and none on the root.
pub(super) fn random_torques(seed: u64) -> Drive {
    let mut random = Random::new(seed, Subject::Noise);
    let mut drive = passive(18);
    for torque in &mut drive.torque_nm[1..] {
        *torque = DVec3::from_array([(); 3].map(|()| random.between(-0.5, 0.5)));
    }
    drive
}

/// Returns the tree of [`random_tree`] with joints of all kinds, rotated in their parents and with random
/// velocities.
pub(super) fn random_tree_of_all_kinds(seed: u64) -> (Mechanism, Vec<MovingPose>) {
    let (mut mechanism, balls) = random_tree(JointModel::Free, seed);
    let mut random = Random::new(seed, Subject::Dimensions);
    let mut vector = |size: f64| DVec3::from_array([(); 3].map(|()| random.between(-size, size)));
    let mut start: Vec<MovingPose> = Vec::new();
    for (index, (link, ball)) in mechanism.bodies.iter_mut().zip(&balls).enumerate() {
        let Some(parent) = link.parent.map(|parent| start[parent]) else {
            start.push(*ball);
            continue;
        };
        let axis = vector(1.0).normalize();
        let second = axis.any_orthonormal_vector();
        link.joint = match index % 6 {
            0 => JointModel::Fixed,
            1 => JointModel::Revolute(axis),
            2 => JointModel::Prismatic(axis),
            3 => JointModel::Universal([axis, second]),
            4 => JointModel::Spherical,
            _ => JointModel::Free,
        };
        link.rotation = DQuat::from_scaled_axis(vector(1.5));
        let (along, speeds) = (vector(1.0), vector(2.0));
        let mut in_joint = link.joint.motion(&[along.x, 0.3 * along.y]);
        // Angular velocity and velocity relative to the joint frame.
        let (spin, slide) = match link.joint {
            JointModel::Fixed => (DVec3::ZERO, DVec3::ZERO),
            JointModel::Revolute(axis) => (axis * speeds.x, DVec3::ZERO),
            JointModel::Prismatic(axis) => (DVec3::ZERO, axis * speeds.x),
            JointModel::Universal([first, second]) => {
                let turned = DQuat::from_axis_angle(first, along.x) * second;
                (first * speeds.x + turned * speeds.y, DVec3::ZERO)
            }
            JointModel::Spherical => {
                in_joint.rotation = DQuat::from_scaled_axis(along);
                (speeds, DVec3::ZERO)
            }
            JointModel::Free => {
                in_joint =
                    Pose { rotation: DQuat::from_scaled_axis(along), position_m: 0.2 * along };
                (speeds, vector(1.0))
            }
        };
        let joint = parent.pose.child(link.position_m, link.rotation);
        let pose = joint.child(in_joint.position_m, in_joint.rotation);
        let arm_m = pose.position_m - parent.pose.position_m;
        start.push(MovingPose {
            pose,
            angular_rad_s: parent.angular_rad_s + joint.rotation * spin,
            linear_m_s: parent.linear_m_s
                + parent.angular_rad_s.cross(arm_m)
                + joint.rotation * slide,
        });
    }
    (mechanism, start)
}
