//! The trackers of runs side by side, which take their ticks together, in vector instructions.

use std::array::from_fn;

use sinew_batch::{TRACKER_LANES, Trackers};
use sinew_core::Transform;
use sinew_figure::plant::{LANES, Pose};

use super::controller::narrow;
use super::error::RunError;
use super::run::Performer;

/// Number of frames after the frame of a step that the differences need.
const AHEAD: usize = 2;

/// Trackers of several runs: as many as plants that take their steps together.
pub(super) struct RunTrackers {
    trackers: Trackers,
    /// Whether the last frame and the last readings of each run were valid.
    are_valid: [bool; LANES],
}

const _: () = assert!(TRACKER_LANES == LANES, "each lane has a plant and a tracker");

impl RunTrackers {
    /// Joins the trackers of several runs before their first step. The last run may have several lanes. Returns
    /// `None` if the settings or the rigs do not allow it.
    pub(super) fn join(performers: &mut [&mut Performer<'_>]) -> Option<Self> {
        let dt_s = performers.first()?.dt_s();
        let is_alike = |performer: &&mut Performer<'_>| {
            performer.has_plain_tracker() && performer.dt_s().to_bits() == dt_s.to_bits()
        };
        if !performers.iter().all(is_alike) {
            return None;
        }
        let last = performers.len() - 1;
        let controllers = from_fn(|lane| performers[lane.min(last)].controller());
        let mut trackers = Trackers::join(controllers, narrow(dt_s))?;
        let mut frames = [const { Vec::new() }; AHEAD];
        for (ahead, frames) in frames.iter_mut().enumerate() {
            for performer in &mut *performers {
                performer.read_frame(ahead);
                frames.push(performer.frame_poses().to_vec());
            }
        }
        let frames = frames.each_ref().map(|of_runs: &Vec<Vec<Transform>>| {
            from_fn(|lane| of_runs[lane.min(last)].as_slice())
        });
        let before = from_fn(|lane| performers[lane.min(last)].readings()[0]);
        trackers.begin(frames, before);
        Some(Self { trackers, are_valid: [true; LANES] })
    }

    /// Reads the sensors of a run, and the frame that its tracker needs.
    pub(super) fn sense(performer: &mut Performer<'_>, poses: &[Pose]) {
        performer.sense(poses);
        performer.read_frame(AHEAD);
    }

    /// Computes the torques of all runs.
    pub(super) fn step(&mut self, performers: [&Performer<'_>; LANES]) {
        let frames = performers.map(Performer::frame_poses);
        let readings = performers.map(|performer| performer.readings()[1]);
        self.are_valid = self.trackers.step(frames, readings);
    }

    /// Computes the drives of a run from its torques.
    pub(super) fn act(
        &self,
        lane: usize,
        performer: &mut Performer<'_>,
        poses: &[Pose],
    ) -> Result<(), RunError> {
        if self.are_valid[lane] {
            performer.act_by(self.trackers.torques(lane), poses)
        } else {
            // The run's own tracker names the fault.
            performer.act_anew(poses)
        }
    }
}
