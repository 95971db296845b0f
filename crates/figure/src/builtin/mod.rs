//! The built-in clips: a fighter of our own making, so that nothing need be downloaded.
//!
//! Twelve clips at 120 Hz hold 80 punches and 40 kicks with the guard and the steps between them.
//! A script says what happens when; key poses, minimum-jerk tracks and inverse kinematics make it a
//! motion of the 18 bodies; noise and gaps make it a recording. All random numbers have explicit
//! seeds and all functions come from `libm`: every machine makes the same bits.
//!
//! After the pipeline's 6 Hz low-pass the knuckles of a punching fist reach 5 to 10 m/s and the toes
//! of a kicking foot 6 to 12 m/s, in the world.

mod ik;
mod kicks;
mod performer;
mod punches;
mod script;
mod sensors;
mod skeleton;
mod stance;
mod strike;
#[cfg(test)]
mod tests;
mod timing;

use rayon::prelude::*;
use sinew_mocap::Recording;

use performer::Performer;
use script::Script;
use sinew_host_util::random::{Random, Subject};
use skeleton::Pose;
use stance::{Footwork, Sway};
use timing::RATE_HZ;

pub use skeleton::Side;
pub use strike::{Strike, StrikeKind};

/// All built-in clips, in the order of their names' numbers, punches first.
pub fn clips() -> Vec<Recording> {
    par_clips().collect()
}

/// The same in parallel, each made where it is used, so that never all of them are in memory.
pub fn par_clips() -> impl IndexedParallelIterator<Item = Recording> {
    script::scripts().into_par_iter().map(|script| clip(&script))
}

/// The strikes in the built-in clip called `name`, in order; `None` if there is no such clip.
pub fn strikes(name: &str) -> Option<Vec<Strike>> {
    script::scripts()
        .iter()
        .find(|script| script.name == name)
        .map(|script| script.strikes().collect())
}

fn clip(script: &Script) -> Recording {
    Recording {
        notes: Vec::new(),
        name: script.name.clone(),
        skeleton: skeleton::skeleton(),
        frame_time_s: Some(1.0 / RATE_HZ),
        metres_per_unit: Some(1.0),
        frames: sensors::record(&perform(script), script.seed),
    }
}

/// The motion itself, without noise and gaps.
fn perform(script: &Script) -> Vec<Pose> {
    let footwork = Footwork::new(script.first, &script.steps);
    let sway = Sway::new(&mut Random::new(script.seed, Subject::Sway));
    let mut performer = Performer::new(footwork, sway);
    for cue in &script.cues {
        if cue.kind.is_kick() {
            kicks::perform(&mut performer, cue);
        } else {
            punches::perform(&mut performer, cue);
        }
    }
    (0..script.frames)
        .map(|frame| {
            let pose = performer.pose(f64::from(frame) / RATE_HZ);
            if script.lead == Side::Left { pose } else { pose.mirrored() }
        })
        .collect()
}
