//! The crate `featherstone`. It uses f32, and has spherical and floating joints. Its only inverse dynamics allocates
//! its result and scratch in each call, so the allocation is timed, too.

use std::hint::black_box;

use featherstone::prelude::{
    ArticulatedBody, GenJoint, SpatialInertia, SpatialTransform, rnea_inverse_dynamics,
};
use sinew_core::glam::{DQuat, DVec3, Vec3};
use sinew_core::{Body, JointKind};

use crate::motion::{RigMotion, single, together, torques};
use crate::{Contender, GRAVITY_M_S2};

pub(crate) struct Featherstone {
    rig: ArticulatedBody,
    torques: Vec<f32>,
}

impl Featherstone {
    pub(crate) fn new(bodies: &[Body]) -> Result<Self, Box<dyn std::error::Error>> {
        let mut rig = ArticulatedBody::new();
        rig.set_gravity(GRAVITY_M_S2.to_array().into());
        for (index, body) in bodies.iter().enumerate() {
            let joint = match body.joint {
                JointKind::Free => GenJoint::Floating,
                JointKind::Spherical => GenJoint::Spherical,
                JointKind::Revolute { axis } => GenJoint::Revolute { axis: axis.to_array().into() },
                other => return Err(format!("no {other:?} in this bench").into()),
            };
            let about = &body.inertia.rotational_kg_m2;
            let inertia = SpatialInertia::from_mass_inertia(
                body.inertia.mass_kg,
                body.inertia.center_of_mass_m.to_array().into(),
                [
                    [about.xx, about.xy, about.xz],
                    [about.xy, about.yy, about.yz],
                    [about.xz, about.yz, about.zz],
                ]
                .into(),
            );
            // The crate's transforms convert from the parent's axes to the child's, with the offset in the child's
            // axes.
            let back = body.placement.rotation.conjugate();
            let columns = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| (back * axis).to_array());
            let placement = SpatialTransform::from_rotation_translation(
                columns.into(),
                (back * body.placement.translation_m).to_array().into(),
            );
            let parent = body.parent.map_or(Ok(-1), i32::try_from)?;
            rig.add_body(format!("b{index}"), parent, joint, inertia, placement);
        }
        let torques = vec![0.0; rig.dof_count()];
        Ok(Self { rig, torques })
    }
}

impl Contender for Featherstone {
    fn name(&self) -> &'static str {
        "featherstone 0.1"
    }

    fn set(&mut self, motion: &RigMotion) {
        let root = &motion.root;
        let to_body = root.rotation.conjugate();
        let in_body = |v: DVec3| to_body * v;
        let (spin, speed) = (in_body(root.angular_velocity), in_body(root.linear_velocity));
        // The spatial acceleration is the classical acceleration minus the part that the turning axes cause.
        let linear = in_body(root.linear_acceleration) - spin.cross(speed);
        let angular = in_body(root.angular_acceleration);
        let mut position = root.translation_m.as_vec3().to_array().to_vec();
        position.extend(from_parent(root.rotation));
        let mut rates: Vec<f32> = numbers([speed, spin]).collect();
        let mut accelerations: Vec<f32> = numbers([linear, angular]).collect();
        for turns in &motion.turns {
            if let [turn] = turns.as_slice() {
                // The conversion from the parent's axes to the child's is a turn about the same axis with the
                // opposite sign.
                position.push(-single(turn.angle_rad));
                rates.push(single(turn.velocity_rad_s));
                accelerations.push(single(turn.acceleration_rad_s2));
            } else {
                let turned = together(turns);
                position.extend(from_parent(turned.rotation));
                rates.extend(numbers([turned.velocity]));
                accelerations.extend(numbers([turned.acceleration]));
            }
        }
        self.rig.q.copy_from_slice(&position);
        self.rig.qd.copy_from_slice(&rates);
        self.rig.qdd.copy_from_slice(&accelerations);
    }

    fn run(&mut self) {
        let (torques, scratch) = rnea_inverse_dynamics(black_box(&self.rig));
        black_box(&scratch);
        self.torques.copy_from_slice(black_box(&torques).as_slice());
    }

    fn torques(&self, motion: &RigMotion) -> Vec<f64> {
        let to_world = motion.root.rotation;
        let vector = |at: usize| Vec3::from_slice(&self.torques[at..at + 3]).as_dvec3();
        let mut all = Vec::new();
        all.extend((to_world * vector(3)).to_array());
        all.extend((to_world * vector(0)).to_array());
        let mut at = 6;
        for turns in &motion.turns {
            if turns.len() == 1 {
                all.push(f64::from(self.torques[at]));
                at += 1;
            } else {
                all.extend(torques(turns, vector(at)));
                at += 3;
            }
        }
        all
    }
}

/// Converts a rotation to its quaternion, w first, from the parent's axes to the child's.
fn from_parent(rotation: DQuat) -> [f32; 4] {
    let back = rotation.conjugate().as_quat();
    [back.w, back.x, back.y, back.z]
}

fn numbers<const K: usize>(vectors: [DVec3; K]) -> impl Iterator<Item = f32> {
    vectors.into_iter().flat_map(|v| v.as_vec3().to_array())
}
