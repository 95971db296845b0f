//! The rig that performs an evaluated motion.

use glam::DVec3;
use sinew_core::{Transform, Tree, TreeError};
use sinew_figure::plant::Pose;
use sinew_rig::mechanism::{JointModel, Link, Mechanism};

use super::capacity::CAPACITY;
use super::error::RunError;
use super::importance_weights::ImportanceWeights;

/// A mechanism, with its importance weights and its leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    mechanism: Mechanism,
    weights: ImportanceWeights,
    leaves: Vec<bool>,
    first_judged: usize,
}

impl Rig {
    /// Makes the rig of a mechanism. The errors of all its bodies count.
    ///
    /// # Errors
    /// [`RunError`] if there are more than [`CAPACITY`] bodies, or a value is not representable in f32.
    pub fn new(mechanism: Mechanism) -> Result<Self, RunError> {
        let weights = ImportanceWeights::new(&mechanism)?;
        Ok(Self::with_weights(mechanism, weights))
    }

    pub(crate) fn with_weights(mechanism: Mechanism, weights: ImportanceWeights) -> Self {
        let mut leaves = vec![true; mechanism.bodies.len()];
        for parent in mechanism.bodies.iter().filter_map(|link| link.parent) {
            leaves[parent] = false;
        }
        Self { mechanism, weights, leaves, first_judged: 0 }
    }

    /// Excludes the error of the base if a stand holds it: that error is zero and would only reduce the means.
    #[must_use]
    pub fn without_stand(self) -> Self {
        let stands = self.links().first().is_some_and(|base| base.joint == JointModel::Fixed);
        Self { first_judged: usize::from(stands), ..self }
    }

    /// Returns the bodies and joints of the rig.
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// Returns the bodies and their joints, parents before children.
    #[inline]
    pub fn links(&self) -> &[Link] {
        &self.mechanism.bodies
    }

    /// Returns the weights of the joints in the error of a whole pose.
    #[inline]
    pub fn importance_weights(&self) -> &ImportanceWeights {
        &self.weights
    }

    /// Returns the index of the first body whose error counts. For the paper's figure all bodies count, even if the
    /// pelvis is fixed.
    #[inline]
    pub fn first_judged(&self) -> usize {
        self.first_judged
    }

    /// Returns whether no joint is attached to a body.
    #[inline]
    pub fn is_leaf(&self, body: usize) -> bool {
        self.leaves.get(body).copied().unwrap_or_default()
    }

    /// Returns the rig as the controller knows it, in f32.
    ///
    /// # Errors
    /// [`TreeError`] if there are more than [`CAPACITY`] bodies, or a number is not representable in f32.
    pub fn tree(&self) -> Result<Tree<CAPACITY>, TreeError> {
        self.mechanism.tree()
    }

    /// Returns the gap between the two sides of a body's joint in m, from the bodies' poses in the world. A gap is
    /// a defect of the plant's constraints.
    pub fn gap_m(&self, body: usize, poses: &[Pose]) -> f64 {
        let link = &self.links()[body];
        let Some(parent) = link.parent.map(|parent| &poses[parent]) else { return 0.0 };
        match link.joint {
            JointModel::Free => 0.0,
            JointModel::Prismatic(_) => {
                let off_m = parent.to_local(poses[body].position_m)
                    - position_m(link, parent, &poses[body]);
                off_m.length()
            }
            _ => {
                let joint = parent.position_m + parent.rotation * link.position_m;
                joint.distance(poses[body].position_m)
            }
        }
    }

    /// Writes the readings of the joints' sensors to `out`, from the bodies' poses in the world: for each joint
    /// its pose in the parent's frame, for the root its pose in the world.
    ///
    /// Positions are the model's, except along slides. A plant's bodies may drift apart at the joints by
    /// millimetres. A sensor in a joint does not measure that, and a real rig's bearings do not allow it.
    pub fn joint_poses(&self, poses: &[Pose], out: &mut Vec<Transform>) {
        out.clear();
        out.extend(self.links().iter().zip(poses).map(|(link, pose)| {
            let Some(parent) = link.parent.map(|parent| &poses[parent]) else {
                return Transform::new(pose.rotation.as_quat(), pose.position_m.as_vec3());
            };
            let relative = parent.rotation.conjugate() * pose.rotation;
            Transform::new(relative.as_quat(), position_m(link, parent, pose).as_vec3())
        }));
    }
}

/// Returns the position of a joint's body in its parent's frame in m, restricted to the joint's dofs.
#[inline]
fn position_m(link: &Link, parent: &Pose, body: &Pose) -> DVec3 {
    match link.joint {
        JointModel::Prismatic(axis) => {
            let axis = link.rotation * axis;
            let off_m = parent.to_local(body.position_m) - link.position_m;
            link.position_m + axis * axis.dot(off_m)
        }
        JointModel::Free => parent.to_local(body.position_m),
        _ => link.position_m,
    }
}
