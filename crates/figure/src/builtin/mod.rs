//! The built-in clips: a synthetic fighter. With them, no motion data need be downloaded.
//!
//! Twelve clips at 120 Hz contain 80 punches and 40 kicks, with the guard and the steps between them. A script lists
//! the events of a clip. Key poses, minimum-jerk tracks and inverse kinematics turn the script into a motion of the 18
//! bodies; noise and gaps then turn the motion into a recording. All random numbers have explicit seeds and all
//! functions are from `libm`: every machine produces the same bits.
//!
//! After the pipeline's 6 Hz low-pass the knuckles of a punching fist reach 5 to 10 m/s and the toes of a kicking
//! foot 6 to 12 m/s, in the world.

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

/// Returns all built-in clips, punches first, in the order of the numbers in their names.
pub fn clips() -> Vec<Recording> {
    par_clips().collect()
}

/// Returns all built-in clips as a parallel iterator. Each clip is made where it is used, to avoid holding all of
/// them in memory.
pub fn par_clips() -> impl IndexedParallelIterator<Item = Recording> {
    script::scripts().into_par_iter().map(|script| clip(&script))
}

/// Returns the strikes in the built-in clip called `name`, in order; `None` if there is no clip of that name.
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

/// Returns the motion of a script, without noise and gaps.
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
