//! A rig in f64: positions of the joints in a pose, and their motion.

use glam::{DQuat, DVec3};
use nalgebra::DVector;
use sinew_core::projection::JointRange;
use sinew_core::{Body, JointKind};
use thiserror::Error;

use super::joint::{Axis, JointPosition, Model};
use super::limit::{self, Limit};

/// A rig for geodesics: its joints, their ranges, and the weight of each joint's position.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    pub(super) joints: Vec<Joint>,
    /// Number of columns of the Jacobian.
    pub(super) columns: usize,
}

/// Description of a joint. Its parent has a smaller index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigJoint {
    /// Index of the parent; `None` only for the root, whose motion is ignored.
    pub parent: Option<usize>,
    /// Kind of joint.
    pub kind: JointKind,
    /// Rotation of the joint frame in the parent.
    pub rotation: DQuat,
    /// Position of the joint in the parent, m.
    pub offset_m: DVec3,
    /// Range of the joint's motion.
    pub range: JointRange,
    /// Weight of the squared displacement of the joint.
    pub weight: f64,
}

impl From<&Body> for RigJoint {
    /// Returns a joint of the body's kind without a range, with weight 1.
    fn from(body: &Body) -> Self {
        Self {
            parent: body.parent,
            kind: body.joint,
            rotation: body.placement.rotation.as_dquat(),
            offset_m: body.placement.translation_m.as_dvec3(),
            range: JointRange::Any,
            weight: 1.0,
        }
    }
}

/// A joint on its parent.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Joint {
    pub(super) parent: Option<usize>,
    pub(super) model: Model,
    rotation: DQuat,
    offset_m: DVec3,
    pub(super) weight: f64,
    pub(super) range: JointRange,
    /// Whether its motion would move a joint that has a weight; false for the root. A fixed joint has no columns even
    /// if this is true.
    pub(super) moves: bool,
}

impl Joint {
    /// Returns whether a step rotates the joint's body in the world, independently of its parents: a ball joint
    /// without a range.
    pub(super) fn turns_in_world(&self) -> bool {
        self.moves && self.model == Model::Spherical && self.range == JointRange::Any
    }

    /// Returns the number of the joint's columns in the Jacobian.
    pub(super) fn columns(&self) -> usize {
        if self.moves { self.model.dof_count() } else { 0 }
    }
}

/// The error of an invalid rig or pose.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RigError {
    /// A list of the wrong length.
    #[error("{what}: expected {expected}, one for each joint, found {found}")]
    Count {
        /// Name of the list.
        what: &'static str,
        /// Number of joints.
        expected: usize,
        /// Length of the list.
        found: usize,
    },
    /// An invalid value of a joint.
    #[error("joint {joint}: {what}")]
    Joint {
        /// Index of the joint.
        joint: usize,
        /// Description of the fault and of a valid value.
        what: &'static str,
    },
}

/// The rig in a pose: positions of the joints, and the axes along which they can move.
#[derive(Debug, Clone)]
pub(super) struct RigPose {
    /// Vector F: the positions of all joints, each times the square root of its weight.
    pub(super) f: DVector<f64>,
    pub(super) positions_m: Vec<DVec3>,
    /// Rotations of all bodies in the world.
    rotations: Vec<DQuat>,
    /// For each column, the joint and its motion.
    pub(super) axes: Vec<(usize, Axis)>,
}

impl Rig {
    /// Creates a rig of joints in regular numbering. The root's position and orientation are ignored.
    ///
    /// # Errors
    /// [`RigError::Joint`] if a weight is not from 0 to 1e6, an offset is not finite, a rotation or an axis is not of
    /// unit length, the axes of a universal joint are not perpendicular, a range does not fit the joint, a parent does
    /// not precede its child, or there is a second root.
    pub fn new(given: &[RigJoint]) -> Result<Self, RigError> {
        let expected = given.len();
        let mut joints = Vec::with_capacity(expected);
        for (joint, given) in given.iter().enumerate() {
            // This condition is written to refuse NaN.
            let what = if !(0.0..=1e6).contains(&given.weight) {
                "expected a weight from 0 to 1e6"
            } else if given.parent.map_or(joint > 0, |parent| parent >= joint) {
                "expected a parent that comes before it, and only one root"
            } else if !((given.rotation.length_squared() - 1.0).abs() < 1e-3
                && given.offset_m.is_finite())
            {
                "expected a finite offset and a unit quaternion"
            } else if given.kind.validate().is_err() {
                "expected unit axes, of a universal joint perpendicular ones"
            } else if !fits(given.range, given.kind.into()) {
                "expected a range that a joint of its kind can have, its first end not above its second"
            } else {
                joints.push(Joint {
                    parent: given.parent,
                    model: given.kind.into(),
                    rotation: given.rotation.normalize(),
                    offset_m: given.offset_m,
                    weight: given.weight,
                    range: limit::real(given.range),
                    moves: false,
                });
                continue;
            };
            return Err(RigError::Joint { joint, what });
        }
        // Whether a rotation or a translation of the joint moves a joint that has a weight.
        let mut carries = vec![false; expected];
        for index in (0..expected).rev() {
            let joint = &joints[index];
            let slides = matches!(joint.model, Model::Prismatic(_) | Model::Free);
            let counts = joint.weight > 0.0;
            let moves = carries[index] || (slides && counts);
            if let Some(parent) = joint.parent {
                carries[parent] |= carries[index] || counts;
            }
            joints[index].moves = moves && joints[index].parent.is_some();
        }
        let columns = joints.iter().map(Joint::columns).sum();
        Ok(Self { joints, columns })
    }

    /// Checks a pose, normalizes its quaternions and moves its joints into their ranges.
    ///
    /// # Errors
    /// [`RigError`] if there is not a finite state of the right kind for each joint.
    pub fn checked(&self, pose: &[JointPosition]) -> Result<Vec<JointPosition>, RigError> {
        if pose.len() != self.joints.len() {
            let (expected, found) = (self.joints.len(), pose.len());
            return Err(RigError::Count { what: "pose", expected, found });
        }
        let bad = self.joints.iter().zip(pose).position(|(joint, state)| !joint.model.has(state));
        if let Some(joint) = bad {
            let what = "expected a finite state of the joint's kind, with a unit quaternion";
            return Err(RigError::Joint { joint, what });
        }
        let unit: Vec<_> = pose.iter().map(|state| state.normalized()).collect();
        Ok(self.within(&unit, 0.0))
    }

    /// Returns the pose with each joint moved at least a share `margin` of its range's width away from the range's
    /// ends.
    pub(super) fn within(&self, pose: &[JointPosition], margin: f64) -> Vec<JointPosition> {
        let joints = self.joints.iter().zip(pose);
        joints.map(|(joint, state)| limit::within(state, joint.range, margin)).collect()
    }

    /// Returns the positions of all joints in a pose relative to the root, m.
    pub fn positions_m(&self, pose: &[JointPosition]) -> Vec<DVec3> {
        self.frames(pose).into_iter().map(|(_, _, position)| position).collect()
    }

    /// Returns, for each body, the rotation of its joint frame, its own rotation, and its position.
    fn frames(&self, pose: &[JointPosition]) -> Vec<(DQuat, DQuat, DVec3)> {
        let mut frames: Vec<(DQuat, DQuat, DVec3)> = Vec::with_capacity(self.joints.len());
        for (joint, state) in self.joints.iter().zip(pose) {
            let Some(parent) = joint.parent else {
                frames.push((DQuat::IDENTITY, DQuat::IDENTITY, DVec3::ZERO));
                continue;
            };
            let (_, of_parent, position) = frames[parent];
            let frame = of_parent * joint.rotation;
            let (turn, slide) = joint.model.pose(state);
            frames.push((
                frame,
                (frame * turn).normalize(),
                position + of_parent * joint.offset_m + frame * slide,
            ));
        }
        frames
    }

    /// Computes the positions of the joints in a pose, and their axes.
    pub(super) fn place(&self, pose: &[JointPosition]) -> RigPose {
        let frames = self.frames(pose);
        let mut axes = Vec::with_capacity(self.columns);
        let mut of_joint = Vec::new();
        for (index, (joint, state)) in self.joints.iter().zip(pose).enumerate() {
            if joint.moves {
                let (frame, body, _) = frames[index];
                joint.model.axes(state, joint.range, frame, body, &mut of_joint);
                axes.extend(of_joint.drain(..).map(|axis| (index, axis)));
            }
        }
        let (rotations, positions_m): (Vec<_>, Vec<_>) =
            frames.into_iter().map(|(_, rotation, position)| (rotation, position)).unzip();
        let weighted = self
            .joints
            .iter()
            .zip(&positions_m)
            .flat_map(|(joint, position)| (*position * libm::sqrt(joint.weight)).to_array());
        let f = DVector::from_iterator(3 * self.joints.len(), weighted);
        RigPose { f, positions_m, rotations, axes }
    }

    /// Returns whether `carried` is in the subtree of `joint`, or is the joint itself.
    pub(super) fn carries(&self, joint: usize, mut carried: usize) -> bool {
        while carried > joint {
            let Some(parent) = self.joints[carried].parent else { return false };
            carried = parent;
        }
        carried == joint
    }

    /// Returns the pose after a step along all axes.
    ///
    /// The body of a ball joint is rotated in the world by its angular velocity in the step. Since positions are
    /// sums of bones, their curvature then depends only on each bone's own rotation, not on products with the
    /// rotations of its ancestors. Joints of other kinds, and joints with a range, step in their own coordinates.
    pub(super) fn stepped(
        &self,
        pose: &[JointPosition],
        at: &RigPose,
        step: &[f64],
    ) -> Vec<JointPosition> {
        // For each body: its rotation after the step, and its angular velocity in the step.
        let mut after: Vec<(DQuat, DVec3)> = Vec::with_capacity(pose.len());
        let mut column = 0;
        let joints = self.joints.iter().zip(pose).enumerate();
        let stepped = joints.map(|(index, (joint, state))| {
            let Some(parent) = joint.parent else {
                after.push((DQuat::IDENTITY, DVec3::ZERO));
                return *state;
            };
            let columns = column..column + joint.columns();
            column = columns.end;
            let axes = at.axes[columns.clone()].iter().zip(&step[columns.clone()]);
            let turn =
                axes.fold(after[parent].1, |turn, ((_, axis), by)| turn + axis.angular * *by);
            let frame = after[parent].0 * joint.rotation;
            let state = if joint.turns_in_world() {
                let rotation = DQuat::from_scaled_axis(turn) * at.rotations[index];
                JointPosition::Turn((frame.conjugate() * rotation).normalize())
            } else if joint.moves {
                Model::stepped(state, joint.range, &step[columns])
            } else {
                *state
            };
            after.push(((frame * joint.model.pose(&state).0).normalize(), turn));
            state
        });
        stepped.collect()
    }

    /// Returns the limits of all moving joints with their gaps in a pose. Their order is the same in every pose.
    pub(super) fn limits(&self, pose: &[JointPosition]) -> Vec<Limit> {
        let mut column = 0;
        let mut limits = Vec::new();
        for (joint, state) in self.joints.iter().zip(pose).filter(|(joint, _)| joint.moves) {
            limit::of_joint(state, joint.range, column, &mut limits);
            column += joint.columns();
        }
        limits
    }

    /// Returns the pose at a share `t` of the path from one pose to another, each joint separately.
    pub(super) fn between(
        &self,
        from: &[JointPosition],
        to: &[JointPosition],
        t: f64,
    ) -> Vec<JointPosition> {
        let joints = self.joints.iter().zip(from.iter().zip(to));
        joints.map(|(joint, (from, to))| joint.model.between(joint.range, from, to, t)).collect()
    }
}

/// Returns whether a joint of this kind can have this range; false for NaN.
fn fits(range: JointRange, model: Model) -> bool {
    let ordered = |[least, most]: [f32; 2]| least <= most;
    match (range, model) {
        (JointRange::Any, _) => true,
        (JointRange::Axis(ends), Model::Revolute(_) | Model::Prismatic(_)) => ordered(ends),
        (JointRange::Axes(ends), Model::Universal(..)) => ends.into_iter().all(ordered),
        (JointRange::Turn(most), Model::Spherical) => most > 0.0 && most <= std::f32::consts::PI,
        _ => false,
    }
}
