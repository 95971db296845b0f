//! A recorded skeleton as a rig of `core`, with any of its joints as the root.

use std::cmp::Ordering;

use glam::{DQuat, DVec3};
use sinew_core::importance::{ImportanceError, RestPose, RestPoseError, descendants_length};
use sinew_core::{Body, Inertia, JointKind, Transform, Tree, TreeError};
use sinew_mocap::Skeleton;

use super::BODY_COUNT;
use crate::weights;

/// A skeleton's joints as bodies of a rig. All joints but the root are spherical, bones have their length at rest, and
/// end sites are omitted since nothing rotates there. Poses are compared relative to the root, whose own position and
/// orientation do not count.
#[derive(Debug, Clone, PartialEq)]
pub struct SpatialRig<const N: usize = BODY_COUNT> {
    tree: Box<Tree<N>>,
    bodies: Vec<OfSkeleton>,
    importance: Vec<f32>,
}

/// The part of the skeleton that a body represents.
#[derive(Debug, Clone, PartialEq)]
struct OfSkeleton {
    joint: String,
    turn: Turn,
}

/// The rotation of a body in its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Turn {
    Not,
    By(usize),
    /// Rotation by the inverse of a joint's rotation. The body's parent in the rig is its child in the skeleton.
    Against(usize),
}

/// Maximum length of a bone. A longer bone indicates a wrong unit. The squares of shorter lengths, times importances,
/// are weights that the core accepts.
const LONGEST_M: f64 = 100.0;

/// The error of a skeleton that cannot be compared in space.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpatialError {
    /// A root that is not a joint of the skeleton.
    #[error("root {root}: expected a joint of the skeleton: {joints}")]
    Root {
        /// Requested joint.
        root: String,
        /// Names of the skeleton's joints.
        joints: String,
    },
    /// A bone whose length is not finite or is too large.
    #[error(
        "joint {joint}: expected a bone of at most {LONGEST_M} m, found {length_m} m: is the unit of length right?"
    )]
    Bone {
        /// Joint at the end of the bone.
        joint: String,
        /// Length of the bone, m.
        length_m: f64,
    },
    /// A skeleton that the rig of `core` refuses.
    #[error("the skeleton: {0}")]
    Tree(#[from] TreeError),
    /// A rest pose that is invalid for the weights.
    #[error("the skeleton at rest: {0}")]
    RestPose(#[from] RestPoseError),
    /// Weights that cannot be computed.
    #[error("the joints' importance: {0}")]
    Importance(#[from] ImportanceError),
}

impl SpatialRig {
    /// Creates the rig of a skeleton of usual size, see [`sized`](Self::sized).
    ///
    /// # Errors
    /// Those of [`sized`](Self::sized), with [`BODY_COUNT`] bodies.
    pub fn new(skeleton: &Skeleton, root: Option<&str>) -> Result<Self, SpatialError> {
        Self::sized(skeleton, root)
    }
}

impl<const N: usize> SpatialRig<N> {
    /// Creates the rig of a skeleton. Poses are seen from the bone that the joint called `root` turns; without a name,
    /// from the skeleton's root.
    ///
    /// # Errors
    /// [`SpatialError`] if there is no such joint, more than `N` bodies, or a bone that is not finite or longer
    /// than 100 m.
    pub fn sized(skeleton: &Skeleton, root: Option<&str>) -> Result<Self, SpatialError> {
        let start = match root {
            None => 0,
            Some(root) => skeleton.find(root).ok_or_else(|| {
                let joints: Vec<&str> = skeleton.joints.iter().map(|j| j.name.as_str()).collect();
                SpatialError::Root { root: root.to_owned(), joints: joints.join(", ") }
            })?,
        };
        for joint in skeleton.joints.iter().filter(|joint| joint.parent.is_some()) {
            let length_m = joint.offset_m.length();
            // The condition is written to refuse NaN.
            if !matches!(length_m.partial_cmp(&LONGEST_M), Some(Ordering::Less | Ordering::Equal)) {
                return Err(SpatialError::Bone { joint: joint.name.clone(), length_m });
            }
        }
        let mut rig =
            Self { tree: Box::new(Tree::new()), bodies: Vec::new(), importance: Vec::new() };
        rig.grow(skeleton, start)?;
        let usual = weights::Settings::default();
        let base_m = single(usual.base_of(weights::Method::Lengths));
        let rest = RestPose::of_tree(&rig.tree)?;
        let importance = descendants_length(&rest, base_m, single(usual.discount))?.normalised();
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let count = rig.bodies.len() as f32;
        rig.importance = importance.as_slice().iter().map(|weight| weight * count).collect();
        Ok(rig)
    }

    /// Returns the tree, with a body for each joint of the skeleton. If its root is not the skeleton's root, it has one
    /// more body, since two bodies are then at the chosen joint.
    pub fn tree(&self) -> &Tree<N> {
        &self.tree
    }

    /// Returns the name of the skeleton's joint at a body.
    pub fn joint(&self, body: usize) -> &str {
        &self.bodies[body].joint
    }

    /// Returns the importance of each body, with mean 1. It is computed by [`descendants_length`] from the lengths of
    /// its descendants' bones (D. Holden, "Joint Error Propagation", 2025).
    pub fn importance(&self) -> &[f32] {
        &self.importance
    }

    /// Returns the poses of all bodies in their parents, from the local rotations of the skeleton's joints.
    ///
    /// # Panics
    /// If there are fewer rotations than the skeleton has joints.
    pub fn joint_poses(&self, rotations: &[DQuat]) -> Vec<Transform> {
        let place = |(body, of): (&Body, &OfSkeleton)| {
            let rotation = match of.turn {
                Turn::Not => DQuat::IDENTITY,
                Turn::By(joint) => rotations[joint],
                Turn::Against(joint) => rotations[joint].inverse(),
            };
            Transform { rotation: rotation.as_quat().normalize(), ..body.placement }
        };
        self.tree.bodies().iter().zip(&self.bodies).map(place).collect()
    }

    /// Adds all bodies in depth-first order, starting with the bone that joint `start` turns.
    fn grow(&mut self, skeleton: &Skeleton, start: usize) -> Result<(), SpatialError> {
        // Stack of bones to add: the bone, and the bone and the body from which it was reached.
        let mut open = vec![(start, None::<(usize, usize)>)];
        // Position of each body's origin on its bone.
        let mut origins_m: Vec<DVec3> = Vec::new();
        while let Some((bone, from)) = open.pop() {
            let joint = &skeleton.joints[bone];
            let (turn, at, on_parent_m, origin_m) = match from {
                None => (Turn::Not, bone, DVec3::ZERO, DVec3::ZERO),
                // Away from the skeleton's root: the parent is the skeleton's parent.
                Some((parent, _)) if joint.parent == Some(parent) => {
                    (Turn::By(bone), bone, joint.offset_m, DVec3::ZERO)
                }
                // Towards the skeleton's root: the parent here is the skeleton's child, and the bone turns about
                // that child's joint.
                Some((child, _)) => {
                    (Turn::Against(child), child, DVec3::ZERO, skeleton.joints[child].offset_m)
                }
            };
            let parent = from.map(|(_, body)| body);
            let offset_m = on_parent_m - parent.map_or(DVec3::ZERO, |body| origins_m[body]);
            let kind = if parent.is_none() { JointKind::Fixed } else { JointKind::Spherical };
            let body = self.add(parent, kind, offset_m, &skeleton.joints[at].name, turn)?;
            origins_m.push(origin_m);
            let child_it_came_from = from.map(|(bone, _)| bone);
            match joint.parent {
                Some(parent) if Some(parent) != child_it_came_from => {
                    open.push((parent, Some((bone, body))));
                }
                // The skeleton's root is attached to its child here: its own position is a fixed point of that
                // body.
                None if from.is_some() => {
                    self.add(Some(body), JointKind::Fixed, -origin_m, &joint.name, Turn::Not)?;
                    origins_m.push(DVec3::ZERO);
                }
                _ => {}
            }
            for (child, of) in skeleton.joints.iter().enumerate().rev() {
                if of.parent == Some(bone) && Some(child) != child_it_came_from {
                    open.push((child, Some((bone, body))));
                }
            }
        }
        Ok(())
    }

    fn add(
        &mut self,
        parent: Option<usize>,
        joint: JointKind,
        offset_m: DVec3,
        name: &str,
        turn: Turn,
    ) -> Result<usize, TreeError> {
        let placement = Transform::from_translation(offset_m.as_vec3());
        self.tree.push(Body {
            parent,
            joint,
            placement,
            inertia: Inertia::default(),
            rotor_inertia: 0.0,
        })?;
        self.bodies.push(OfSkeleton { joint: name.to_owned(), turn });
        Ok(self.bodies.len() - 1)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "core weighs in f32")]
pub(super) fn single(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod tests {
    use glam::EulerRot;
    use sinew_core::pose_space::PoseSpace;
    use sinew_mocap::{JointSample, forward_kinematics};

    use super::*;
    use sinew_figure::builtin;

    #[test]
    fn seen_from_any_joint_all_joints_are_where_they_are() {
        let skeleton = builtin::clips()[0].skeleton.clone();
        let rotations: Vec<DQuat> = (0..skeleton.joints.len())
            .map(|joint| joint as f64)
            .map(|j| DQuat::from_euler(EulerRot::XYZ, 0.3 * j, 1.0 - 0.2 * j, 0.1 * j * j))
            .collect();
        let local = skeleton.joints.iter().zip(&rotations).map(|(joint, rotation)| JointSample {
            rotation: *rotation,
            position_m: joint.offset_m,
        });
        let world = forward_kinematics(&skeleton, &local.collect::<Vec<_>>());
        for (start, joint) in skeleton.joints.iter().enumerate() {
            let rig = SpatialRig::new(&skeleton, Some(&joint.name)).unwrap();
            let extra = usize::from(start != 0);
            assert_eq!(rig.tree().bodies().len(), skeleton.joints.len() + extra);
            let space = PoseSpace::new(rig.tree());
            let at = space.coordinates(&rig.joint_poses(&rotations)).unwrap();
            for (body, place) in space.body_poses(&at).as_slice().iter().enumerate() {
                let there = world[skeleton.find(rig.joint(body)).unwrap()].position_m;
                let from_root = world[start].rotation.inverse() * (there - world[start].position_m);
                let off_m = (place.translation_m.as_dvec3() - from_root).length();
                assert!(off_m < 1e-5, "{} from {}: {off_m}", rig.joint(body), joint.name);
            }
        }
    }

    #[test]
    fn a_bone_of_another_unit_is_refused_by_name() {
        for length in [1000.0, f64::NAN, f64::INFINITY] {
            let mut skeleton = builtin::clips()[0].skeleton.clone();
            skeleton.joints[2].offset_m.x = length;
            let error = SpatialRig::new(&skeleton, None).unwrap_err().to_string();
            assert!(error.contains(&skeleton.joints[2].name) && error.contains("unit"), "{error}");
        }
    }

    #[test]
    fn a_root_that_is_not_there_is_refused_by_name() {
        let skeleton = builtin::clips()[0].skeleton.clone();
        let error = SpatialRig::new(&skeleton, Some("Tail")).unwrap_err().to_string();
        assert!(error.contains("Tail") && error.contains(&skeleton.joints[1].name), "{error}");
    }
}
