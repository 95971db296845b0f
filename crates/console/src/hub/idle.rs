//! Idle life of the rig between shows: a loop that this program sends to the board.

use sinew_board_client::{IdleLife, Line};
use sinew_firmware::supervisor::Fault;
use sinew_link::message::{POSE_MAX, State};
use sinew_show::{Player, Show};

use super::act::{Act, Feeding};
use super::shows::OwnShow;
use super::{Hub, Refused};
use crate::message::{IdleState, Level};
use crate::scene::Scene;

/// Poses per second of the loop. Between two of them, the motion is linear: a lid that closes with 12,000 deg/s² is
/// then 0.15 deg off at most.
const RATE_HZ: f64 = 100.0;
/// Maximum number of coordinates of a rig.
const COORDS: usize = 192;
/// Share of a slider's maximum speed with which the rig goes to the loop.
const SHARE: f32 = 0.7;

/// The loop of a console.
#[derive(Debug)]
pub(super) struct Idle {
    name: String,
    life: IdleLife,
    /// Whether the loop plays whenever the rig holds and nothing else moves it.
    is_on: bool,
}

/// Returns the loop in a show's bytes as poses for a rig.
///
/// # Errors
/// A text if the show is not a loop of this rig, or the rig has more coordinates than a live pose contains.
pub fn idle_life(bytes: &[u8], scene: &Scene) -> Result<IdleLife, String> {
    let show = Show::open(bytes).map_err(|error| error.to_string())?;
    show.check_rig(scene.rig_crc).map_err(|error| error.to_string())?;
    if !show.is_loop() {
        return Err("expected a loop: `sinew bake .. --loop` makes one".to_owned());
    }
    let count = scene.home.len();
    if count > POSE_MAX.min(COORDS) {
        return Err(format!("the rig has {count} coordinates; a live pose carries {POSE_MAX}"));
    }
    let mut player = Player::<COORDS>::new(show).map_err(|error| error.to_string())?;
    let [mut q, mut qd, mut qdd] = [[0.0; COORDS]; 3];
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 2^30")]
    let rows = (f64::from(show.duration_s()) * RATE_HZ).round().max(1.0) as usize;
    let mut all = Vec::with_capacity(rows);
    for row in 0..rows {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in the show")]
        let at = show.position_at_us((row as f64 / RATE_HZ * 1e6) as u64);
        player.state_at(at, &mut q, &mut qd, &mut qdd).map_err(|error| error.to_string())?;
        all.push(q.get(..count).unwrap_or_default().to_vec());
    }
    let rate_hz = rows as f64 / f64::from(show.duration_s());
    IdleLife::new(&all, rate_hz, &scene.blocks).ok_or_else(|| "the show has no poses".to_owned())
}

impl Idle {
    /// Reads the loop of the command line.
    pub(super) fn new(own: &OwnShow, scene: &Scene) -> Result<Self, String> {
        Ok(Self { name: own.name.clone(), life: idle_life(&own.bytes, scene)?, is_on: false })
    }

    pub(super) fn state(&self) -> IdleState<'_> {
        IdleState { name: &self.name, on: self.is_on }
    }
}

impl<L: Line> Hub<'_, L> {
    /// Starts idle life, or ends it: then the rig holds.
    pub(super) fn turn_idle(&mut self, on: bool) -> Result<String, Refused> {
        let state = self.state();
        let Some(idle) = &mut self.idle else {
            return Err(Refused::because(
                "there is no idle life: `sinew console --idle LOOP.show`",
            ));
        };
        if on && !matches!(state, State::Holding | State::Playing) {
            return Err(Refused::Other(format!("the rig is {state}: arm it first")));
        }
        idle.is_on = on;
        self.tell_shows();
        if !on && matches!(self.act, Some(Act::Idle(_))) {
            self.hold()?;
        }
        Ok(if on { "idle life, also after each show" } else { "no idle life" }.to_owned())
    }

    /// Ends idle life for good: the rig stands until idle life is started again.
    pub(super) fn end_idle(&mut self) {
        if self.idle.as_ref().is_some_and(|idle| idle.is_on) {
            if let Some(idle) = &mut self.idle {
                idle.is_on = false;
            }
            self.tell_shows();
        }
    }

    /// Begins idle life if it is on, the rig holds, and nothing else moves it.
    pub(super) fn go_on_idle_life(&mut self) {
        let is_free = self.act.is_none()
            && self.arming.is_none()
            && self.waiting.is_none()
            && self.closing.is_none()
            && self.state() == State::Holding;
        if !is_free || !self.idle.as_ref().is_some_and(|idle| idle.is_on) {
            return;
        }
        let fault = self.board.log.summary.and_then(|summary| summary.fault);
        if fault.is_some_and(|fault| fault != Fault::Swing.number()) {
            self.end_idle();
            self.event(Level::Warning, "idle life has ended: there is a fault");
            return;
        }
        let (now, most_rad_s) = (self.now(), SHARE * self.soft_rad_s);
        // Waits until the pose is known.
        let Ok(from) = self.pose_now(self.scene.home.len()) else { return };
        if let Some(idle) = &mut self.idle {
            idle.life.begin(&from, most_rad_s, now);
            self.act = Some(Act::Idle(Feeding::new((), now)));
        }
    }

    /// Returns the pose of idle life to send now.
    pub(super) fn idle_pose(&mut self) -> Option<Vec<f32>> {
        let now = self.now();
        let commanded = self.scene.commanded(&self.board.log);
        let mut pose = self.idle.as_mut()?.life.step(commanded.as_deref(), now);
        self.scene.follow(&mut pose);
        Some(pose)
    }
}
