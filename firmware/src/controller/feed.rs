//! Where poses come from: a show, a live stream, somebody who jogs, a pose that stands.

use sinew_core::tracker::{Frame, FrameSource};
use sinew_rig::board::{BoardDof, BoardRig};
use sinew_show::{Position, Show, ShowError, ShowFrames};

use super::path::{Path, THERE};
use super::pose::Pose;
use crate::supervisor::{Fault, FaultSet, Feed, Feeds, Permission, Settings, Source, State};

/// A live stream, behind its jitter buffer.
pub trait LiveSource {
    /// Writes the target of a tick in the rig's coordinates (nq positions, nv speeds and accelerations), and says
    /// whether there is one: of a stream that is late there is none, and the rig holds. It does not wait.
    fn target(&mut self, now_us: u64, q: &mut [f32], qd: &mut [f32], qdd: &mut [f32]) -> bool;
}

/// No stream.
impl LiveSource for () {
    fn target(&mut self, _: u64, _: &mut [f32], _: &mut [f32], _: &mut [f32]) -> bool {
        false
    }
}

/// Perhaps a stream.
impl<L: LiveSource> LiveSource for Option<L> {
    fn target(&mut self, now_us: u64, q: &mut [f32], qd: &mut [f32], qdd: &mut [f32]) -> bool {
        self.as_mut().is_some_and(|stream| stream.target(now_us, q, qd, qdd))
    }
}

/// A joint that somebody moves, as long as it comes in every tick.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Jog {
    /// Index of the dof.
    pub dof: u16,
    /// How fast, rad/s or m/s; held to what the state allows.
    pub speed: f32,
}

/// How a show begins that is faster than a rig may be from standing still.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SoftStart {
    /// The fastest joint from standing still, rad/s.
    rad_s: f32,
    /// How long such a show takes to gain its pace, ticks; even.
    ticks: u32,
}

impl SoftStart {
    /// At the supervisor's soft speed, in the time of its blends.
    pub(super) fn new(settings: &Settings, dt_s: f32) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
        let half = (0.5 * settings.blend_s / dt_s) as u32;
        Self { rad_s: settings.soft_rad_s, ticks: half.saturating_mul(2) }
    }
}

/// All sources, and where each of them is.
#[derive(Debug)]
pub(super) struct Sources<'a, const DOFS: usize, const COORDS: usize> {
    show: Option<ShowFrames<'a, COORDS>>,
    /// Ticks that the show has run.
    ticks: u32,
    /// In so many of them, an even number, a show that starts at speed gains its pace from standing still.
    run_in: u32,
    soft: SoftStart,
    /// What is wrong with the show that played, until it was told.
    fault: Option<Fault>,
    /// A good show came.
    uploaded: bool,
    /// The show that played is there no more: its feed is silent for a tick, and the rig holds.
    changed: bool,
    pub(super) rest: Pose<DOFS, COORDS>,
    live: Pose<DOFS, COORDS>,
    has_live: bool,
    /// The pose of the source that is followed now.
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

    /// Another show, or none. Of one that is refused nothing is left.
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

    /// Another show that was checked, or none.
    pub(super) fn put(&mut self, show: Option<ShowFrames<'a, COORDS>>, plays: bool) {
        self.uploaded |= show.is_some();
        (self.show, self.ticks) = (show, 0);
        self.changed |= plays;
    }

    /// What good shows have mended that came since this was asked.
    pub(super) fn take_uploaded(&mut self) -> FaultSet {
        if core::mem::take(&mut self.uploaded) { FaultSet::OF_SHOW } else { FaultSet::EMPTY }
    }

    /// What is wrong with the show that plays, told once.
    pub(super) fn take_fault(&mut self) -> Option<Fault> {
        self.fault.take()
    }

    /// Takes the stream's target; says whether all of it are numbers.
    pub(super) fn listen(&mut self, now_us: u64, live: &mut impl LiveSource) -> bool {
        let [q, qd, qdd] = self.live.all_mut();
        self.has_live = live.target(now_us, q, qd, qdd);
        !self.has_live || self.live.is_finite()
    }

    /// Which feeds give poses. A show that is over gives none, until another begins; a loop is over when its ticks
    /// cannot be counted any more: after 2³¹, 50 days at 500 Hz.
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

    /// Where the show is.
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

    /// The frame behind the run-in, which has taken half of its time from the show.
    fn index(&self) -> i32 {
        i32::try_from(self.ticks.saturating_sub(self.run_in >> 1)).unwrap_or(i32::MAX)
    }

    /// Whether a joint of the show's first frame is faster than from standing still it may be.
    fn starts_at_speed(&mut self, path: &Path<DOFS, COORDS>) -> bool {
        let Some(frames) = &mut self.show else { return false };
        self.goal.take(frames.frame(0));
        path.moving(self.goal.qd(), self.soft.rad_s).is_some()
    }

    /// A source begins. `here`: where the rig comes to stand; `measured`: where it is.
    pub(super) fn begin(&mut self, source: Source, here: &Pose<DOFS, COORDS>, measured: &[f32]) {
        self.ticks = 0;
        self.goal.clone_from(if source == Source::Rest { &self.rest } else { here });
        if source == Source::Measured {
            self.lead(measured);
        }
    }

    /// The rig is lowered: its goal, at rest.
    pub(super) fn lower(&mut self) -> &mut Pose<DOFS, COORDS> {
        self.goal.rest();
        &mut self.goal
    }

    /// The rig is led: its goal is where it was measured.
    pub(super) fn lead(&mut self, measured: &[f32]) -> &Pose<DOFS, COORDS> {
        self.goal.q_mut().iter_mut().zip(measured).for_each(|(goal, measured)| *goal = *measured);
        &self.goal
    }

    /// The pose to be followed in a tick. A source that has just fallen silent stands.
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

    /// Before the show runs, the rig rests in its first frame: the frame before that stands there.
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

/// Opens a show of a rig where it lies, and checks all of it, for ticks of `dt_s`. For the background task: O(size).
///
/// # Errors
/// [`ShowError`] if it cannot be read, or is of another rig.
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
    let mut frames = ShowFrames::new(show, dt_s)?;
    check_first_pose(rig, &mut frames)?;
    Ok(frames)
}

/// Refuses a show whose first pose is beyond a range: the rig would wait for it without end. Ball joints have no ends.
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
        // A ball joint has a coordinate more than dofs: the pairs end with it.
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

/// Whether a show is what plays.
pub(super) fn plays_show(state: State, source: Source) -> bool {
    state == State::Playing && source == Source::Feed(Feed::Show)
}
