//! One joint in a projection: its start, its allowed motions, and its step.

use glam::Vec3;

use super::JointRange;
use crate::dynamics::least_constraint::{Axis, Hinge, MotionSubspace, Response};
use crate::joint::JointKind;
use crate::math;
use crate::transform::{Transform, Twist};
use crate::tree::Body;

/// Maximum rotation (rad) or displacement (m) of a joint in one sweep, because a sweep is exact only to first order.
const LONGEST_STEP: f32 = 0.5;

/// State of a joint that is kept from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Joint {
    /// Pose of the solution, in the parent's frame.
    pub(super) pose: Transform,
    /// The solution relative to the desired pose; the next frame starts with it. Without a step its bits do not
    /// change. For a prismatic joint the displacement is in the parent's axes.
    deviation: Transform,
    /// Angles or displacements of a joint with one or two axes, rad or m.
    along: [f32; 2],
    /// Axes that the last sweep pressed against the end of the range, one bit each.
    pressed: u8,
}

impl Joint {
    /// Initial state: exactly the desired pose.
    pub(super) const NEW: Self = Self {
        pose: Transform::IDENTITY,
        deviation: Transform::IDENTITY,
        along: [0.0; 2],
        pressed: 0,
    };

    /// Starts from the new desired pose with the last solution's deviation, as far as the joint and its range allow.
    pub(super) fn start(&mut self, body: &Body, range: &JointRange, desired: &Transform) {
        let start = *desired * self.deviation;
        match body.joint {
            JointKind::Free => self.pose = if start.is_finite() { start } else { *desired },
            JointKind::Spherical => {
                self.pose = Transform { rotation: start.rotation, ..body.placement };
                self.keep_turn_within(body, range, desired);
            }
            JointKind::Revolute { axis } => {
                let in_joint = body.placement.rotation.conjugate() * start.rotation;
                let twist = if *range == JointRange::Any {
                    math::twist_about(axis, in_joint)
                } else {
                    self.along = range.clamp([math::turn_about(axis, in_joint), 0.0]);
                    math::exp(axis * self.along[0])
                };
                self.pose =
                    Transform { rotation: body.placement.rotation * twist, ..body.placement };
            }
            kind => {
                let translation_m = desired.translation_m + self.deviation.translation_m;
                let in_joint = body.placement.inverse() * Transform { translation_m, ..start };
                let along = kind.along(&in_joint);
                if along.iter().all(|x| x.is_finite()) {
                    self.along = range.clamp(along);
                }
                self.go_along(body);
            }
        }
    }

    /// Returns `true` if the joint allows any rotation and nothing else: a spherical joint that is not pressed against
    /// the end of its range.
    pub(super) fn is_free_ball(&self, body: &Body) -> bool {
        matches!(body.joint, JointKind::Spherical) && !self.is_pressed()
    }

    /// Returns the motions that the joint allows, in world axes. `pose` is the world pose of its body.
    pub(super) fn dofs(&self, body: &Body, pose: &Transform) -> MotionSubspace {
        let held = |index: u8| self.pressed & (1 << index) != 0;
        match body.joint {
            JointKind::Free => MotionSubspace::Free,
            JointKind::Spherical if held(0) => {
                // The first axis points towards the border of the range. The two other axes are perpendicular to
                // it, and are not limited.
                let from_zero = body.placement.rotation.conjugate() * self.pose.rotation;
                let out = pose.rotation * direction(math::log(from_zero));
                let helper = if out.x.abs() < 0.7 { Vec3::X } else { Vec3::Y };
                let across = direction(out.cross(helper));
                let turns = [(out, true), (across, false), (out.cross(across), false)];
                MotionSubspace::Axes(
                    turns
                        .map(|(axis, held)| Axis { motion: Twist::new(axis, Vec3::ZERO), held })
                        .into_iter()
                        .collect(),
                )
            }
            JointKind::Spherical => MotionSubspace::Ball,
            // Like the other kinds below, but independent of the pose.
            JointKind::Revolute { axis } => MotionSubspace::Hinge(Hinge {
                axis: math::rotate(pose.rotation, axis),
                held: held(0),
            }),
            kind => {
                let subspace = kind.motion_subspace(kind.at(self.along).rotation);
                MotionSubspace::Axes(
                    (0..)
                        .zip(&subspace)
                        .take(2)
                        .map(|(index, motion)| Axis {
                            motion: motion.rotated(pose.rotation),
                            held: held(index),
                        })
                        .collect(),
                )
            }
        }
    }

    /// Returns `true` if the last sweep pressed the joint against the end of its range.
    pub(super) fn is_pressed(&self) -> bool {
        self.pressed != 0
    }

    /// Moves the joint by a sweep's response and returns the motion of its body, in world axes. `pose` is the world
    /// pose of the body. `carried` is the body's motion with its parent.
    ///
    /// A step that is not finite (inputs near the limit of f32) is ignored.
    pub(super) fn step(
        &mut self,
        body: &Body,
        range: &JointRange,
        desired: &Transform,
        pose: &Transform,
        response: &Response,
        carried: Twist,
    ) -> Twist {
        match body.joint {
            JointKind::Spherical => {
                let angular = match response {
                    Response::Ball(ball) => ball.turn(carried.linear),
                    response => response.motion(carried, |_, step| step).angular,
                };
                let turn = within(angular - carried.angular, LONGEST_STEP);
                if !math::is_finite(turn) {
                    return carried;
                }
                self.turn_by(desired, pose, turn);
                let kept = self.keep_turn_within(body, range, desired);
                self.pressed = u8::from(kept.is_some());
                let angular = match kept {
                    // The part of the step that remains.
                    Some(back) => carried.angular + (turn + pose.rotation * back),
                    None => carried.angular + turn,
                };
                Twist { angular, ..carried }
            }
            JointKind::Free => {
                let motion = response.motion(carried, |_, step| step);
                let turn = within(motion.angular - carried.angular, LONGEST_STEP);
                let way = within(motion.linear - carried.linear, LONGEST_STEP);
                if !(math::is_finite(turn) && math::is_finite(way)) {
                    return carried;
                }
                let to_desired = self.deviation.rotation * pose.rotation.conjugate();
                self.turn_by(desired, pose, turn);
                self.deviation.translation_m += to_desired * way;
                let translation_m = desired.transform_point(self.deviation.translation_m);
                if math::is_finite(translation_m) {
                    self.pose.translation_m = translation_m;
                }
                carried + Twist::new(turn, way)
            }
            JointKind::Revolute { axis } => {
                self.pressed = 0;
                let mut turn = 0.0;
                let motion = response.motion(carried, |_, step| {
                    turn = if *range == JointRange::Any && step.is_finite() {
                        step.clamp(-LONGEST_STEP, LONGEST_STEP)
                    } else {
                        self.step_along(0, range, step)
                    };
                    turn
                });
                self.pose.rotation = math::unit(self.pose.rotation * math::exp(axis * turn));
                self.deviation.rotation = math::turn_in_body(desired.rotation, self.pose.rotation);
                motion
            }
            kind => {
                self.pressed = 0;
                let motion =
                    response.motion(carried, |index, step| self.step_along(index, range, step));
                self.go_along(body);
                self.deviation.rotation =
                    math::unit(desired.rotation.conjugate() * self.pose.rotation);
                if let JointKind::Prismatic { .. } = kind {
                    // Only the part along the axis is used: the part across it comes from the dimensions of the
                    // other figure, and would only add rounding.
                    let wanted = kind.along(&(body.placement.inverse() * *desired));
                    let off = kind.at(self.along).translation_m - kind.at(wanted).translation_m;
                    if off.is_finite() {
                        self.deviation.translation_m = body.placement.rotation * off;
                    }
                }
                motion
            }
        }
    }

    /// Rotates the body, and updates its deviation from the desired pose. `turn` is in world axes.
    #[inline]
    fn turn_by(&mut self, desired: &Transform, pose: &Transform, turn: Vec3) {
        let in_body = math::rotate(pose.rotation.conjugate(), turn);
        self.deviation.rotation = math::unit(self.deviation.rotation * math::exp(in_body));
        self.pose.rotation = desired.rotation * self.deviation.rotation;
    }

    /// Moves a step along an axis, limited by the range, and returns the actual step. A NaN step is ignored.
    fn step_along(&mut self, index: usize, range: &JointRange, step: f32) -> f32 {
        let Some(now) = self.along.get_mut(index).filter(|_| step.is_finite()) else { return 0.0 };
        let wanted = *now + step.clamp(-LONGEST_STEP, LONGEST_STEP);
        let [least, most] = range.ends(index);
        let next = wanted.max(least).min(most);
        if wanted < least || wanted > most {
            self.pressed |= if index == 0 { 1 } else { 2 };
        }
        let made = next - *now;
        *now = next;
        made
    }

    /// Sets the pose from the angles or displacements. A pose that is not finite is replaced by the zero pose.
    fn go_along(&mut self, body: &Body) {
        let pose = body.placement * body.joint.at(self.along);
        self.pose = if pose.is_finite() { pose } else { body.placement };
    }

    /// Moves a spherical joint back into its range. Returns the correction, in body axes, if the joint was outside.
    fn keep_turn_within(
        &mut self,
        body: &Body,
        range: &JointRange,
        desired: &Transform,
    ) -> Option<Vec3> {
        let JointRange::Turn(most_rad) = *range else { return None };
        let from_zero = math::log(body.placement.rotation.conjugate() * self.pose.rotation);
        let angle = math::length(from_zero);
        if angle <= most_rad {
            return None;
        }
        let back = from_zero * (most_rad / angle - 1.0);
        let kept = math::exp(from_zero + back);
        self.pose.rotation = math::unit(body.placement.rotation * kept);
        self.deviation.rotation = math::unit(desired.rotation.conjugate() * self.pose.rotation);
        Some(back)
    }
}

/// Shortens a vector to a maximum length.
fn within(v: Vec3, length: f32) -> Vec3 {
    let squared = v.dot(v);
    if squared > length * length { v * (length / math::sqrt(squared)) } else { v }
}

/// Returns the unit vector in the direction of `v`; X if `v` is zero.
fn direction(v: Vec3) -> Vec3 {
    let length = math::length(v);
    if length > 0.0 { v / length } else { Vec3::X }
}
