//! Targets by forward differences of the bodies, from frames that arrive one after the other.

use glam::Vec3;

use crate::joint_targets::JointTargets;
use crate::kinematics::of_parent;
use crate::math;
use crate::pose_step::{rate, step};
use crate::state::{BodyState, JointState, StateInputError, checked_poses};
use crate::transform::{Transform, Twist};
use crate::tree::Tree;

/// A calculator of the targets of all joints at the first of three frames, by forward differences (13). Unlike
/// [`forward_targets`](crate::trajectory::forward_targets), it takes velocities from the *bodies'* world poses.
///
/// The world errors (4) and (10) compare these velocities. Velocities composed of differences of joint poses deviate
/// from them: they miss `h/2 ω_parent × ω_joint` (and a similar term of the positions), since the parent turns during
/// the step too.
///
/// The value keeps the data that two successive windows of frames share. Each step between frames is computed once.
///
/// ```
/// use sinew_core::{Body, ForwardDifferences, Inertia, JointKind, JointTargets, StateInputError};
/// use sinew_core::{Transform, Tree, glam::Vec3};
/// let slide = Body {
///     parent: None,
///     joint: JointKind::Prismatic { axis: Vec3::X },
///     placement: Transform::IDENTITY,
///     inertia: Inertia::default(),
///     rotor_inertia: 0.0,
/// };
/// let tree = Tree::<1>::from_bodies(&[slide]).map_err(|_| StateInputError::NoSuchJoint)?;
/// let frames = [0.0, 1.0, 3.0, 6.0].map(|x| [Transform::from_translation(Vec3::X * x)]);
/// let mut targets = JointTargets::rest(&tree);
/// let mut differences = ForwardDifferences::new();
/// differences.restart(&tree, 1.0, &frames[0])?;
/// // From the third frame on, each call gives the targets of two frames earlier.
/// differences.advance(&tree, &frames[1], &mut targets)?;
/// for (frame, speed) in [(2, 1.0), (3, 2.0)] {
///     differences.advance(&tree, &frames[frame], &mut targets)?;
///     assert_eq!(targets.states()[0].velocity.linear.x, speed);
///     assert_eq!(targets.accelerations()[0].linear.x, 1.0);
/// }
/// # Ok::<(), StateInputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ForwardDifferences<const N: usize> {
    rate_hz: f32,
    joints: [Remembered; N],
}

/// The data of the two newest frames that the next windows need.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Remembered {
    /// Pose of the joint in the older frame.
    older: Transform,
    /// Pose of the joint in the newer frame.
    newer: Transform,
    /// Mean velocity of the joint from the older frame to the newer.
    step: Twist,
    /// World pose of the body in the older frame.
    body: Transform,
}

impl Remembered {
    const NOTHING: Self = Self {
        older: Transform::IDENTITY,
        newer: Transform::IDENTITY,
        step: Twist::ZERO,
        body: Transform::IDENTITY,
    };
}

impl<const N: usize> ForwardDifferences<N> {
    /// Creates an empty value. Call [`Self::restart`] first.
    pub const fn new() -> Self {
        Self { rate_hz: 0.0, joints: [Remembered::NOTHING; N] }
    }

    /// Starts with a frame, as if the performance had stood still in it until now. `dt_s` is the time between
    /// frames, s. O(n).
    ///
    /// # Errors
    /// [`StateInputError`], and nothing changes, if the time step is not a positive number (at least 1e-9 s), the frame
    /// has fewer poses than the tree has joints, or a pose is not finite, has no unit rotation, or is more than 1e6 m
    /// from its parent.
    pub fn restart(
        &mut self,
        tree: &Tree<N>,
        dt_s: f32,
        frame: &[Transform],
    ) -> Result<(), StateInputError> {
        let (frame, rate_hz) = (checked_poses(frame, tree.len())?, rate(dt_s)?);
        self.rate_hz = rate_hz;
        for (index, (body, pose)) in tree.bodies().iter().zip(frame).enumerate() {
            let pose = with_unit_rotation(pose);
            let parent = of_parent(body, &self.joints, &Remembered::NOTHING).body;
            let Some(joint) = self.joints.get_mut(index) else { break };
            let body = parent * pose;
            *joint = Remembered { older: pose, newer: pose, step: Twist::ZERO, body };
        }
        Ok(())
    }

    /// Accepts the next frame while there are not yet two earlier frames, and writes no targets. O(n).
    ///
    /// # Errors
    /// [`StateInputError`], and nothing changes, in the cases of [`Self::restart`] for a frame.
    pub(crate) fn lead(
        &mut self,
        tree: &Tree<N>,
        frame: &[Transform],
    ) -> Result<(), StateInputError> {
        let frame = checked_poses(frame, tree.len())?;
        for (index, (body, newest)) in tree.bodies().iter().zip(frame).enumerate() {
            let parent = of_parent(body, &self.joints, &Remembered::NOTHING).body;
            let Some(joint) = self.joints.get_mut(index) else { break };
            joint.body = parent * joint.newer;
            let newest = with_unit_rotation(newest);
            joint.step = step(&joint.newer, &newest, self.rate_hz);
            (joint.older, joint.newer) = (joint.newer, newest);
        }
        Ok(())
    }

    /// Accepts the next frame, and writes the targets of the frame two before it. O(n).
    ///
    /// # Errors
    /// [`StateInputError`], and nothing changes, if the frame has fewer poses than the tree has joints, a pose is not
    /// finite, has no unit rotation, or is more than 1e6 m from its parent, the targets are for fewer joints, or
    /// [`Self::restart`] was not called.
    pub fn advance(
        &mut self,
        tree: &Tree<N>,
        frame: &[Transform],
        out: &mut JointTargets<N>,
    ) -> Result<(), StateInputError> {
        let frame = checked_poses(frame, tree.len())?;
        if out.states().len() < tree.len() {
            return Err(StateInputError::NoSuchJoint);
        }
        let rate_hz = self.rate_hz;
        if rate_hz <= 0.0 {
            return Err(StateInputError::TimeStep);
        }
        let (states, accelerations, bodies) = out.whole(tree);
        for (index, (body, state)) in tree.bodies().iter().zip(states.iter_mut()).enumerate() {
            // The parent has already advanced to the newer frame.
            let parent_after = of_parent(body, &self.joints, &Remembered::NOTHING).body;
            let Some(joint) = self.joints.get_mut(index) else { break };
            let after = parent_after * joint.newer;
            let now = joint.body;
            joint.body = after;

            let of_body = BodyState {
                pose: now,
                velocity: Twist {
                    angular: math::log(math::turn_in_world(now.rotation, after.rotation)) * rate_hz,
                    linear: (after.translation_m - now.translation_m) * rate_hz,
                },
            };
            let velocity = of_body.velocity_from(of_parent(body, bodies, &BodyState::WORLD));
            *state = JointState { pose: joint.older, velocity };
            let Some(slot) = bodies.get_mut(index) else { break };
            *slot = of_body;
        }
        // A separate loop, because a single loop would need more registers than the processor has.
        for (((body, newest), joint), acceleration) in
            tree.bodies().iter().zip(frame).zip(&mut self.joints).zip(accelerations)
        {
            let newest = with_unit_rotation(newest);
            let leads = step(&joint.newer, &newest, rate_hz);
            let change = (leads - joint.step) * rate_hz;
            acceleration.angular = change.angular;
            acceleration.linear = if body.joint.slides() {
                math::rotate(joint.older.rotation.conjugate(), change.linear)
            } else {
                Vec3::ZERO
            };
            joint.older = joint.newer;
            joint.newer = newest;
            joint.step = leads;
        }
        Ok(())
    }

    /// Returns the last step of each joint. Another difference method may use them as storage while this value is
    /// unused. A restart overwrites them.
    pub(crate) fn steps_mut(&mut self) -> impl Iterator<Item = &mut Twist> {
        self.joints.iter_mut().map(|joint| &mut joint.step)
    }
}

impl<const N: usize> Default for ForwardDifferences<N> {
    fn default() -> Self {
        Self::new()
    }
}

#[inline]
fn with_unit_rotation(pose: &Transform) -> Transform {
    Transform { rotation: math::unit(pose.rotation), ..*pose }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::forward_targets;
    use crate::{Body, Inertia, JointKind, kinematics};

    #[test]
    fn targets_of_bodies_move_as_the_bodies_do() {
        let body = |parent| Body {
            parent,
            joint: if parent.is_none() { JointKind::Free } else { JointKind::Spherical },
            placement: Transform::IDENTITY,
            inertia: Inertia::default(),
            rotor_inertia: 0.0,
        };
        let tree = Tree::<3>::from_bodies(&[body(None), body(Some(0)), body(Some(1))]).unwrap();
        let joint = |turn: Vec3| Transform::new(math::exp(turn), Vec3::new(0.3, -0.1, 0.0));
        let frame = |t: f32| {
            [
                Vec3::new(0.2, 4.0 * t, 0.0),
                Vec3::new(-7.0 * t, 0.3, 0.0),
                Vec3::new(0.1, 0.0, 9.0 * t),
            ]
            .map(joint)
        };
        let h = 0.01;
        let frames = [0.0, h, 2.0 * h].map(frame);
        let window = frames.each_ref().map(<[Transform; 3]>::as_slice);
        let mut targets = JointTargets::rest(&tree);
        let mut differences = ForwardDifferences::new();
        differences.restart(&tree, h, window[0]).unwrap();
        for frame in &window[1..] {
            differences.advance(&tree, frame, &mut targets).unwrap();
        }

        let [now, next] = [frames[0], frames[1]].map(|joints| {
            let mut pose = Transform::IDENTITY;
            joints.map(|joint| {
                pose = pose * joint;
                pose
            })
        });
        let mut states = [BodyState::WORLD; 3];
        kinematics::body_states(tree.bodies(), targets.states(), &mut states);
        for (state, (now, next)) in states.iter().zip(now.iter().zip(&next)) {
            let angular = math::log(next.rotation * now.rotation.conjugate()) / h;
            let linear = (next.translation_m - now.translation_m) / h;
            // Tolerance: a few times the f32 rounding of a quaternion and of a position of about 0.5 m, divided by h.
            assert!((state.velocity.angular - angular).length() < 1e-4);
            assert!((state.velocity.linear - linear).length() < 1e-4);
        }
        // Differences of the joints' poses compose to another velocity: the reason for this type.
        forward_targets(window, h, &mut targets).unwrap();
        kinematics::body_states(tree.bodies(), targets.states(), &mut states);
        let angular = math::log(next[2].rotation * now[2].rotation.conjugate()) / h;
        assert!((states[2].velocity.angular - angular).length() > 0.1);
    }
}
