//! Solves a whole clip at once: contacts and paths use later frames too.

use glam::DVec3;
use sinew_mocap::Clip;
use sinew_rig::Mechanism;

use super::contact::contacts;
use super::limb::{BakedLimb, Hand};
use super::path::Frames;
use super::performance::Performance;
use super::settings::Settings;
use super::solver::{ActiveBound, Solver};
use super::terms::{Kind, Target, Term};
use crate::performer::Performer;
use crate::rig::RigMatch;
use crate::{Landmark, Side};

/// Sweeps per frame: for posture alone; with root and feet; and with the path of a hand, for which joints may turn far
/// between two frames.
const POSTURE_SWEEPS: usize = 1;
const SWEEPS: usize = 2;
const HAND_SWEEPS: usize = 6;
/// Number of sweeps of the first frame.
const FIRST_SWEEPS: usize = 30;
/// Weights of the hips' position and of a toe's position (in the air, and standing), divided by the squared leg
/// length.
const HIPS: f64 = 0.3;
const TOE: [f64; 2] = [4.0, 60.0];

/// A clip converted to a rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Baked {
    /// Time from frame to frame, s.
    pub frame_time_s: f64,
    /// Joint coordinates of each frame, in the order of [`Mechanism::coordinate_ranges`].
    pub q: Vec<Vec<f64>>,
    /// Limbs of each frame that have a target.
    pub limbs: Vec<Vec<BakedLimb>>,
    /// Hands whose paths are followed.
    pub hands: Vec<Hand>,
    /// For each frame, the target of each hand relative to its shoulder, m; `None` if the performer lacks it.
    pub hand_targets_m: Vec<Vec<Option<[f32; 3]>>>,
    /// Joints of each frame at an end of their range, or at their maximum speed.
    pub held: Vec<Vec<ActiveBound>>,
}

/// Computes the rig's poses for a clip. `performer` must have been measured on this clip. Takes about 0.1 ms per frame
/// for 30 joints.
///
/// The base travels if it is free (`mount.base = "driven"`) and `settings.travels` is true.
pub fn bake(
    mechanism: &Mechanism,
    rig: &RigMatch,
    clip: &Clip,
    performer: &Performer,
    settings: &Settings,
) -> Baked {
    let mut solver = Solver::new(mechanism, rig, settings);
    solver.free_hands(settings.speed_rad_s);
    let sweeps = if solver.hands().is_empty() { SWEEPS } else { HAND_SWEEPS };
    let performance = Performance { performer, clip };
    let (frame_s, count) = (clip.frame_time_s, clip.frames.len());
    let first = solver.find_branch(&performance);
    let plan = solver.plan(&performance, &first, settings);
    let mut baked = Baked {
        frame_time_s: frame_s,
        q: Vec::with_capacity(count),
        limbs: Vec::with_capacity(count),
        hands: solver.hands(),
        hand_targets_m: Vec::with_capacity(count),
        held: Vec::with_capacity(count),
    };
    for (index, frame) in performance.frames().enumerate() {
        solver.aim(&frame);
        if let Some(plan) = &plan {
            solver.follow(plan, index);
        }
        if index == 0 {
            solver.settle(&first, FIRST_SWEEPS);
        } else {
            solver.begin();
            for _ in 0..sweeps {
                solver.sweep(Some(frame_s));
            }
        }
        baked.q.push(solver.q().to_vec());
        baked.limbs.push(solver.limbs());
        baked.hand_targets_m.push(solver.hand_targets_m());
        baked.held.push(solver.held().collect());
    }
    baked
}

impl Solver {
    /// Permits joints that move a hand along a path a speed of at least `speed`, rad/s, in this clip's time. With a
    /// lower speed, the hand would leave its path; a fit can slow the motion down later.
    fn free_hands(&mut self, speed: f64) {
        let paths = self.terms.iter().filter(|term| matches!(term.kind, Kind::Way { .. }));
        for dof in paths.flat_map(Term::dofs) {
            let least = if self.model.slides[dof] { f64::INFINITY } else { speed };
            self.model.speeds[dof] = self.model.speeds[dof].max(least);
        }
    }
}

/// Paths of hips and toes.
struct Plan {
    hips_m: Vec<DVec3>,
    toes_m: Vec<Vec<DVec3>>,
    contacts: Vec<Vec<f64>>,
    /// Inverse of the squared leg length, 1/m².
    per_m2: f64,
}

impl Solver {
    /// Performs a pass with posture alone, and plans the paths of hips and toes from its poses. Returns `None` if the
    /// rig does not travel, or if its hips, its leg length, the scale or the performer's hips are unknown.
    fn plan(
        &mut self,
        performance: &Performance<'_>,
        first: &[f64],
        settings: &Settings,
    ) -> Option<Plan> {
        self.aims.hips_term?;
        let Performance { performer, clip } = performance;
        let (frame_s, count) = (clip.frame_time_s, clip.frames.len());
        let (hips, leg_m) = (self.aims.hips?, self.aims.leg_m?);
        let scale = settings.scale.or(performer.leg_m.map(|of_performer| leg_m / of_performer))?;
        let feet: Vec<usize> = (0..2).filter(|foot| self.aims.toe_terms[*foot].is_some()).collect();
        let mut toes_from_hips: Vec<Vec<DVec3>> = vec![Vec::with_capacity(count); feet.len()];
        let floor_m = DVec3::Y * performer.floor_m;
        let mut wanted_m: Option<Vec<DVec3>> = Some(Vec::with_capacity(count));
        let mut seen_m: Vec<Option<Vec<DVec3>>> = vec![Some(Vec::with_capacity(count)); feet.len()];
        for (index, frame) in performance.frames().enumerate() {
            let seen = self.aims.seen(&frame);
            push(&mut wanted_m, seen.hips_m().map(|hips_m| (hips_m - floor_m) * scale));
            for (foot, seen_m) in feet.iter().zip(&mut seen_m) {
                push(seen_m, seen.points_m[Landmark::Toe(Side::ALL[*foot])]);
            }
            self.aim(&frame);
            if index == 0 {
                self.settle(first, FIRST_SWEEPS);
            } else {
                self.begin();
                for _ in 0..POSTURE_SWEEPS {
                    self.sweep(Some(frame_s));
                }
            }
            let hips_m = self.state.point_m(&hips);
            for (foot, from_hips) in feet.iter().zip(&mut toes_from_hips) {
                let toe_m = self.aims.toes[*foot].map(|toe| self.state.point_m(&toe));
                from_hips.push(toe_m.unwrap_or(hips_m) - hips_m);
            }
        }
        let contacts: Option<Vec<Vec<f64>>> = seen_m
            .into_iter()
            .map(|toe_m| Some(contacts(&toe_m?, frame_s, performer.floor_m)))
            .collect();
        // A performer without toes has no contacts.
        let contacts = contacts.unwrap_or_else(|| vec![vec![0.0; count]; feet.len()]);
        let wanted_m = wanted_m?;
        let known =
            Frames { frame_s, wanted_m: &wanted_m, toes_m: &toes_from_hips, contacts: &contacts };
        let hips_m = known.hips_m();
        let toes_m = (0..feet.len()).map(|foot| known.toe_m(foot, &hips_m)).collect();
        Some(Plan { hips_m, toes_m, contacts, per_m2: (leg_m * leg_m).recip() })
    }

    /// Sets the targets of hips and toes for a frame of the plan.
    fn follow(&mut self, plan: &Plan, index: usize) {
        if let Some(term) = self.aims.hips_term {
            let (vector, weight) = (plan.hips_m[index], HIPS * plan.per_m2);
            self.targets[term] = Target { vector, weight, ..Target::NONE };
        }
        let terms: Vec<usize> = self.aims.toe_terms.into_iter().flatten().collect();
        for (foot, term) in terms.into_iter().enumerate() {
            let [air, stands] = TOE;
            let weight = (air + (stands - air) * plan.contacts[foot][index]) * plan.per_m2;
            self.targets[term] =
                Target { vector: plan.toes_m[foot][index], weight, ..Target::NONE };
        }
    }
}

/// Appends to a list that becomes `None` as soon as one value is missing.
fn push<T>(list: &mut Option<Vec<T>>, value: Option<T>) {
    match (list.as_mut(), value) {
        (Some(list), Some(value)) => list.push(value),
        _ => *list = None,
    }
}
