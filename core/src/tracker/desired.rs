//! The desired side: converts frames to targets.

use core::mem;

use crate::aligned_differences;
use crate::forward_differences::ForwardDifferences;
use crate::joint_targets::JointTargets;
use crate::kinematics::of_parent;
use crate::pose_step::rate;
use crate::projection::{ManifoldProjection, ProjectionError, ProjectionWorkspace};
use crate::state::{BodyState, StateInputError};
use crate::trajectory::{forward_targets, live_targets};
use crate::transform::{Transform, Twist};
use crate::tree::Tree;
use crate::{fixed, math};

use super::error::{InputError, TrackerError, check_count};
use super::frames::{Frame, FrameSource};
use super::names::{DesiredVelocity, Differences};

/// Number of frames that must precede a frame before that frame gives a target: differences need two, and the
/// projection starts from one more.
const LEAD: u8 = 3;

/// Kind of the source's frames. For coordinates no frame is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Poses,
    Coordinates,
}

/// The desired side of a tracker: it projects frames onto the rig and computes targets from their differences.
#[derive(Debug)]
pub(super) struct Desired<const N: usize> {
    differences: Differences,
    velocity: DesiredVelocity,
    dt_s: f32,
    /// Number of frames by which the targets are ahead of the tick: they are for the time when the tick's torques
    /// act.
    latency: i32,
    projection: Option<ManifoldProjection<N>>,
    projected: ProjectionWorkspace<N>,
    /// Differences of the bodies' poses. It stores frames itself, and is used instead of `window` if the velocities
    /// are differences of bodies.
    of_bodies: ForwardDifferences<N>,
    /// Whether the steps in `of_bodies` belong to the next three frames, for aligned differences. The storage is
    /// shared, because bodies' and aligned differences are never used together, and boards lack the RAM for both.
    steps_known: bool,
    /// Poses of the joints in the last three frames, oldest in slot `oldest`.
    window: [[Transform; N]; 3],
    oldest: usize,
    /// Kind of the source's frames; `None` before the start.
    kind: Option<Kind>,
    /// Number of the last accepted frame; `None` before the first.
    newest: Option<i32>,
    /// Number of consecutive frames that are known, up to [`LEAD`].
    known: u8,
    targets: JointTargets<N>,
}

impl<const N: usize> Desired<N> {
    /// Creates the desired side for an empty tree.
    #[inline(never)]
    pub(super) fn uninit() -> Self {
        Self {
            differences: Differences::Forward,
            velocity: DesiredVelocity::Bodies,
            dt_s: 0.0,
            latency: 0,
            projection: None,
            of_bodies: ForwardDifferences::new(),
            steps_known: false,
            window: [[Transform::IDENTITY; N]; 3],
            oldest: 0,
            kind: None,
            newest: None,
            known: 0,
            targets: JointTargets::uninit(),
            projected: ProjectionWorkspace::new(),
        }
    }

    /// Initializes in place for a rig, before the first frame.
    #[inline(never)]
    pub(super) fn init(
        &mut self,
        tree: &Tree<N>,
        dt_s: f32,
        latency: i32,
        (differences, velocity): (Differences, DesiredVelocity),
    ) {
        (self.differences, self.velocity) = (differences, velocity);
        (self.dt_s, self.latency) = (dt_s, latency);
        self.projection = None;
        self.kind = None;
        self.targets = JointTargets::rest(tree);
    }

    /// Sets the projection of poses, or removes it.
    pub(super) fn set_projection(&mut self, projection: Option<ManifoldProjection<N>>) {
        self.projection = projection;
    }

    pub(super) fn targets(&self) -> &JointTargets<N> {
        &self.targets
    }

    pub(super) fn targets_mut(&mut self) -> &mut JointTargets<N> {
        &mut self.targets
    }

    /// Replaces the projection, which must exist.
    pub(super) fn replace_projection(
        &mut self,
        replace: impl FnOnce(&ManifoldProjection<N>) -> Result<ManifoldProjection<N>, ProjectionError>,
    ) -> Result<(), TrackerError> {
        let projection = self.projection.as_mut().ok_or(TrackerError::NoProjection)?;
        *projection = replace(projection)?;
        Ok(())
    }

    /// Returns `true` if velocities are forward differences of bodies.
    fn differences_bodies(&self) -> bool {
        self.differences == Differences::Forward && self.velocity == DesiredVelocity::Bodies
    }

    /// Returns the number of the frame for the time when the torques of a tick act.
    fn met_by(&self, index: i32) -> i32 {
        index.saturating_add(self.latency)
    }

    /// Returns the number of the latest frame that the differences for a tick need.
    fn newest_of(&self, index: i32) -> i32 {
        self.met_by(index).saturating_add(self.differences.frames_ahead())
    }

    /// Starts a performance at tick `index`. The previous performance is forgotten, and the new frames may be of
    /// either kind.
    pub(super) fn begin(
        &mut self,
        tree: &Tree<N>,
        frames: &mut impl FrameSource,
        index: i32,
    ) -> Result<(), InputError> {
        (self.kind, self.newest, self.known) = (None, None, 0);
        if frames.has_coordinates_alone() {
            self.kind = Some(Kind::Coordinates);
            return Ok(());
        }
        self.projected.reset();
        let kind = match frames.frame(self.met_by(index)) {
            Frame::Coordinates { .. } => Kind::Coordinates,
            Frame::Poses(_) => {
                let newest = self.newest_of(index);
                for back in (1..=i32::from(LEAD)).rev() {
                    self.lead(tree, frames.frame(newest.saturating_sub(back)))?;
                }
                self.newest = Some(newest.saturating_sub(1));
                Kind::Poses
            }
        };
        self.kind = Some(kind);
        Ok(())
    }

    /// Accepts a frame that gives no target yet.
    // Never inlined: otherwise every tick would pay for its stack frame.
    #[inline(never)]
    fn lead(&mut self, tree: &Tree<N>, frame: Frame<'_>) -> Result<(), InputError> {
        if self.differences_bodies() {
            let [slot, ..] = &mut self.window;
            let joints = performed((&self.projection, &mut self.projected), tree, frame, slot)?;
            match self.known {
                0 => {}
                1 => self.of_bodies.restart(tree, self.dt_s, joints)?,
                _ => self.of_bodies.lead(tree, joints)?,
            }
        } else {
            self.take_in(tree, frame)?;
            self.steps_known = false;
        }
        self.known = self.known.saturating_add(1);
        Ok(())
    }

    /// Computes the targets of tick `index`. Each tick reads one frame. After a jump the first [`LEAD`] frames give
    /// no target yet: until then the targets continue at constant velocities.
    pub(super) fn follow(
        &mut self,
        tree: &Tree<N>,
        frames: &mut impl FrameSource,
        index: i32,
    ) -> Result<(), InputError> {
        if self.kind.is_none() {
            self.begin(tree, frames, index)?;
        }
        if frames.has_coordinates_alone() && self.kind == Some(Kind::Poses) {
            return Err(InputError::Kind);
        }
        if frames.has_coordinates_alone() || self.kind == Some(Kind::Coordinates) {
            return self.take_exactly(tree, frames.frame(self.met_by(index)));
        }
        let newest = self.newest_of(index);
        // A refused frame counts as a jump, too.
        if self.newest.take().and_then(|newest| newest.checked_add(1)) != Some(newest) {
            self.known = 0;
        }
        let frame = frames.frame(newest);
        if self.known < LEAD {
            self.lead(tree, frame)?;
            self.targets.go_on(tree, self.dt_s);
        } else if self.differences_bodies() {
            let [slot, ..] = &mut self.window;
            let joints = performed((&self.projection, &mut self.projected), tree, frame, slot)?;
            self.of_bodies.advance(tree, joints, &mut self.targets)?;
        } else if self.differences == Differences::Forward
            && matches!(self.velocity, DesiredVelocity::Zero | DesiredVelocity::Backward)
        {
            self.difference_at_rest_or_backward(tree, frame)?;
        } else {
            self.difference(tree, frame)?;
        }
        self.newest = Some(newest);
        Ok(())
    }

    /// Sets the targets from a frame of coordinates.
    #[inline(never)]
    fn take_exactly(&mut self, tree: &Tree<N>, frame: Frame<'_>) -> Result<(), InputError> {
        let Frame::Coordinates { q, qd, qdd } = frame else { return Err(InputError::Kind) };
        Ok(self.targets.set_coordinates(tree, q, qd, qdd)?)
    }

    /// Computes the targets by differences of the frames in the window.
    #[inline(never)]
    fn difference(&mut self, tree: &Tree<N>, frame: Frame<'_>) -> Result<(), InputError> {
        self.take_in(tree, frame)?;
        let window = in_order(&self.window, self.oldest)
            .map(|joints| joints.get(..tree.len()).unwrap_or_default());
        let (dt_s, targets) = (self.dt_s, &mut self.targets);
        Ok(match self.differences {
            Differences::Forward => forward_targets(window, dt_s, targets),
            Differences::Aligned => {
                if !mem::replace(&mut self.steps_known, false) {
                    aligned_differences::begin(window, dt_s, self.of_bodies.steps_mut())?;
                }
                let steps = self.of_bodies.steps_mut();
                aligned_differences::advance(window, dt_s, steps, targets)?;
                self.steps_known = true;
                Ok(())
            }
            Differences::Live => live_targets(window, dt_s, targets),
        }?)
    }

    /// Computes the targets like `difference`, but with velocities that are zero or backward differences.
    // Never inlined: boards do not use it, and their ticks should not pay for its stack.
    #[inline(never)]
    fn difference_at_rest_or_backward(
        &mut self,
        tree: &Tree<N>,
        frame: Frame<'_>,
    ) -> Result<(), InputError> {
        let velocities = match self.velocity {
            DesiredVelocity::Backward => self.backward(tree)?,
            _ => [Twist::ZERO; N],
        };
        self.difference(tree, frame)?;
        for (joint, velocity) in velocities.iter().enumerate().take(tree.len()) {
            self.targets.set_velocity(joint, *velocity)?;
        }
        Ok(())
    }

    /// Returns the velocities of the joints, in body axes, from backward differences of the bodies' world poses. At
    /// this point, before the next frame is accepted, the window starts with the frame before the tick's.
    fn backward(&self, tree: &Tree<N>) -> Result<[Twist; N], StateInputError> {
        let rate_hz = rate(self.dt_s)?;
        let [before, now, _] = in_order(&self.window, self.oldest);
        let (mut bodies_before, mut bodies) = ([Transform::IDENTITY; N], [BodyState::WORLD; N]);
        let mut velocities = [Twist::ZERO; N];
        for (index, (body, (before, now))) in
            tree.bodies().iter().zip(before.iter().zip(now)).enumerate()
        {
            let before = *of_parent(body, &bodies_before, &Transform::IDENTITY) * *before;
            let parent = *of_parent(body, &bodies, &BodyState::WORLD);
            let pose = parent.pose * *now;
            let turn = math::turn_in_world(before.rotation, pose.rotation);
            let velocity = Twist {
                angular: math::log(turn) * rate_hz,
                linear: (pose.translation_m - before.translation_m) * rate_hz,
            };
            let state = BodyState { pose, velocity };
            if let (Some(slot_before), Some(slot), Some(out)) =
                (bodies_before.get_mut(index), bodies.get_mut(index), velocities.get_mut(index))
            {
                (*slot_before, *slot) = (before, state);
                *out = state.velocity_from(&parent);
            }
        }
        Ok(velocities)
    }

    /// Stores a frame, projected onto the rig if there is a projection, in place of the oldest frame of the window.
    fn take_in(&mut self, tree: &Tree<N>, frame: Frame<'_>) -> Result<(), InputError> {
        let [a, b, c] = &mut self.window;
        let (slot, next) = match self.oldest {
            0 => (a, 1),
            1 => (b, 2),
            _ => (c, 0),
        };
        match &self.projection {
            Some(_) => {
                performed((&self.projection, &mut self.projected), tree, frame, slot)?;
            }
            None => fixed::copy(joints_of(frame, tree)?, slot),
        }
        self.oldest = next;
        Ok(())
    }
}

/// Returns the frames of a window, oldest first.
fn in_order<T>([a, b, c]: &[T; 3], oldest: usize) -> [&T; 3] {
    match oldest {
        0 => [a, b, c],
        1 => [b, c, a],
        _ => [c, a, b],
    }
}

/// Returns a frame's poses, by joint.
fn joints_of<'f, const N: usize>(
    frame: Frame<'f>,
    tree: &Tree<N>,
) -> Result<&'f [Transform], InputError> {
    let Frame::Poses(poses) = frame else { return Err(InputError::Kind) };
    check_count(tree.len(), poses.len())?;
    Ok(poses)
}

/// Returns a frame in a form that the rig can perform: unchanged, or projected onto the rig's own poses in `slot`.
fn performed<'f, const N: usize>(
    (projection, workspace): (&Option<ManifoldProjection<N>>, &mut ProjectionWorkspace<N>),
    tree: &Tree<N>,
    frame: Frame<'f>,
    slot: &'f mut [Transform; N],
) -> Result<&'f [Transform], InputError> {
    let joints = joints_of(frame, tree)?;
    let Some(projection) = projection else { return Ok(joints) };
    let nearest = slot.get_mut(..tree.len()).unwrap_or_default();
    projection.project(tree, joints, workspace, nearest)?;
    Ok(nearest)
}
