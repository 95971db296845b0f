//! One step of the solver, which respects bounds within the step.

use sinew_rig::Mechanism;

use super::aim::Aims;
use super::limb::{BakedLimb, Hand};
use super::model::{Model, State};
use super::normal::Normal;
use super::settings::Settings;
use super::terms::{Target, Term};
use crate::LandmarkMap;
use crate::performer::PerformerFrame;
use crate::rig::RigMatch;

/// Weight that pulls a joint to its position of 1/30 s ago, per rad². Together with `HOME`, it determines the joints
/// that no term determines.
const STILL: f64 = 0.01;

const STILL_FRAME_S: f64 = 1.0 / 30.0;

const HOME: f64 = 0.001;

/// Weight that pulls a free base to its pose in the previous frame, per rad². It replaces `STILL` and `HOME`.
const BASE: f64 = 1e-6;

/// Maximum rotation of a joint by a sweep, rad: the linear model of a step is valid up to it.
const STEP: f64 = 0.5;

/// Distance from an end of a range that counts as at the end, rad or m.
const NEAR: f64 = 1e-9;

/// A joint at a bound in a frame's pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ActiveBound {
    /// Index of the dof, in the order of [`Mechanism::dof_names`].
    pub dof: usize,
    /// Kind of the bound.
    pub bound: Bound,
}

/// Kind of a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// An end of the joint's range.
    Range,
    /// The joint's maximum speed.
    Speed,
}

/// A solver for one rig. The constructor allocates the memory of all steps: `sweep` allocates nothing.
#[derive(Debug, Clone)]
pub(crate) struct Solver {
    pub(super) model: Model,
    pub(super) state: State,
    pub(super) aims: Aims,
    pub(super) terms: Vec<Term>,
    pub(super) targets: Vec<Target>,
    /// Dofs that some term depends on.
    pub(super) unknown: Vec<usize>,
    pub(super) normal: Normal,
    pub(super) step: Vec<f64>,
    pub(super) away: Vec<f64>,
    pub(super) home_away: Vec<f64>,
    pub(super) previous: Vec<f64>,
    /// Factor on the weights that pull a joint to its home and to its position in the last frame, for slides, 1/m².
    pub(super) per_m2: f64,
}

impl Solver {
    pub(crate) fn new(mechanism: &Mechanism, rig: &RigMatch, settings: &Settings) -> Self {
        let model = Model::of(mechanism, settings.speed_rad_s);
        let state = model.state();
        let (aims, terms) = Aims::new(&model, &state, rig, settings);
        let mut unknown: Vec<usize> = terms.iter().flat_map(Term::dofs).collect();
        unknown.sort_unstable();
        unknown.dedup();
        let dofs = model.dof_count();
        let reach_m = aims.reach_m.max(1e-3);
        Self {
            normal: Normal::new(dofs, &unknown),
            targets: vec![Target::NONE; terms.len()],
            step: vec![0.0; dofs],
            away: vec![0.0; dofs],
            home_away: vec![0.0; dofs],
            previous: state.q.clone(),
            per_m2: (reach_m * reach_m).recip(),
            model,
            state,
            aims,
            terms,
            unknown,
        }
    }

    /// Sets the targets for a frame. For root and feet see [`Aims`].
    pub(super) fn aim(&mut self, frame: &PerformerFrame) {
        self.aims.aim(frame, &mut self.targets);
    }

    /// Begins a new frame: the present pose becomes the previous one.
    pub(super) fn begin(&mut self) {
        self.previous.copy_from_slice(&self.state.q);
    }

    /// Performs one step towards the targets. Returns the largest motion of a joint, rad or m. `frame_s` is the
    /// time since the last pose; with `None` there was no pose, and speed is unlimited.
    pub(super) fn sweep(&mut self, frame_s: Option<f64>) -> f64 {
        self.normal.clear();
        for (term, target) in self.terms.iter().zip(&self.targets) {
            term.add(&self.state, target, &mut self.normal);
        }
        self.model.away(&self.state, &self.previous, &mut self.away);
        self.model.away(&self.state, &self.model.home, &mut self.home_away);
        let base = self.model.base_dofs();
        let still = STILL * frame_s.map_or(1.0, |frame_s| STILL_FRAME_S / frame_s);
        for (place, &dof) in self.unknown.iter().enumerate() {
            let scale = if self.model.slides[dof] { self.per_m2 } else { 1.0 };
            let away = self.away[dof];
            if base.contains(&dof) {
                self.normal.add_single(place, away, BASE * scale);
                continue;
            }
            // Without a last pose, the pull only keeps the step small.
            let away_still = if frame_s.is_some() { away } else { 0.0 };
            self.normal.add_single(place, away_still, still * scale);
            self.normal.add_single(place, self.home_away[dof], HOME * scale);
            let [least, most] = self.bounds(dof, away, frame_s);
            (self.normal.least[place], self.normal.most[place]) = (least, most);
        }
        let x = self.normal.solve();
        self.step.fill(0.0);
        let mut largest: f64 = 0.0;
        for (x, dof) in x.iter().zip(&self.unknown) {
            self.step[*dof] = *x;
            largest = largest.max(x.abs());
        }
        self.model.advance(&mut self.state, &self.step);
        largest
    }

    /// Returns the bounds of a step of a dof.
    pub(super) fn bounds(&self, dof: usize, away: f64, frame_s: Option<f64>) -> [f64; 2] {
        let furthest = if self.model.slides[dof] { f64::INFINITY } else { STEP };
        let q = self.model.coordinates[dof].map(|coordinate| self.state.q[coordinate]);
        let [low, high] = self.model.ranges[dof];
        let (to_low, to_high) = q.map_or((-furthest, furthest), |q| (low - q, high - q));
        let most_s = frame_s.map_or(f64::INFINITY, |frame_s| self.model.speeds[dof] * frame_s);
        // The range has priority over the speed.
        let inside = |x: f64| x.clamp(to_low, to_high);
        let least = inside((-most_s - away).max(-furthest));
        let most = inside((most_s - away).min(furthest));
        [least, most.max(least)]
    }

    /// Returns the weighted squared errors, and the squared distance of the joints from home.
    pub(super) fn cost(&mut self) -> [f64; 2] {
        let errors = self.terms.iter().zip(&self.targets);
        let errors = errors.map(|(term, target)| term.cost(&self.state, target)).sum();
        self.model.away(&self.state, &self.model.home, &mut self.home_away);
        let base = self.model.base_dofs();
        let home = self.unknown.iter().filter(|dof| !base.contains(dof));
        [errors, home.map(|dof| self.home_away[*dof] * self.home_away[*dof]).sum()]
    }

    /// Returns the limbs that have a target.
    pub(super) fn limbs(&self) -> Vec<BakedLimb> {
        let errors_rad = self.limb_errors_rad();
        let targets = self.aims.limb_targets(&self.targets);
        #[expect(clippy::cast_possible_truncation, reason = "directions and angles")]
        let limb = |(landmark, target): (_, &Option<glam::DVec3>)| {
            let target = target.as_ref()?.to_array().map(|x| x as f32);
            Some(BakedLimb { landmark, target, error_rad: errors_rad[landmark]? as f32 })
        };
        targets.iter().filter_map(limb).collect()
    }

    /// Returns the angle between each limb's direction and its target, rad.
    pub(crate) fn limb_errors_rad(&self) -> LandmarkMap<Option<f64>> {
        self.aims.limb_errors_rad(&self.state, &self.terms, &self.targets)
    }

    /// Returns the hands whose paths are followed.
    pub(super) fn hands(&self) -> Vec<Hand> {
        self.aims.hands(&self.terms).map(|(_, hand)| hand).collect()
    }

    /// Returns the target of each of these hands relative to its shoulder, m; `None` if the performer lacks it.
    pub(super) fn hand_targets_m(&self) -> Vec<Option<[f32; 3]>> {
        let target_m = |(place, _): (usize, Hand)| {
            let target = self.targets.get(place).filter(|target| target.weight > 0.0)?;
            #[expect(clippy::cast_possible_truncation, reason = "places in metres")]
            Some(target.vector.to_array().map(|x| x as f32))
        };
        self.aims.hands(&self.terms).map(target_m).collect()
    }

    /// Returns the errors by which poses are compared: the angles of the limbs, rad, or the distances of the hands
    /// whose paths are followed, as shares of the arms.
    pub(super) fn errors(&self) -> Vec<f64> {
        let error = |(place, hand): (usize, Hand)| {
            let target = self.targets.get(place).filter(|target| target.weight > 0.0)?;
            let way_m = self.state.point_m(&hand.point) - self.state.point_m(&hand.shoulder);
            Some(way_m.distance(target.vector) / hand.arm_m)
        };
        let hands: Vec<f64> = self.aims.hands(&self.terms).filter_map(error).collect();
        if hands.is_empty() {
            self.limb_errors_rad().iter().filter_map(|(_, error)| *error).collect()
        } else {
            hands
        }
    }

    /// Returns the joints that the last sweep held at a bound.
    pub(crate) fn held(&self) -> impl Iterator<Item = ActiveBound> + '_ {
        let at = |(place, dof): (usize, &usize)| {
            if self.normal.held(place) == 0 {
                return None;
            }
            let q = self.state.q[self.model.coordinates[*dof]?];
            let [low, high] = self.model.ranges[*dof];
            let bound =
                if q <= low + NEAR || q >= high - NEAR { Bound::Range } else { Bound::Speed };
            Some(ActiveBound { dof: *dof, bound })
        };
        self.unknown.iter().enumerate().filter_map(move |(place, dof)| at((place, dof)))
    }

    /// Returns the joint coordinates.
    pub(crate) fn q(&self) -> &[f64] {
        &self.state.q
    }
}
