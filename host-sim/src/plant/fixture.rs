//! Mechanisms for tests.

use glam::{DMat3, DQuat, DVec3};

use super::{Drive, Mechanism, MovingPose, PlantBody, Pose, Root};
use crate::figure::MassProperties;
use crate::random::{Random, Subject};

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

/// `R D Rᵀ`.
pub(super) fn tilted(moments: DMat3, rotation_vector: DVec3) -> DMat3 {
    let axes = DMat3::from_quat(DQuat::from_scaled_axis(rotation_vector));
    axes * moments * axes.transpose()
}

/// A body on a bolted one, its joint at the world's origin.
pub(super) fn hung(mass: MassProperties) -> Mechanism {
    let block = solid(1.0, DVec3::ZERO, DMat3::IDENTITY);
    Mechanism {
        root: Root::Fixed,
        bodies: vec![
            PlantBody { parent: None, offset_m: DVec3::ZERO, mass: block },
            PlantBody { parent: Some(0), offset_m: DVec3::ZERO, mass },
        ],
    }
}

/// No force, no torque.
pub(super) fn passive(bodies: usize) -> Drive {
    Drive { root_force_n: DVec3::ZERO, torque_nm: vec![DVec3::ZERO; bodies] }
}

/// A random tree of 18 bodies of 0.5 to 5 kg, turning at random against each other at up to 5 rad/s.
pub(super) fn random_tree(root: Root, seed: u64) -> (Mechanism, Vec<MovingPose>) {
    let mut random = Random::new(seed, Subject::Masses);
    let mut vector = |size: f64| DVec3::from_array([(); 3].map(|()| random.between(-size, size)));
    let mut bodies: Vec<PlantBody> = Vec::new();
    let mut start: Vec<MovingPose> = Vec::new();
    for index in 0..18 {
        // Chains and forks: on the body before or one farther back.
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
        bodies.push(PlantBody { parent, offset_m, mass });
    }
    if root == Root::Fixed {
        // Seen from the root, which then does not move.
        let root = start[0];
        for body in &mut start {
            let arm = body.pose.position_m - root.pose.position_m;
            body.linear_m_s -= root.linear_m_s + root.angular_rad_s.cross(arm);
            body.angular_rad_s -= root.angular_rad_s;
        }
    }
    (Mechanism { root, bodies }, start)
}

/// Torques of up to 0.5 N m on all joints, none on the root.
pub(super) fn random_torques(seed: u64) -> Drive {
    let mut random = Random::new(seed, Subject::Noise);
    let mut drive = passive(18);
    for torque in &mut drive.torque_nm[1..] {
        *torque = DVec3::from_array([(); 3].map(|()| random.between(-0.5, 0.5)));
    }
    drive
}
