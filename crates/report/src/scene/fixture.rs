//! A rig for tests.

use glam::{DMat3, DVec3};
use sinew_rig::mechanism::{JointModel, Link, Mechanism};

/// Returns an upright arm with six joints: links of 0.1 m, the hand 0.08 m.
pub(crate) fn arm() -> Mechanism {
    let joints = [
        JointModel::Fixed,
        JointModel::Revolute(DVec3::Y),
        JointModel::Revolute(DVec3::X),
        JointModel::Revolute(DVec3::X),
        JointModel::Revolute(DVec3::Y),
        JointModel::Revolute(DVec3::X),
        JointModel::Revolute(DVec3::Y),
    ];
    let link = |(body, joint): (usize, JointModel)| {
        let parent = body.checked_sub(1);
        let up = if parent.is_some() { DVec3::Y * 0.1 } else { DVec3::ZERO };
        Link {
            name: format!("body_{body}"),
            joint_name: format!("joint_{body}"),
            mass_kg: 0.2,
            center_of_mass_m: DVec3::Y * if body == 6 { 0.04 } else { 0.05 },
            inertia_kg_m2: DMat3::from_diagonal(DVec3::splat(2e-4)),
            ranges: if parent.is_some() { vec![[-1.0, 1.0]] } else { Vec::new() },
            ..Link::on(parent, joint, up)
        }
    };
    Mechanism { bodies: joints.into_iter().enumerate().map(link).collect(), linked: Vec::new() }
}
