//! Sources of poses: a show, a live stream, a jog, and a pose that stays the same.

use sinew_core::tracker::{Frame, FrameSource};
use sinew_rig::board::{BoardDof, BoardRig};
use sinew_show::{Position, Show, ShowError, ShowFrames};

use super::path::{Path, THERE};
use super::pose::Pose;
use crate::supervisor::{Fault, FaultSet, Feed, Feeds, Permission, Settings, Source, State};

/// A live stream, after its jitter buffer.
pub trait LiveSource {
    /// Writes the target of a tick in the rig's coordinates (nq positions, nv velocities and accelerations). Returns
    /// whether there is a target: a late stream has none, and the rig holds. Does not wait.
    fn target(&mut self, now_us: u64, q: &mut [f32], qd: &mut [f32], qdd: &mut [f32]) -> bool;
}

/// A source without a stream.
impl LiveSource for () {
    fn target(&mut self, _: u64, _: &mut [f32], _: &mut [f32], _: &mut [f32]) -> bool {
        false
    }
}

/// An optional stream.
impl<L: LiveSource> LiveSource for Option<L> {
    fn target(&mut self, now_us: u64, q: &mut [f32], qd: &mut [f32], qdd: &mut [f32]) -> bool {
        self.as_mut().is_some_and(|stream| stream.target(now_us, q, qd, qdd))
    }
}

/// A joint that a user moves. It moves only in ticks in which this input is present.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Jog {
    /// Index of the dof.
    pub dof: u16,
    /// Speed, rad/s or m/s; limited to the maximum of the state.
    pub speed: f32,
}

/// Settings for a show that starts faster than a rig may move from standstill.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SoftStart {
    /// Maximum speed of a joint from standstill, rad/s.
    rad_s: f32,
    /// Number of ticks in which a show reaches its pace; even.
    ticks: u32,
}

impl SoftStart {
    /// Uses the supervisor's soft speed, and the duration of its blends.
    pub(super) fn new(settings: &Settings, dt_s: f32) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
        let half = (0.5 * settings.blend_s / dt_s) as u32;
        Self { rad_s: settings.soft_rad_s, ticks: half.saturating_mul(2) }
    }
}

/// All sources, with their positions in time.
#[derive(Debug)]
pub(super) struct Sources<'a, const DOFS: usize, const COORDS: usize> {
    show: Option<ShowFrames<'a, COORDS>>,
    /// Number of ticks that the show has run.
    ticks: u32,
    /// Number of ticks in which a show that starts at speed reaches its pace from standstill. It is even.
    run_in: u32,
    soft: SoftStart,
    /// Fault of the show that played, until it is reported.
    fault: Option<Fault>,
    /// Whether a valid show arrived.
    uploaded: bool,
    /// Whether the show that played is gone: its feed is silent for a tick, and the rig holds.
    changed: bool,
    pub(super) rest: Pose<DOFS, COORDS>,
    live: Pose<DOFS, COORDS>,
    has_live: bool,
    /// Pose of the current source.
    goal: Pose<DOFS, COORDS>,
}

impl<'a, const DOFS: usize, const COORDS: usize> Sources<'a, DOFS, COORDS> {
    #[inline(never)]
    pub(super) fn new(rest: &Pose<DOFS, COORDS>, soft: SoftStart) -> Self {
        Self {
            show: None,
            ticks: 0,
            run_in: 0,
            soft,
            fault: None,
            uploaded: false,
            changed: false,
            rest: rest.clone(),
            live: rest.clone(),
            has_live: false,
            goal: rest.clone(),
        }
    }

    /// Loads another show; `None` loads no show. A refused show is not kept. `plays` is whether the previous show is
    /// being played: then it ends, and a refused show is a fault.
    pub(super) fn load<const BODIES: usize, const SERVOS: usize>(
        &mut self,
        bytes: Option<&'a [u8]>,
        (rig, crc): (&BoardRig<BODIES, DOFS, SERVOS>, u32),
        dt_s: f32,
        plays: bool,
    ) -> Result<(), ShowError> {
        (self.show, self.ticks) = (None, 0);
        self.changed |= plays;
        let Some(bytes) = bytes else { return Ok(()) };
        match open_show(rig, crc, dt_s, bytes) {
            Ok(show) => {
                (self.show, self.uploaded) = (Some(show), true);
                Ok(())
            }
            Err(error) => {
                use ShowError::{Joint, Joints, Rig};
                let is_foreign = matches!(error, Rig { .. } | Joint { .. } | Joints { .. });
                let fault = if is_foreign { Fault::ShowForeign } else { Fault::ShowBad };
                self.fault = plays.then_some(fault);
                Err(error)
            }
        }
    }

    /// Sets another show that was checked already; `None` sets no show.
    pub(super) fn put(&mut self, show: Option<ShowFrames<'a, COORDS>>, plays: bool) {
        self.uploaded |= show.is_some();
        (self.show, self.ticks) = (show, 0);
        self.changed |= plays;
    }

    /// Returns the faults that valid shows have cleared since the last call.
    pub(super) fn take_uploaded(&mut self) -> FaultSet {
        if core::mem::take(&mut self.uploaded) { FaultSet::OF_SHOW } else { FaultSet::EMPTY }
    }

    /// Returns the fault of the show that played, if there is one. Each fault is returned only once.
    pub(super) fn take_fault(&mut self) -> Option<Fault> {
        self.fault.take()
    }

    /// Reads the stream's target. Returns whether there is none, or all of its numbers are finite.
    pub(super) fn listen(&mut self, now_us: u64, live: &mut impl LiveSource) -> bool {
        let [q, qd, qdd] = self.live.all_mut();
        self.has_live = live.target(now_us, q, qd, qdd);
        !self.has_live || self.live.is_finite()
    }

    /// Returns the feeds that have poses. A show that has ended has none until it begins again. A loop ends when its
    /// ticks can no longer be counted: after 2³¹ ticks, 50 days at 500 Hz.
    pub(super) fn feeds(&mut self, jog: Option<Jog>, plays_show: bool) -> Feeds {
        let has_changed = core::mem::take(&mut self.changed);
        let is_over = |frames: &ShowFrames<'a, COORDS>| {
            let show = frames.show();
            let is_at_end = self.at(frames) > Position::from_samples(show.length());
            plays_show && (!show.is_loop() && is_at_end || self.index() == i32::MAX)
        };
        let show = !has_changed && self.show.as_ref().is_some_and(|frames| !is_over(frames));
        Feeds { show, live: self.has_live, jog: jog.is_some() }
    }

    /// Returns the position in the show, or `None` without a show.
    pub(super) fn position(&self) -> Option<Position> {
        self.show.as_ref().map(|frames| self.at(frames))
    }

    fn at(&self, frames: &ShowFrames<'a, COORDS>) -> Position {
        if self.ticks < self.run_in {
            frames.run_in_position(self.ticks, self.run_in)
        } else {
            frames.position(self.index())
        }
    }

    /// Returns the show's frame at this tick, after the run-in. A run-in of n ticks plays n/2 frames of the show.
    fn index(&self) -> i32 {
        i32::try_from(self.ticks.saturating_sub(self.run_in >> 1)).unwrap_or(i32::MAX)
    }

    /// Returns the first pose of the show, at rest, or `None` without a show.
    pub(super) fn first(&mut self) -> Option<&[f32]> {
        self.goal.take(self.show.as_mut()?.frame(-1));
        Some(self.goal.q())
    }

    /// Returns whether a joint in the show's first frame is faster than permitted from standstill.
    fn starts_at_speed(&mut self, path: &Path<DOFS, COORDS>) -> bool {
        let Some(frames) = &mut self.show else { return false };
        self.goal.take(frames.frame(0));
        path.moving(self.goal.qd(), self.soft.rad_s).is_some()
    }

    /// Starts a source. `here` is the pose in which the rig comes to rest; `measured` is its current pose.
    pub(super) fn begin(&mut self, source: Source, here: &Pose<DOFS, COORDS>, measured: &[f32]) {
        self.ticks = 0;
        self.goal.clone_from(if source == Source::Rest { &self.rest } else { here });
        if source == Source::Measured {
            self.lead(measured);
        }
    }

    /// Sets the speeds and accelerations of the goal to zero, and returns the goal, for a rig that is lowered.
    pub(super) fn lower(&mut self) -> &mut Pose<DOFS, COORDS> {
        self.goal.rest();
        &mut self.goal
    }

    /// Sets the positions of the goal to the measured pose, and returns the goal, for a rig that is led by hand.
    pub(super) fn lead(&mut self, measured: &[f32]) -> &Pose<DOFS, COORDS> {
        self.goal.q_mut().iter_mut().zip(measured).for_each(|(goal, measured)| *goal = *measured);
        &self.goal
    }

    /// Returns the pose to be followed in this tick. A source that has just fallen silent keeps its last pose.
    pub(super) fn goal(
        &mut self,
        permission: &Permission,
        jog: Option<Jog>,
        path: &Path<DOFS, COORDS>,
        dt_s: f32,
    ) -> &Pose<DOFS, COORDS> {
        match permission.source {
            Source::Feed(Feed::Show) => self.show_goal(permission.runs, path),
            Source::Feed(Feed::Live) if self.has_live => self.goal.clone_from(&self.live),
            Source::Feed(Feed::Jog) => {
                if let Some(Jog { dof, speed }) = jog {
                    let most = permission.speed_rad_s.unwrap_or(0.0);
                    let by = dt_s * speed.max(-most).min(most);
                    path.jog(usize::from(dof), by, self.goal.q_mut());
                }
            }
            _ => {}
        }
        &self.goal
    }

    /// Sets the goal of the show. Before the show runs, the goal is the frame before the first, with which the rig
    /// comes to rest in the first frame.
    fn show_goal(&mut self, runs: bool, path: &Path<DOFS, COORDS>) {
        if runs && self.ticks == 0 {
            self.run_in = if self.starts_at_speed(path) { self.soft.ticks } else { 0 };
        }
        let index = if runs { self.index() } else { -1 };
        let Some(frames) = &mut self.show else { return };
        self.goal.take(if runs && self.ticks < self.run_in {
            frames.run_in(self.ticks, self.run_in)
        } else {
            frames.frame(index)
        });
        if frames.fault().is_some() {
            self.fault = Some(Fault::ShowBad);
            self.show = None;
        } else if runs {
            self.ticks = self.ticks.saturating_add(1);
        }
    }
}

/// Opens a rig's show in place, and checks all of it for ticks of `dt_s`. For the background task: O(size).
///
/// # Errors
/// [`ShowError`] if the show cannot be read, is for another rig, or starts outside of a joint's range.
pub fn open_show<
    'a,
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
>(
    rig: &BoardRig<BODIES, DOFS, SERVOS>,
    rig_crc: u32,
    dt_s: f32,
    bytes: &'a [u8],
) -> Result<ShowFrames<'a, COORDS>, ShowError> {
    let show = Show::open(bytes)?;
    show.check_rig(rig_crc)?;
    show.check_joints(rig.tree().bodies().iter().map(|body| body.joint))?;
    // Opened in the result's place: each copy of frames costs 2 kB of stack.
    let mut opened = ShowFrames::new(show, dt_s);
    if let Ok(frames) = &mut opened
        && let Err(error) = check_first_pose(rig, frames)
    {
        opened = Err(error);
    }
    opened
}

/// Refuses a show whose first pose is beyond a range: the rig would wait for this pose without end. Ball joints
/// have no ends.
fn check_first_pose<
    const BODIES: usize,
    const DOFS: usize,
    const SERVOS: usize,
    const COORDS: usize,
>(
    rig: &BoardRig<BODIES, DOFS, SERVOS>,
    frames: &mut ShowFrames<'_, COORDS>,
) -> Result<(), ShowError> {
    let Frame::Coordinates { q, .. } = frames.frame(0) else { return Ok(()) };
    let (mut q, mut dofs) = (q.iter(), rig.dofs().iter().enumerate());
    for joint in rig.tree().bodies().iter().map(|body| body.joint) {
        // A ball joint has one coordinate more than dofs: this last coordinate has no pair.
        let own = q.by_ref().take(joint.coordinate_count());
        for (found, (dof, BoardDof { range: [least, most], .. })) in
            own.zip(dofs.by_ref().take(joint.dof_count()))
        {
            let is_ball = joint.coordinate_count() > joint.dof_count();
            if !is_ball && (found.max(*least).min(*most) - found).abs() > THERE {
                return Err(ShowError::Range { dof, found: *found, least: *least, most: *most });
            }
        }
    }
    Ok(())
}

/// Returns whether a show is playing.
pub(super) fn plays_show(state: State, source: Source) -> bool {
    state == State::Playing && source == Source::Feed(Feed::Show)
}
