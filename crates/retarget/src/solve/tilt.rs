//! Chooses the tilt of the performance for a rig with a fixed base.
//!
//! A human arm hangs; an arm that is bolted to a table stands or reaches forward, and cannot point down. With a
//! tilt, the performer's resting arm corresponds to a pose that the rig's arm can reach.

use sinew_mocap::Clip;
use sinew_rig::Mechanism;

use super::settings::Settings;
use super::solver::Solver;
use crate::performer::Performer;
use crate::rig::RigMatch;

/// Tilts that are tried, deg: 90 turns a hanging arm to point forward.
const TILTS_DEG: [f64; 5] = [0.0, 45.0, 90.0, 135.0, 180.0];
/// Number of evaluated frames, and sweeps of each.
const FRAMES: usize = 60;
const SWEEPS: usize = 8;
/// Maximum error of a larger tilt relative to a smaller one, for it to be chosen.
const BETTER: f64 = 0.7;

/// Returns the tilt at which the limbs of a rig with a fixed base point best, rad, for [`Settings::tilt_rad`]; 0
/// for a free base or a rig with a pelvis. Takes about 10 ms.
pub fn best_tilt(
    mechanism: &Mechanism,
    rig: &RigMatch,
    clip: &Clip,
    performer: &Performer,
    settings: &Settings,
) -> f64 {
    // A rig with a pelvis has the orientation of the performer.
    if rig.pelvis.is_some() {
        return 0.0;
    }
    let error = |tilt_rad: f64| {
        let settings = Settings { tilt_rad, ..*settings };
        let mut solver = Solver::new(mechanism, rig, &settings);
        if !solver.model.base_dofs().is_empty() {
            return 0.0;
        }
        let mut world = Vec::new();
        let (mut sum, mut count) = (0.0, 0.0);
        let every = clip.frames.len().div_ceil(FRAMES).max(1);
        for (index, local) in clip.frames.iter().step_by(every).enumerate() {
            solver.aim(&performer.frame(local, &mut world));
            if index == 0 {
                solver.find_first();
            }
            for _ in 0..SWEEPS {
                solver.begin();
                solver.sweep(None);
            }
            for error in solver.errors() {
                sum += error;
                count += 1.0;
            }
        }
        if count > 0.0 { sum / count } else { 0.0 }
    };
    let mut best = (0.0, error(0.0));
    for tilt_rad in TILTS_DEG.into_iter().skip(1).map(f64::to_radians) {
        let found = error(tilt_rad);
        if found < BETTER * best.1 {
            best = (tilt_rad, found);
        }
    }
    best.0
}
