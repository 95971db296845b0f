//! Comparison of poses by the distances of joints in space: the metrics, curves and derivatives of Hauberg & Pedersen
//! (2012).

mod chart;
mod curve;
mod line;
mod metric;

use core::fmt;

use glam::{Quat, Vec3};
use heapless::Vec;

pub use chart::JointCoordinates;
pub use line::LineWorkspace;

use crate::fixed;
use crate::kinematics::of_parent;
use crate::math;
use crate::transform::Transform;
use crate::tree::{Body, Tree};

/// The space of poses of a rig, with its distances.
///
/// A pose has coordinates θ (the positions of its joints' dofs) and an image in space F(θ): the positions of all
/// joints, in world axes, in metres. Distances in θ, such as [`Self::angle_distance`], weigh a shoulder and a finger
/// equally; distances in F do not. A path between two poses on which all bones keep their lengths is a curve on the
/// surface of all F(θ): see [`Self::line_distance`] and [`Self::curve_energy`].
///
/// The root's position and rotation are ignored, as in the paper, unless [`Self::with_root`] includes them.
///
/// Hauberg & Pedersen, "Spatial measures between human poses for classification and understanding" (2012).
///
/// ```
/// use sinew_core::pose_space::{LineWorkspace, PoseSpace};
/// use sinew_core::{Body, Inertia, JointKind, Transform, Tree, glam::Vec3, math};
/// let bone = |parent, joint, x| Body {
///     parent,
///     joint,
///     placement: Transform::from_translation(Vec3::X * x),
///     inertia: Inertia::default(),
///     rotor_inertia: 0.0,
/// };
/// let hinge = JointKind::Revolute { axis: Vec3::Z };
/// let arm = Tree::<4>::from_bodies(&[
///     bone(None, JointKind::Fixed, 0.0),
///     bone(Some(0), hinge, 0.0),
///     bone(Some(1), hinge, 0.3),
///     bone(Some(2), JointKind::Fixed, 0.3),
/// ])?;
/// let space = PoseSpace::new(&arm);
/// let mut pose: Vec<Transform> = arm.bodies().iter().map(|body| body.placement).collect();
/// let straight = space.coordinates(&pose)?;
/// pose[1].rotation = math::exp(Vec3::Z * 0.5);
/// let raised = space.coordinates(&pose)?;
///
/// // The shoulder turns by 0.5 rad: the elbow moves on an arc of radius 0.3 m, the hand on one of radius 0.6 m.
/// assert!((space.angle_distance(&straight, &raised) - 0.5).abs() < 1e-6);
/// let way_m = space.line_distance(&straight, &raised, 100, &mut LineWorkspace::new());
/// assert!((way_m - 0.5 * math::sqrt(0.3 * 0.3 + 0.6 * 0.6)).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PoseSpace<'t, const N: usize> {
    tree: &'t Tree<N>,
    weights: Vec<f32, N>,
    root: Root,
}

/// The choice whether distances include the root's pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Root {
    LeftOut,
    Counted,
}

/// The coordinates of a pose, by joint. Always finite.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PoseCoordinates<const N: usize> {
    joints: Vec<JointCoordinates, N>,
}

/// Rotations of all joints in their parents' frames, prepared once for many comparisons, see
/// [`PoseSpace::rotation_distance`].
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct JointRotations<const N: usize> {
    rotations: Vec<Quat, N>,
}

/// Poses of the bodies in the world frame, or in the root's frame if the root is ignored.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BodyPoses<const N: usize> {
    bodies: Vec<Transform, N>,
}

impl<'t, const N: usize> PoseSpace<'t, N> {
    /// Creates the pose space of a rig, with equal weights for all joints, and without the root's pose. O(n).
    pub fn new(tree: &'t Tree<N>) -> Self {
        let weights = fixed::collect(tree.bodies().iter().map(|_| 1.0));
        Self { tree, weights, root: Root::LeftOut }
    }

    /// Sets a weight for each joint, which applies to squared distances in metres and in radians alike. An
    /// [`importance`](crate::importance) may serve as weights.
    ///
    /// # Errors
    /// [`PoseSpaceError::Count`] if the number of weights is not the number of joints, [`PoseSpaceError::Weight`] if
    /// a weight is negative, not finite, or above 1e6, or all are zero.
    pub fn with_weights(self, weights: &[f32]) -> Result<Self, PoseSpaceError> {
        if weights.len() != self.weights.len() {
            let (expected, found) = (self.weights.len(), weights.len());
            return Err(PoseSpaceError::Count { expected, found });
        }
        // Written so that NaN is bad.
        let bad = weights.iter().position(|weight| !(0.0..=1e6).contains(weight));
        if let Some(joint) =
            bad.or_else(|| weights.iter().all(|weight| *weight <= 0.0).then_some(0))
        {
            let value = weights.get(joint).copied().unwrap_or_default();
            return Err(PoseSpaceError::Weight { joint, value });
        }
        Ok(Self { weights: fixed::collect(weights.iter().copied()), ..self })
    }

    /// Includes the root's position and rotation, like any joint's.
    #[must_use]
    pub fn with_root(self) -> Self {
        Self { root: Root::Counted, ..self }
    }

    /// Returns the weights by joint.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Returns the rig.
    pub fn tree(&self) -> &'t Tree<N> {
        self.tree
    }

    /// Returns the coordinates of a pose, given as the poses of all joints in their parents' frames. O(n).
    ///
    /// The part of a pose that a joint does not allow is ignored: bones keep the rig's lengths.
    ///
    /// # Errors
    /// [`PoseSpaceError::Count`] if the number of poses is not the number of joints, [`PoseSpaceError::Pose`] if a pose
    /// is not finite, a component of its position is above 1e6 m in absolute value, or its rotation is not unit.
    pub fn coordinates(&self, poses: &[Transform]) -> Result<PoseCoordinates<N>, PoseSpaceError> {
        let bodies = self.tree.bodies();
        if poses.len() != bodies.len() {
            return Err(PoseSpaceError::Count { expected: bodies.len(), found: poses.len() });
        }
        // Written so that NaN is not usable.
        let usable = |pose: &Transform| {
            math::is_unit(pose.rotation) && pose.translation_m.abs().max_element() <= FARTHEST_M
        };
        let bad = poses.iter().position(|pose| !usable(pose));
        if let Some(joint) = bad {
            return Err(PoseSpaceError::Pose { joint });
        }
        let joints = bodies.iter().zip(poses).map(|(body, pose)| {
            if self.leaves_out(body) {
                JointCoordinates::ZERO
            } else {
                chart::coordinates(body, pose)
            }
        });
        Ok(PoseCoordinates { joints: fixed::collect(joints) })
    }

    /// Writes the poses of all joints in their parents' frames, from coordinates. An ignored root gets its placement.
    /// O(n).
    ///
    /// `out` is by joint; items beyond the rig are unchanged.
    pub fn joint_poses(&self, at: &PoseCoordinates<N>, out: &mut [Transform]) {
        for ((body, joint), out) in self.tree.bodies().iter().zip(&at.joints).zip(out) {
            *out = if self.leaves_out(body) { body.placement } else { chart::pose(body, joint) };
        }
    }

    /// Returns the rotations of all joints, from coordinates. O(n).
    pub fn joint_rotations(&self, at: &PoseCoordinates<N>) -> JointRotations<N> {
        let joints = self.tree.bodies().iter().zip(&at.joints);
        let rotations = fixed::collect(joints.map(|(body, at)| chart::pose(body, at).rotation));
        JointRotations { rotations }
    }

    /// Returns the poses of all bodies. An ignored root is at the origin, without rotation. O(n).
    pub fn body_poses(&self, at: &PoseCoordinates<N>) -> BodyPoses<N> {
        let mut bodies = Vec::<Transform, N>::new();
        for (body, joint) in self.tree.bodies().iter().zip(&at.joints) {
            let place = if self.leaves_out(body) {
                Transform::IDENTITY
            } else {
                let parent = *of_parent(body, &bodies, &Transform::IDENTITY);
                let place = parent * chart::pose(body, joint);
                Transform { rotation: math::unit(place.rotation), ..place }
            };
            // There is room: the tree has the same number of bodies.
            if bodies.push(place).is_err() {
                break;
            }
        }
        BodyPoses { bodies }
    }

    /// Returns `true` if the joint is the root's and the root is ignored.
    fn leaves_out(&self, body: &Body) -> bool {
        body.parent.is_none() && self.root == Root::LeftOut
    }

    /// Returns the bodies with their weights.
    fn weighted(&self) -> impl DoubleEndedIterator<Item = (&'t Body, f32)> + ExactSizeIterator {
        self.tree.bodies().iter().zip(self.weights.iter().copied())
    }
}

/// Maximum absolute value of a position's component, m. Beyond it, f32 does not resolve a tenth of a metre.
const FARTHEST_M: f32 = 1e6;

impl<const N: usize> PoseCoordinates<N> {
    /// Returns the coordinates by joint.
    pub fn as_slice(&self) -> &[JointCoordinates] {
        &self.joints
    }
}

impl<const N: usize> JointRotations<N> {
    /// Returns the rotations by joint, each in its parent's frame.
    pub fn as_slice(&self) -> &[Quat] {
        &self.rotations
    }
}

impl<const N: usize> BodyPoses<N> {
    /// Returns the poses by body.
    pub fn as_slice(&self) -> &[Transform] {
        &self.bodies
    }

    /// Returns F(θ): the positions by body, m.
    pub fn positions_m(&self) -> impl DoubleEndedIterator<Item = Vec3> + ExactSizeIterator {
        self.bodies.iter().map(|body| body.translation_m)
    }
}

/// An error in poses or weights.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PoseSpaceError {
    /// The number of poses or weights is not the number of joints.
    Count {
        /// Number of joints.
        expected: usize,
        /// Number of poses or weights.
        found: usize,
    },
    /// A pose is not finite, a component of its position is above 1e6 m in absolute value, or its rotation is not a
    /// unit quaternion.
    Pose {
        /// Index of the joint.
        joint: usize,
    },
    /// A weight is not a number from 0 to 1e6, or all weights are zero.
    Weight {
        /// Index of the joint.
        joint: usize,
        /// Weight of the joint.
        value: f32,
    },
}

impl fmt::Display for PoseSpaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => {
                write!(f, "{expected} joints need as many poses or weights, {found} were given")
            }
            Self::Pose { joint } => write!(
                f,
                "joint {joint}: the pose must be finite, within 1e6 m, with a unit quaternion"
            ),
            Self::Weight { joint, value } => write!(
                f,
                "joint {joint}: the weight is {value}; weights must be from 0 to 1e6, and not all zero"
            ),
        }
    }
}

impl core::error::Error for PoseSpaceError {}
