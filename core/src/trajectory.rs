//! A performance as frames of joint poses, and targets from these frames.

use core::fmt;

use glam::Vec3;

use crate::joint_states::JointStates;
use crate::joint_targets::JointTargets;
use crate::math;
use crate::pose_step::{in_axes_of, rate, step};
use crate::state::{JointState, StateInputError, check_pose};
use crate::transform::{Transform, Twist};

/// Evenly spaced frames of the poses of all joints, each in its parent's frame.
///
/// The type borrows its frames, so a baked performance can stay in flash.
///
/// ```
/// use sinew_core::{Trajectory, TrajectoryError, Transform, glam::Vec3};
/// let frames = [0.0, 0.1, 0.4].map(|x| Transform::from_translation(Vec3::new(x, 0.0, 0.0)));
/// let slide = Trajectory::new(&frames, 1, 0.01)?;
/// let mut pose = [Transform::IDENTITY];
/// slide.sample(0.005, &mut pose);
/// assert_eq!(pose[0].translation_m.x, 0.05);
/// # Ok::<(), TrajectoryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trajectory<'a> {
    poses: &'a [Transform],
    joint_count: usize,
    dt_s: f32,
}

impl<'a> Trajectory<'a> {
    /// Validates consecutive frames, each with the poses of `joint_count` joints, `dt_s` seconds apart. O(frames):
    /// every pose is checked once.
    ///
    /// # Errors
    /// [`TrajectoryError`] if the poses are not one or more whole frames, a pose is not finite or its rotation is not
    /// unit, or the time step is not a positive number.
    pub fn new(
        poses: &'a [Transform],
        joint_count: usize,
        dt_s: f32,
    ) -> Result<Self, TrajectoryError> {
        if !(dt_s.is_finite() && dt_s > 0.0) {
            return Err(TrajectoryError::TimeStep);
        }
        let remainder = poses.len().checked_rem(joint_count);
        if poses.is_empty() || remainder != Some(0) {
            return Err(TrajectoryError::Count { joints: joint_count, poses: poses.len() });
        }
        let usable = |pose: &Transform| pose.is_finite() && math::is_unit(pose.rotation);
        let bad = poses.iter().position(|pose| !usable(pose));
        if let Some(index) = bad {
            return Err(TrajectoryError::InvalidPose {
                frame: index.checked_div(joint_count).unwrap_or_default(),
                joint: index.checked_rem(joint_count).unwrap_or_default(),
            });
        }
        Ok(Self { poses, joint_count, dt_s })
    }

    /// Returns the number of frames, at least one.
    pub fn len(&self) -> usize {
        self.poses.len().checked_div(self.joint_count).unwrap_or_default()
    }

    /// Returns `false`: a trajectory has at least one frame.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// Returns the time between frames, s.
    pub fn dt_s(&self) -> f32 {
        self.dt_s
    }

    /// Returns the poses of a frame by joint; the last frame for any index beyond it.
    pub fn frame(&self, index: usize) -> &'a [Transform] {
        let index = index.min(self.len().saturating_sub(1));
        let start = index.saturating_mul(self.joint_count);
        self.poses.get(start..start.saturating_add(self.joint_count)).unwrap_or_default()
    }

    /// Writes the poses at a time, spherically interpolated between frames. Before the start the first frame is held,
    /// after the end the last. A NaN time gives the first frame. O(joints).
    pub fn sample(&self, time_s: f32, out: &mut [Transform]) {
        let last = self.len().saturating_sub(1);
        // A conversion from float to integer saturates, and NaN becomes 0: both are intended.
        let position = time_s / self.dt_s;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the whole part is wanted, negative and huge times saturate"
        )]
        let index = position as usize;
        let (index, fraction) =
            if index >= last { (last, 0.0) } else { (index, fraction_of(position)) };
        let from = self.frame(index);
        let to = self.frame(index.saturating_add(1));
        for ((from, to), pose) in from.iter().zip(to).zip(out) {
            *pose = interpolate(from, to, fraction);
            if !pose.translation_m.is_finite() {
                // The difference of positions at opposite limits of f32 overflows.
                pose.translation_m = from.translation_m;
            }
        }
    }

    /// Writes the targets at frame `index` by forward differences, as in the paper (13): they need two later frames,
    /// and the last frame is held after the end. O(joints).
    ///
    /// A performance that ends in motion is therefore stopped within one frame: let it end at rest.
    ///
    /// # Errors
    /// [`StateInputError`] if the targets are for fewer joints, or differences overflow.
    ///
    /// ```
    /// use sinew_core::{JointTargets, Trajectory, Transform, glam::Vec3};
    /// # use sinew_core::{Body, Inertia, JointKind, Tree};
    /// # let joint = JointKind::Prismatic { axis: Vec3::X };
    /// # let (placement, inertia) = (Transform::IDENTITY, Inertia::default());
    /// # let slide = Body { parent: None, joint, placement, inertia, rotor_inertia: 0.0 };
    /// let tree = Tree::<1>::from_bodies(&[slide])?;
    /// let frames = [0.0, 1.0, 3.0].map(|x| Transform::from_translation(Vec3::X * x));
    /// let performance = Trajectory::new(&frames, 1, 1.0)?;
    /// let mut targets = JointTargets::rest(&tree);
    /// performance.targets(0, &mut targets)?;
    /// // Forward differences: 1 m in the next second, and 1 m more than that in the second after it.
    /// let (velocity, acceleration) = (targets.states()[0].velocity, targets.accelerations()[0]);
    /// assert_eq!((velocity.linear.x, acceleration.linear.x), (1.0, 1.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn targets<const N: usize>(
        &self,
        index: usize,
        out: &mut JointTargets<N>,
    ) -> Result<(), StateInputError> {
        let window = [0, 1, 2].map(|ahead| self.frame(index.saturating_add(ahead)));
        forward_targets(window, self.dt_s, out)
    }
}

/// Returns the fraction of a position between two frames, in [0, 1).
fn fraction_of(position: f32) -> f32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        reason = "the position is below the number of frames, which f32 holds"
    )]
    let whole = position as i32 as f32;
    if position > whole { position - whole } else { 0.0 }
}

/// Returns the pose at a fraction of the way from one pose to the other: the position on the straight line, the
/// rotation on the great arc.
///
/// The position is not finite if the difference is too large for f32.
///
/// ```
/// use sinew_core::{Transform, glam::Vec3};
/// let there = Transform::from_translation(Vec3::X);
/// let half_way = sinew_core::trajectory::interpolate(&Transform::IDENTITY, &there, 0.5);
/// assert_eq!(half_way.translation_m, Vec3::X * 0.5);
/// ```
pub fn interpolate(from: &Transform, to: &Transform, fraction: f32) -> Transform {
    let way = to.translation_m - from.translation_m;
    Transform {
        rotation: math::slerp(from.rotation, to.rotation, fraction),
        translation_m: from.translation_m + way * fraction,
    }
}

/// Returns the pose at a fraction of the way from the second to the third of four evenly spaced frames, on a smooth
/// path through all of them. The velocities of this path are continuous; with [`interpolate`], velocities and thus
/// torques jump at every frame.
///
/// Cubic Hermite interpolation with central differences as velocities (Catmull and Rom 1974). Rotations use the
/// logarithm from the second frame, `φ̇(1) = J_r⁻¹(φ(1)) ω`, with the inverse right Jacobian to third order in the
/// rotation between frames. The error is 1e-4 of the velocity at 0.5 rad.
///
/// The position is not finite if differences are too large for f32.
///
/// ```
/// use sinew_core::{Transform, glam::Vec3, trajectory::interpolate_smoothly};
/// let frames = [0.0f32, 1.0, 4.0, 9.0].map(|x| Transform::from_translation(Vec3::X * x));
/// let half_way = interpolate_smoothly(frames.each_ref(), 0.5);
/// assert_eq!(half_way.translation_m.x, 2.25); // 1.5²
/// ```
pub fn interpolate_smoothly(window: [&Transform; 4], fraction: f32) -> Transform {
    let [before, from, to, after] = window;
    let hermite = |start: Vec3, way: Vec3, end: Vec3| {
        let curve = start + end - way * 2.0;
        let bend = way - start - curve;
        ((curve * fraction + bend) * fraction + start) * fraction
    };
    let way = to.translation_m - from.translation_m;
    let start = (to.translation_m - before.translation_m) * 0.5;
    let end = (after.translation_m - from.translation_m) * 0.5;

    let turn =
        |from: &Transform, to: &Transform| math::log(from.rotation.conjugate() * to.rotation);
    let turns = [turn(before, from), turn(from, to), turn(to, after)];
    let [led_here, here, leads_on] = turns;
    let across = here.cross((here + leads_on) * 0.5);
    let end_rate = (here + leads_on) * 0.5 + across * 0.5 + here.cross(across) * (1.0 / 12.0);
    let turned = math::exp(hermite((led_here + here) * 0.5, here, end_rate));
    Transform {
        rotation: math::unit(from.rotation * turned),
        translation_m: from.translation_m + hermite(start, way, end),
    }
}

/// Computes the targets of all joints at the first of three frames, by forward differences (13): velocities need one
/// later frame, accelerations two. O(n).
///
/// # Errors
/// [`StateInputError`], and this joint and later joints are unchanged, if a pose is not finite, has no unit rotation,
/// or is more than 1e6 m from its parent, the time step is below 1e-9 s or not finite, or the targets are for fewer
/// joints.
pub fn forward_targets<const N: usize>(
    [now, next, after]: [&[Transform]; 3],
    dt_s: f32,
    out: &mut JointTargets<N>,
) -> Result<(), StateInputError> {
    let rate_hz = rate(dt_s)?;
    for (joint, ((now, next), after)) in now.iter().zip(next).zip(after).enumerate() {
        let [first, second] = steps([now, next, after], rate_hz)?;
        put_difference(out, joint, now, first, (second - first) * rate_hz)?;
    }
    Ok(())
}

/// Computes the targets of all joints at the *middle* of three frames, aligned with the motion of a controlled rig.
/// The velocity is the backward difference, like that of a measurement. The acceleration is the central difference,
/// which leads from that velocity to the next frame.
///
/// A rig that is at the previous frame and then at this frame, and gets this acceleration for one period (velocity
/// first, then position: semi-implicit Euler), reaches the next frame exactly. Forward differences lead by half a
/// period or more, and the controller's response to this lead is most of the error if the model is good.
///
/// Use it for performances whose next frame is known, and for live streams that may have a delay of one frame.
/// O(n).
///
/// # Errors
/// As in [`forward_targets`].
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, JointTargets, StateInputError, Transform, Tree};
/// use sinew_core::{glam::Vec3, trajectory::aligned_targets};
/// let slide = Body {
///     parent: None,
///     joint: JointKind::Prismatic { axis: Vec3::X },
///     placement: Transform::IDENTITY,
///     inertia: Inertia::default(),
///     rotor_inertia: 0.0,
/// };
/// let tree = Tree::<1>::from_bodies(&[slide]).map_err(|_| StateInputError::NoSuchJoint)?;
/// let frames = [0.0, 1.0, 3.0].map(|x| [Transform::from_translation(Vec3::X * x)]);
/// let mut targets = JointTargets::rest(&tree);
/// aligned_targets(frames.each_ref().map(|frame| &frame[..]), 1.0, &mut targets)?;
/// let (velocity, acceleration) = (targets.states()[0].velocity, targets.accelerations()[0]);
/// // 1 m + (1 m/s + 1 m/s²) 1 s = 3 m
/// assert_eq!((velocity.linear.x, acceleration.linear.x), (1.0, 1.0));
/// # Ok::<(), StateInputError>(())
/// ```
pub fn aligned_targets<const N: usize>(
    window: [&[Transform]; 3],
    dt_s: f32,
    out: &mut JointTargets<N>,
) -> Result<(), StateInputError> {
    let [before, now, next] = window;
    let rate_hz = rate(dt_s)?;
    for (joint, ((before, now), next)) in before.iter().zip(now).zip(next).enumerate() {
        let [first, second] = steps([before, now, next], rate_hz)?;
        put_difference(out, joint, now, first, (second - first) * rate_hz)?;
    }
    Ok(())
}

/// Computes the targets of all joints at the *last* of three frames, by backward differences: for a live stream,
/// whose next frame is unknown. The acceleration is that of one period ago, and it amplifies noise of the stream.
///
/// If the stream may have a delay of one frame, [`aligned_targets`] on the same three frames is far better. O(n).
///
/// # Errors
/// As in [`forward_targets`].
///
/// ```
/// use sinew_core::{JointTargets, Transform, glam::Vec3, trajectory::live_targets};
/// # use sinew_core::{Body, Inertia, JointKind, Tree};
/// # let joint = JointKind::Prismatic { axis: Vec3::X };
/// # let (placement, inertia) = (Transform::IDENTITY, Inertia::default());
/// # let slide = Body { parent: None, joint, placement, inertia, rotor_inertia: 0.0 };
/// let tree = Tree::<1>::from_bodies(&[slide])?;
/// let frames = [0.0, 1.0, 3.0].map(|x| [Transform::from_translation(Vec3::X * x)]);
/// let mut targets = JointTargets::rest(&tree);
/// live_targets(frames.each_ref().map(|frame| &frame[..]), 1.0, &mut targets)?;
/// // State at the last frame, with the velocity that led to it.
/// let state = targets.states()[0];
/// assert_eq!((state.pose.translation_m.x, state.velocity.linear.x), (3.0, 2.0));
/// assert_eq!(targets.accelerations()[0].linear.x, 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn live_targets<const N: usize>(
    [earlier, before, now]: [&[Transform]; 3],
    dt_s: f32,
    out: &mut JointTargets<N>,
) -> Result<(), StateInputError> {
    let rate_hz = rate(dt_s)?;
    for (joint, ((earlier, before), now)) in earlier.iter().zip(before).zip(now).enumerate() {
        let [first, second] = steps([earlier, before, now], rate_hz)?;
        put_difference(out, joint, now, second, (second - first) * rate_hz)?;
    }
    Ok(())
}

/// Computes the measured states of all joints at the second of two frames, by backward differences: the best that
/// joint sensors give without a model. O(n).
///
/// # Errors
/// [`StateInputError`], and this joint and later joints are unchanged, if a pose is not finite, has no unit rotation,
/// or is more than 1e6 m from its parent, the time step is below 1e-9 s or not finite, or the states are for fewer
/// joints.
///
/// ```
/// use sinew_core::{JointStates, Transform, glam::Vec3, trajectory::backward_states};
/// # use sinew_core::{Body, Inertia, JointKind, Tree};
/// # let joint = JointKind::Prismatic { axis: Vec3::X };
/// # let (placement, inertia) = (Transform::IDENTITY, Inertia::default());
/// # let slide = Body { parent: None, joint, placement, inertia, rotor_inertia: 0.0 };
/// let tree = Tree::<1>::from_bodies(&[slide])?;
/// let frames = [0.0, 0.5].map(|x| [Transform::from_translation(Vec3::X * x)]);
/// let mut measured = JointStates::rest(&tree);
/// backward_states([&frames[0], &frames[1]], 0.25, &mut measured)?;
/// assert_eq!(measured.as_slice()[0].velocity.linear.x, 2.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn backward_states<const N: usize>(
    [before, now]: [&[Transform]; 2],
    dt_s: f32,
    out: &mut JointStates<N>,
) -> Result<(), StateInputError> {
    let rate_hz = rate(dt_s)?;
    for (joint, (before, now)) in before.iter().zip(now).enumerate() {
        check_pose(before)?;
        check_pose(now)?;
        let velocity = in_axes_of(now, step(before, now, rate_hz));
        out.put(joint, JointState { pose: *now, velocity })?;
    }
    Ok(())
}

/// Checks three poses and returns the two steps between them.
#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
fn steps(
    [first, second, third]: [&Transform; 3],
    rate_hz: f32,
) -> Result<[Twist; 2], StateInputError> {
    check_pose(first)?;
    check_pose(second)?;
    check_pose(third)?;
    Ok([step(first, second, rate_hz), step(second, third, rate_hz)])
}

#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
pub(crate) fn put_difference<const N: usize>(
    out: &mut JointTargets<N>,
    joint: usize,
    pose: &Transform,
    velocity: Twist,
    acceleration: Twist,
) -> Result<(), StateInputError> {
    let state = JointState { pose: *pose, velocity: in_axes_of(pose, velocity) };
    out.put(joint, state, in_axes_of(pose, acceleration))
}

/// An error in the frames of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TrajectoryError {
    /// The poses are not one or more whole frames.
    Count {
        /// Number of joints in a frame.
        joints: usize,
        /// Number of poses.
        poses: usize,
    },
    /// A pose is not finite, or its rotation not a unit quaternion.
    InvalidPose {
        /// Index of the frame.
        frame: usize,
        /// Index of the joint.
        joint: usize,
    },
    /// The time step is not a positive number.
    TimeStep,
}

impl fmt::Display for TrajectoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { joints, poses } => {
                write!(f, "{poses} poses are not one or more whole frames of {joints} joints")
            }
            Self::InvalidPose { frame, joint } => write!(
                f,
                "frame {frame}, joint {joint}: the pose is not finite or its rotation not a unit quaternion"
            ),
            Self::TimeStep => f.write_str("the time step must be a positive number of seconds"),
        }
    }
}

impl core::error::Error for TrajectoryError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, Inertia, JointKind, Tree};

    fn turning(k: f32) -> Transform {
        Transform::new(math::exp(Vec3::new(0.0, 0.02 * k, 0.0)), Vec3::new(0.01 * k * k, 0.0, 0.0))
    }

    #[test]
    fn targets_look_ahead_and_hold_at_the_end() {
        let frames = [0.0, 1.0, 2.0].map(turning);
        let trajectory = Trajectory::new(&frames, 1, 0.01).unwrap();
        let root = Body {
            parent: None,
            joint: JointKind::Free,
            placement: Transform::IDENTITY,
            inertia: Inertia::default(),
            rotor_inertia: 0.0,
        };
        let tree = Tree::<1>::from_bodies(&[root]).unwrap();
        let mut targets = JointTargets::rest(&tree);
        trajectory.targets(0, &mut targets).unwrap();
        let (state, acceleration) = (targets.states()[0], targets.accelerations()[0]);
        // Tolerance: f32 rounding of 0.02 m over h² = 1e-4 s²: 2e-5 m/s²; of a quaternion: 1e-3 rad/s².
        assert!((state.velocity.angular.y - 2.0).abs() < 5e-5);
        assert!((state.velocity.linear.x - 1.0).abs() < 1e-5);
        assert!((acceleration.linear.x - 200.0).abs() < 1e-3);
        assert!(acceleration.angular.length() < 5e-3);
        trajectory.targets(2, &mut targets).unwrap();
        assert_eq!(targets.states()[0].velocity, Twist::ZERO);

        let mut measured = JointStates::rest(&tree);
        backward_states([&frames[0..1], &frames[1..2]], 0.01, &mut measured).unwrap();
        assert!((measured.as_slice()[0].velocity.angular.y - 2.0).abs() < 5e-5);
        for dt_s in [0.0, -0.01, f32::NAN] {
            let window = [&frames[0..1], &frames[1..2]];
            assert_eq!(
                backward_states(window, dt_s, &mut measured),
                Err(StateInputError::TimeStep)
            );
        }
    }

    #[test]
    fn sampling_interpolates_and_holds() {
        let frames = [0.0, 1.0, 2.0].map(turning);
        let trajectory = Trajectory::new(&frames, 1, 0.5).unwrap();
        let at = |time_s: f32| {
            let mut pose = [Transform::IDENTITY];
            trajectory.sample(time_s, &mut pose);
            pose[0]
        };
        assert!((at(0.75).translation_m.x - 0.025).abs() < 1e-7);
        assert!((math::log(at(0.25).rotation).y - 0.01).abs() < 1e-7);
        for (time, frame) in [(-3.0, 0), (0.0, 0), (f32::NAN, 0), (1.0, 2), (f32::INFINITY, 2)] {
            assert!(
                (at(time).translation_m - frames[frame].translation_m).length() < 1e-7,
                "{time}"
            );
        }
    }

    #[test]
    fn bad_frames_are_refused() {
        use TrajectoryError as E;
        let good = [Transform::IDENTITY; 4];
        assert_eq!(Trajectory::new(&good, 2, 0.0), Err(E::TimeStep));
        assert_eq!(Trajectory::new(&good, 3, 0.1), Err(E::Count { joints: 3, poses: 4 }));
        assert_eq!(Trajectory::new(&good, 0, 0.1), Err(E::Count { joints: 0, poses: 4 }));
        assert_eq!(Trajectory::new(&[], 2, 0.1), Err(E::Count { joints: 2, poses: 0 }));
        let mut bad = good;
        bad[3].translation_m.x = f32::NAN;
        assert_eq!(Trajectory::new(&bad, 2, 0.1), Err(E::InvalidPose { frame: 1, joint: 1 }));
    }
}
