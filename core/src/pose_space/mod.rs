//! Poses compared by how far joints move in space: the metrics, curves and derivatives of Hauberg & Pedersen (2012).

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

/// The poses of one rig, and how far they are apart.
///
/// A pose has coordinates θ (what its joints leave free) and a place in space F(θ): the positions of all joints, world
/// axes, metres. Distances in θ, as [`Self::angle_distance`], weigh a shoulder and a finger equally; distances
/// in F do not, and the way between two poses that keeps all bones as long as they are is a curve on the surface that F
/// makes: see [`Self::line_distance`] and [`Self::curve_energy`].
///
/// As in the paper, where the root is and how it is turned does not count, unless [`Self::with_root`] says so.
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
/// // Half a radian of the shoulder; the elbow moves on an arc of 0.3 m, the hand on one of 0.6 m.
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

/// What of the root counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Root {
    LeftOut,
    Counted,
}

/// The coordinates of a pose: of every joint, what its kind leaves free. Finite.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PoseCoordinates<const N: usize> {
    joints: Vec<JointCoordinates, N>,
}

/// Rotations of all joints in their parents' frames, made ready once to be compared with many, see
/// [`PoseSpace::rotation_distance`].
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct JointRotations<const N: usize> {
    rotations: Vec<Quat, N>,
}

/// Where the bodies of a pose are, seen from the world, or from the root where that does not count.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BodyPoses<const N: usize> {
    bodies: Vec<Transform, N>,
}

impl<'t, const N: usize> PoseSpace<'t, N> {
    /// The poses of a rig, all joints counting alike, the root's place and orientation not at all. O(n).
    pub fn new(tree: &'t Tree<N>) -> Self {
        let weights = fixed::collect(tree.bodies().iter().map(|_| 1.0));
        Self { tree, weights, root: Root::LeftOut }
    }

    /// The same with a weight for each joint, for squared distances in metres and in radians alike: how much it
    /// counts where the joint is, and how it is turned. [`importance`](crate::importance)s are such.
    ///
    /// # Errors
    /// [`PoseSpaceError::Count`] if there is not one for each joint, [`PoseSpaceError::Weight`] if one is negative, not
    /// finite, or above 1e6, or all are zero.
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

    /// The same with the root's place and orientation counting like any joint's.
    #[must_use]
    pub fn with_root(self) -> Self {
        Self { root: Root::Counted, ..self }
    }

    /// The rig.
    pub fn tree(&self) -> &'t Tree<N> {
        self.tree
    }

    /// The coordinates of a pose, given as the poses of all joints in their parents' frames. O(n).
    ///
    /// What the joints' kinds do not leave free is left out: bones are as long as the rig's.
    ///
    /// # Errors
    /// [`PoseSpaceError::Count`] if there is not a pose for each joint, [`PoseSpaceError::Pose`] if one is not finite,
    /// farther than 1e6 m away, or its rotation not unit.
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

    /// The poses of all joints in their parents' frames, from coordinates; a root that does not count gets its
    /// placement. O(n).
    ///
    /// `out` goes by joint; what is longer than the rig is left alone.
    pub fn joint_poses(&self, at: &PoseCoordinates<N>, out: &mut [Transform]) {
        for ((body, joint), out) in self.tree.bodies().iter().zip(&at.joints).zip(out) {
            *out = if self.leaves_out(body) { body.placement } else { chart::pose(body, joint) };
        }
    }

    /// The rotations of all joints, from coordinates. O(n).
    pub fn joint_rotations(&self, at: &PoseCoordinates<N>) -> JointRotations<N> {
        let joints = self.tree.bodies().iter().zip(&at.joints);
        let rotations = fixed::collect(joints.map(|(body, at)| chart::pose(body, at).rotation));
        JointRotations { rotations }
    }

    /// Where all bodies are in a pose. A root that does not count is at the origin, not turned. O(n).
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
            // There is room: they are as many as the tree's.
            if bodies.push(place).is_err() {
                break;
            }
        }
        BodyPoses { bodies }
    }

    /// Whether a joint's coordinates do not count, since it is the root's.
    fn leaves_out(&self, body: &Body) -> bool {
        body.parent.is_none() && self.root == Root::LeftOut
    }

    /// Bodies with their weights.
    fn weighted(&self) -> impl DoubleEndedIterator<Item = (&'t Body, f32)> + ExactSizeIterator {
        self.tree.bodies().iter().zip(self.weights.iter().copied())
    }
}

/// The farthest position, m: beyond, f32 does not resolve a tenth of a metre.
const FARTHEST_M: f32 = 1e6;

impl<const N: usize> PoseCoordinates<N> {
    /// By joint.
    pub fn as_slice(&self) -> &[JointCoordinates] {
        &self.joints
    }
}

impl<const N: usize> BodyPoses<N> {
    /// By body.
    pub fn as_slice(&self) -> &[Transform] {
        &self.bodies
    }

    /// F(θ): the positions by body, m.
    pub fn positions_m(&self) -> impl DoubleEndedIterator<Item = Vec3> + ExactSizeIterator {
        self.bodies.iter().map(|body| body.translation_m)
    }
}

/// Why poses or weights were refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PoseSpaceError {
    /// There must be one for each joint of the rig.
    Count {
        /// Number of joints.
        expected: usize,
        /// Number of poses or weights.
        found: usize,
    },
    /// A pose is not finite, farther than 1e6 m away, or its rotation is no unit quaternion.
    Pose {
        /// The joint.
        joint: usize,
    },
    /// A weight is not a number from 0 to 1e6, or all of them are zero.
    Weight {
        /// The joint.
        joint: usize,
        /// The weight.
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
