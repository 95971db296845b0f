//! Converts two clips to one skeleton and one rate.

use glam::{DQuat, DVec3};
use sinew_core::JointKind;
use sinew_core::projection::JointRange;
use sinew_mocap::resample::resample;
use sinew_mocap::{Clip, JointSample, Skeleton, moving_root};

use crate::find::{Mismatch, same_joints};
use crate::geodesic::{JointPosition, Rig, RigError, RigJoint};
use crate::spatial::Rigid;

/// Two clips on the skeleton of the first, at its rate.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// First clip.
    pub a: Clip,
    /// Second clip, with the first clip's bones. Displacements of joints from their offsets are unchanged; the
    /// motion of the body through space is scaled by the ratio of the legs.
    pub b: Clip,
    /// Scale factor of the second clip's motion through space.
    pub scale: f64,
    /// Index of the joint that moves the body through space.
    pub(super) root: usize,
    /// Indices of the joints in the subtree of `root`, `root` first.
    pub(super) joints: Vec<usize>,
    rigid: Rigid,
    pub(super) rig: Rig,
}

/// The error of two clips that cannot be joined.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PairError {
    /// The clips have different skeletons.
    #[error(transparent)]
    Mismatch(#[from] Mismatch),
    /// The skeleton is invalid as a rig.
    #[error(transparent)]
    Rig(#[from] RigError),
}

impl Pair {
    /// Converts `b` to the skeleton of `a`, joints matched by name, and to its rate.
    ///
    /// # Errors
    /// [`PairError::Mismatch`] if the clips have different joints; [`PairError::Rig`] if bones are not finite.
    pub fn new(a: Clip, b: &Clip) -> Result<Self, PairError> {
        let order = same_joints(&a.skeleton, &b.skeleton)?;
        let of_b = resample(b, a.rate_hz());
        let (root_a, root_b) = (moving_root(&[&a]), moving_root(&[b]));
        // If either clip moves the skeleton's root, the root is the joint that moves the body in both.
        let root = if order[root_a] == root_b { root_a } else { 0 };
        let (body, joints) = a.skeleton.subtree(root);
        let (of_a, other) = (legs_m(&body), legs_m(&b.skeleton.subtree(order[root]).0));
        let scale = if of_a > 0.0 && other > 0.0 { of_a / other } else { 1.0 };
        let frame = |samples: &Vec<JointSample>| -> Vec<JointSample> {
            let joints = a.skeleton.joints.iter().zip(&order).enumerate();
            joints
                .map(|(index, (joint, place))| {
                    let JointSample { rotation, position_m } = samples[*place];
                    let position_m = if index == root {
                        position_m * scale
                    } else {
                        position_m - b.skeleton.joints[*place].offset_m + joint.offset_m
                    };
                    JointSample { rotation, position_m }
                })
                .collect()
        };
        let frames = of_b.frames.iter().map(frame).collect();
        let b = Clip { skeleton: a.skeleton.clone(), frames, ..of_b };
        let frames = a.frames.iter().chain(&b.frames);
        let poses: Vec<Vec<DQuat>> = frames.map(|frame| rotations(&joints, frame)).collect();
        let rigid = Rigid::new(&body, &poses, None);
        let rig = rig(&rigid.skeleton)?;
        Ok(Self { a, b, scale, root, joints, rigid, rig })
    }

    /// Returns the part of the skeleton on which poses are compared: the joints that move.
    pub fn body(&self) -> &Skeleton {
        &self.rigid.skeleton
    }

    /// Returns the local rotations of the body's joints in a frame.
    pub fn rotations(&self, frame: &[JointSample]) -> Vec<DQuat> {
        self.rigid.pose(&rotations(&self.joints, frame))
    }

    /// Writes the rotations of the body's joints to a frame.
    pub(super) fn put(&self, pose: &[JointPosition], frame: &mut [JointSample]) {
        let turns: Vec<DQuat> = pose
            .iter()
            .map(|state| match state {
                JointPosition::Turn(rotation) => *rotation,
                _ => DQuat::IDENTITY,
            })
            .collect();
        // The first joint is the body itself.
        for (joint, rotation) in self.rigid.joints(&turns).skip(1) {
            frame[self.joints[joint]].rotation = rotation;
        }
    }

    /// Returns a frame as the solver's input.
    pub(super) fn pose(&self, frame: &[JointSample]) -> Vec<JointPosition> {
        let rotations = self.rotations(frame).into_iter().skip(1);
        std::iter::once(JointPosition::Fixed).chain(rotations.map(JointPosition::Turn)).collect()
    }
}

/// Returns the local rotations of some joints.
fn rotations(joints: &[usize], frame: &[JointSample]) -> Vec<DQuat> {
    joints.iter().map(|joint| frame[*joint].rotation).collect()
}

/// Returns the depth of a skeleton below its root at rest, in metres.
fn legs_m(skeleton: &Skeleton) -> f64 {
    let rest_m = skeleton.rest_positions_m();
    let ends =
        skeleton.joints.iter().zip(&rest_m).flat_map(|(joint, at)| {
            joint.end_sites_m.iter().map(move |end| *at + *end).chain([*at])
        });
    -ends.fold(0.0, |low: f64, end: DVec3| low.min(end.y))
}

fn rig(body: &Skeleton) -> Result<Rig, RigError> {
    let joints = body.joints.iter().map(|joint| RigJoint {
        parent: joint.parent,
        kind: if joint.parent.is_some() { JointKind::Spherical } else { JointKind::Fixed },
        rotation: DQuat::IDENTITY,
        offset_m: if joint.parent.is_some() { joint.offset_m } else { DVec3::ZERO },
        range: JointRange::Any,
        weight: 1.0,
    });
    Rig::new(&joints.collect::<Vec<_>>())
}
