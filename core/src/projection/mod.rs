//! Manifold projection: the pose of *this* figure that is nearest to the desired pose.

mod joint;
mod range;

use core::fmt;

use glam::{Quat, Vec3};
use heapless::Vec;

use joint::Joint;
pub use range::JointRange;

pub use crate::body_weight::{BodyWeight, BodyWeights, BodyWeightsError};
use crate::dynamics::ArticulatedInertia;
use crate::dynamics::least_constraint::{Demand, MotionSubspace, Response};
use crate::fixed;
use crate::joint::JointKind;
use crate::math;
use crate::transform::{Transform, Twist, Wrench};
use crate::tree::{Body, Tree};

/// A search for the pose of a figure that is nearest to the desired pose of another figure. The result is the pose
/// within the joints' ranges that minimises `Σ wᵢ |pᵢ - p_d,i|² + ρᵢ² |Log(Rᵢ R_d,iᵀ)|²`.
///
/// When the rig and the performer differ in dimensions, tracking this pose with World Space Error gives up a little
/// angle accuracy for much better positions. With equal dimensions the result is the desired pose.
///
/// Each call makes a fixed number of Gauss-Newton steps (twenty in a workspace's first call), from the last call's
/// solution: the deviation of each joint from its desired pose. The deviation changes slowly in a performance, which
/// makes a single step enough (see [`DEFAULT_SWEEPS`]). A step is stiffened if a body is pulled away from the joint
/// that carries it, and damped while a joint is pressed against the end of its range. Each step is solved exactly in
/// O(n) by sweeps of the articulated-body algorithm over virtual inertias (Gauss's principle: mass `wᵢ` and rotational
/// inertia `ρᵢ²`).
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, Transform, Tree, glam::Vec3};
/// use sinew_core::projection::{BodyWeight, ManifoldProjection, ProjectionWorkspace};
/// let body = |parent, joint, x: f32| Body {
///     parent,
///     joint,
///     placement: Transform::from_translation(Vec3::X * x),
///     inertia: Inertia::default(),
///     rotor_inertia: 0.0,
/// };
/// let elbow = JointKind::Revolute { axis: Vec3::Z };
/// let bodies =
///     [body(None, JointKind::Fixed, 0.0), body(Some(0), elbow, 0.3), body(Some(1), elbow, 0.3)];
/// let arm = Tree::<3>::from_bodies(&bodies)?;
/// let projection = ManifoldProjection::new(&arm, &[BodyWeight::new(1.0, 0.1); 3])?;
///
/// // The performer's upper arm is shorter. With a small bend, the elbow is nearer to its desired position.
/// let mut desired = bodies.map(|body| body.placement);
/// desired[2].translation_m = Vec3::new(0.29, 0.05, 0.0);
/// let (mut workspace, mut nearest) = (ProjectionWorkspace::new(), desired);
/// projection.project(&arm, &desired, &mut workspace, &mut nearest)?;
/// assert!(nearest[1].rotation.z > 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ManifoldProjection<const N: usize> {
    weights: BodyWeights<N>,
    ranges: Vec<JointRange, N>,
    root_held: bool,
    sweeps: u8,
}

/// Default number of sweeps per call. If a call starts from the solution of the previous frame, a single sweep is
/// within 1 % of the optimum.
pub const DEFAULT_SWEEPS: u8 = 1;

/// Number of sweeps in the first call, which has no solution to start from.
const FIRST_SWEEPS: u8 = 20;

/// Additional relative resistance of all joints while a joint is pressed against the end of its range.
///
/// When a joint reaches or leaves the end of its range, the steps of the other joints have not taken this into
/// account. Without damping, the sweeps can oscillate forever.
const PRESSED_DAMPING: f32 = 0.3;

impl<const N: usize> ManifoldProjection<N> {
    /// Creates a projection with a weight for each body of the tree, without ranges, and with [`DEFAULT_SWEEPS`].
    ///
    /// # Errors
    /// [`ProjectionError::Weights`] in the cases of [`BodyWeights::new`].
    pub fn new(tree: &Tree<N>, weights: &[BodyWeight]) -> Result<Self, ProjectionError> {
        Ok(Self {
            weights: BodyWeights::new(tree, weights).map_err(ProjectionError::Weights)?,
            ranges: fixed::collect(tree.bodies().iter().map(|_| JointRange::Any)),
            root_held: false,
            sweeps: DEFAULT_SWEEPS,
        })
    }

    /// Sets the weights of the bodies.
    ///
    /// # Errors
    /// [`ProjectionError::Weights`] in the cases of [`BodyWeights::new`].
    pub fn with_weights(
        self,
        tree: &Tree<N>,
        weights: &[BodyWeight],
    ) -> Result<Self, ProjectionError> {
        let weights = BodyWeights::new(tree, weights).map_err(ProjectionError::Weights)?;
        Ok(Self { weights, ..self })
    }

    /// Sets a range for each joint. No solution is ever outside these ranges.
    ///
    /// # Errors
    /// [`ProjectionError`] if the number of ranges is not the number of joints, or a range does not fit its joint.
    pub fn with_ranges(
        self,
        tree: &Tree<N>,
        ranges: &[JointRange],
    ) -> Result<Self, ProjectionError> {
        if ranges.len() != self.ranges.len() || tree.len() != self.ranges.len() {
            let (expected, found) = (self.ranges.len(), ranges.len());
            return Err(ProjectionError::Count { expected, found });
        }
        let bad =
            tree.bodies().iter().zip(ranges).position(|(body, range)| !range.fits(body.joint));
        if let Some(joint) = bad {
            return Err(ProjectionError::Range { joint });
        }
        Ok(Self { ranges: fixed::collect(ranges.iter().copied()), ..self })
    }

    /// Holds the root at its desired pose. For a rig that walks on its own feet, the projection must not change the
    /// root's pose. A root on a fixed joint is held in any case.
    #[must_use]
    pub fn with_root_held(self) -> Self {
        Self { root_held: true, ..self }
    }

    /// Sets the number of sweeps per call, at least one.
    #[must_use]
    pub fn with_sweeps(self, sweeps: u8) -> Self {
        Self { sweeps: sweeps.max(1), ..self }
    }

    /// Computes the nearest pose, as the poses of all joints in their parents' frames. `desired` has the same form,
    /// with the performer's dimensions. O(n) for each sweep.
    ///
    /// A root that is fixed or held gets its desired pose; other fixed joints get their placement. Use one workspace
    /// for the consecutive frames of a performance, and call [`ProjectionWorkspace::reset`] before another
    /// performance.
    ///
    /// # Errors
    /// [`ProjectionError`], and neither `out` nor the workspace changes, if the length of a slice is not the number
    /// of joints, or a pose is not finite or its rotation not unit.
    pub fn project(
        &self,
        tree: &Tree<N>,
        desired: &[Transform],
        workspace: &mut ProjectionWorkspace<N>,
        out: &mut [Transform],
    ) -> Result<(), ProjectionError> {
        let bodies = tree.bodies();
        for found in [bodies.len(), desired.len(), out.len()] {
            if found != self.ranges.len() {
                return Err(ProjectionError::Count { expected: self.ranges.len(), found });
            }
        }
        // A unit rotation is finite.
        let usable =
            |pose: &Transform| math::is_finite(pose.translation_m) && math::is_unit(pose.rotation);
        let bad = desired.iter().position(|pose| !usable(pose));
        if let Some(joint) = bad {
            return Err(ProjectionError::InvalidPose { joint });
        }
        workspace.start(self, bodies, desired);
        let sweeps = if workspace.started { self.sweeps } else { FIRST_SWEEPS.max(self.sweeps) };
        workspace.started = true;
        for sweep in 0..sweeps {
            // `start` has already set the demands of the first sweep.
            if sweep > 0 {
                workspace.ask(self, bodies);
            }
            workspace.inward(self, bodies);
            workspace.outward(self, bodies, desired);
        }
        for (joint, out) in workspace.joints.iter().zip(out) {
            *out = joint.pose;
        }
        Ok(())
    }

    /// Returns `true` if the joint of a body cannot move at all.
    fn is_rigid(&self, body: &Body) -> bool {
        matches!(body.joint, JointKind::Fixed) || (body.parent.is_none() && self.root_held)
    }

    fn range(&self, index: usize) -> &JointRange {
        self.ranges.get(index).unwrap_or(&JointRange::Any)
    }
}

/// The solution of a [`ManifoldProjection`] for the last frame, and its scratch memory.
#[derive(Debug, Clone, PartialEq)]
pub struct ProjectionWorkspace<const N: usize> {
    joints: [Joint; N],
    bodies: [Solved; N],
    started: bool,
}

/// Data of one body in a sweep, in world axes.
#[derive(Debug, Clone, PartialEq)]
struct Solved {
    desired: Transform,
    pose: Transform,
    demand: Demand,
    response: Response,
    motion: Twist,
    /// Sum of the weighted distances to the desired positions, over all bodies from this body outwards.
    pull: Vec3,
}

impl<const N: usize> ProjectionWorkspace<N> {
    /// Creates a workspace for trees of capacity `N`. The first frame starts from the desired pose.
    #[inline(never)]
    pub fn new() -> Self {
        let solved = Solved {
            desired: Transform::IDENTITY,
            pose: Transform::IDENTITY,
            demand: Demand::ZERO,
            response: Response::Free(Twist::ZERO),
            motion: Twist::ZERO,
            pull: Vec3::ZERO,
        };
        Self {
            joints: [Joint::NEW; N],
            bodies: core::array::from_fn(|_| solved.clone()),
            started: false,
        }
    }

    /// Forgets the last frame: the next frame starts from the desired pose.
    pub fn reset(&mut self) {
        // In place: a new workspace would be built on the stack. The solved bodies are overwritten anyway.
        self.joints.fill(Joint::NEW);
        self.started = false;
    }

    /// Computes the desired world poses, starts the joints from the last solution, and sets the demands of the
    /// bodies.
    fn start(
        &mut self,
        projection: &ManifoldProjection<N>,
        bodies: &[Body],
        desired: &[Transform],
    ) {
        for (index, (((body, desired), joint), weight)) in bodies
            .iter()
            .zip(desired)
            .zip(&mut self.joints)
            .zip(projection.weights.as_slice())
            .enumerate()
        {
            if projection.is_rigid(body) {
                joint.pose = if body.parent.is_none() { *desired } else { body.placement };
            } else {
                joint.start(body, projection.range(index), desired);
            }
            let Some((inner, [solved, ..])) = self.bodies.split_at_mut_checked(index) else {
                return;
            };
            let parent = body.parent.and_then(|parent| inner.get(parent));
            solved.desired = parent.map_or(*desired, |parent| parent.desired * *desired);
            solved.ask(parent, joint, *weight);
        }
    }

    /// Sets the demands of the bodies at the present poses of the joints.
    fn ask(&mut self, projection: &ManifoldProjection<N>, bodies: &[Body]) {
        for (index, ((body, joint), weight)) in
            bodies.iter().zip(&self.joints).zip(projection.weights.as_slice()).enumerate()
        {
            let Some((inner, [solved, ..])) = self.bodies.split_at_mut_checked(index) else {
                return;
            };
            solved.ask(body.parent.and_then(|parent| inner.get(parent)), joint, *weight);
        }
    }

    /// Sweeps from the leaves to the root. Computes the best motion of every joint as a function of its parent's
    /// motion.
    fn inward(&mut self, projection: &ManifoldProjection<N>, bodies: &[Body]) {
        let pressed = self.joints.iter().take(bodies.len()).any(Joint::is_pressed);
        let damping = if pressed { PRESSED_DAMPING } else { 0.0 };
        for (index, body) in bodies.iter().enumerate().rev() {
            let (Some(joint), Some((inner, [solved, ..]))) =
                (self.joints.get(index), self.bodies.split_at_mut_checked(index))
            else {
                return;
            };
            let parent = body.parent.and_then(|parent| inner.get_mut(parent));
            if !projection.is_rigid(body) && joint.is_free_ball(body) {
                let response = solved.demand.eliminate_turn(damping);
                solved.response = Response::Ball(response);
                if let Some(parent) = parent {
                    let arm = solved.pose.translation_m - parent.pose.translation_m;
                    parent.demand.add_ball(&solved.demand, arm);
                    parent.carry(solved.pull, arm);
                }
                continue;
            }
            let dofs = if projection.is_rigid(body) {
                MotionSubspace::Axes(Vec::new())
            } else {
                joint.dofs(body, &solved.pose)
            };
            solved.response = solved.demand.eliminate(&dofs, damping);
            if let Some(parent) = parent {
                let arm = solved.pose.translation_m - parent.pose.translation_m;
                parent.demand.add_child(&solved.demand, arm);
                parent.carry(solved.pull, arm);
            }
        }
    }

    /// Sweeps from the root to the leaves. Moves every joint, because its parent's motion is now known.
    fn outward(
        &mut self,
        projection: &ManifoldProjection<N>,
        bodies: &[Body],
        desired: &[Transform],
    ) {
        for (index, (body, desired)) in bodies.iter().zip(desired).enumerate() {
            let (Some(joint), Some((inner, [solved, ..]))) =
                (self.joints.get_mut(index), self.bodies.split_at_mut_checked(index))
            else {
                return;
            };
            let carried =
                body.parent.and_then(|parent| inner.get(parent)).map_or(Twist::ZERO, |parent| {
                    let arm = solved.pose.translation_m - parent.pose.translation_m;
                    let Twist { angular, linear } = parent.motion;
                    Twist { angular, linear: math::plus_cross(linear, angular, arm) }
                });
            solved.motion = if projection.is_rigid(body) {
                carried
            } else {
                let range = projection.range(index);
                joint.step(body, range, desired, &solved.pose, &solved.response, carried)
            };
        }
    }
}

impl Solved {
    /// Sets the demand of the body itself. `joint` connects the body to its parent.
    #[inline]
    fn ask(&mut self, parent: Option<&Self>, joint: &Joint, weight: BodyWeight) {
        self.pose = parent.map_or(joint.pose, |parent| parent.pose * joint.pose);
        let turn = math::log(turn_between(self.pose.rotation, self.desired.rotation));
        let way = self.desired.translation_m - self.pose.translation_m;
        self.pull = way * weight.position;
        let angular = weight.rotation_m * weight.rotation_m;
        self.demand = Demand {
            inertia: ArticulatedInertia::round(angular, weight.position),
            wrench: Wrench::new(turn * angular, self.pull),
        };
    }

    /// Adds the pull of a child whose origin is `arm_m` away.
    #[inline]
    fn carry(&mut self, pull: Vec3, arm_m: Vec3) {
        // A rotation moves the arm's end away from its tangent, against an outward pull. Gauss-Newton omits this
        // curvature of the cost; without it, a rig that is too short for its goals overshoots.
        let stiffening = pull.dot(arm_m);
        if stiffening > 0.0 {
            self.demand.inertia.angular.add_diagonal(stiffening);
        }
        self.pull += pull;
    }
}

impl<const N: usize> Default for ProjectionWorkspace<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Returns the rotation from one orientation to another, from their difference. For equal orientations it is exactly
/// no rotation, whereas a product with the inverse has a rounding error.
fn turn_between(from: Quat, to: Quat) -> Quat {
    let difference = (to - from) * from.conjugate();
    Quat { w: from.dot(from) + difference.w, ..difference }
}

/// An error in the arguments of a projection.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ProjectionError {
    /// The number of items is not the number of bodies.
    Count {
        /// Number of bodies.
        expected: usize,
        /// Number of items.
        found: usize,
    },
    /// The weights of the bodies are invalid.
    Weights(BodyWeightsError),
    /// The range does not fit this kind of joint, or its ends are not numbers in order.
    Range {
        /// Index of the joint.
        joint: usize,
    },
    /// The desired pose of a joint is not finite, or its rotation not a unit quaternion.
    InvalidPose {
        /// Index of the joint.
        joint: usize,
    },
}

impl fmt::Display for ProjectionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => {
                write!(f, "{expected} bodies need one for each, {found} were given")
            }
            Self::Weights(error) => error.fmt(f),
            Self::Range { joint } => write!(
                f,
                "joint {joint}: the range does not fit its kind, or its ends are not in order within a turn"
            ),
            Self::InvalidPose { joint } => write!(
                f,
                "joint {joint}: the pose is not finite or its rotation not a unit quaternion"
            ),
        }
    }
}

impl core::error::Error for ProjectionError {}
