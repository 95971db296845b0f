//! One step of the solver, with bounds kept inside it.

use sinew_rig::Mechanism;

use super::aim::Aims;
use super::limb::BakedLimb;
use super::model::{Model, State};
use super::normal::Normal;
use super::settings::Settings;
use super::terms::{Target, Term};
use crate::LandmarkMap;
use crate::performer::PerformerFrame;
use crate::rig::RigMatch;

/// Pull of a joint to where it was a frame of 1/30 s ago, and home, per rad²: they decide what nothing else decides.
const STILL: f64 = 0.01;

const STILL_FRAME_S: f64 = 1.0 / 30.0;

const HOME: f64 = 0.001;

/// The same of a free base.
const BASE: f64 = 1e-6;

/// A sweep turns no joint by more, rad: the model of a step is good for that far.
const STEP: f64 = 0.5;

/// At an end of a range within this, rad or m.
const NEAR: f64 = 1e-9;

/// A joint that a frame's pose holds at a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ActiveBound {
    /// Index of the dof, as [`Mechanism::dof_names`] lists them.
    pub dof: usize,
    /// Which bound.
    pub bound: Bound,
}

/// What holds a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The end of its range.
    Range,
    /// Its largest speed.
    Speed,
}

/// Solves for one rig. All memory is taken by the constructor.
#[derive(Debug, Clone)]
pub(crate) struct Solver {
    pub(super) model: Model,
    pub(super) state: State,
    pub(super) aims: Aims,
    pub(super) terms: Vec<Term>,
    pub(super) targets: Vec<Target>,
    /// Dofs that some term asks for.
    pub(super) unknown: Vec<usize>,
    pub(super) normal: Normal,
    pub(super) step: Vec<f64>,
    pub(super) away: Vec<f64>,
    pub(super) home_away: Vec<f64>,
    pub(super) previous: Vec<f64>,
    /// Pulls home and to the last frame count this much less for slides, 1/m².
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

    /// Aims at a frame. Root and feet: see [`Aims`].
    pub(super) fn aim(&mut self, frame: &PerformerFrame) {
        self.aims.aim(frame, &mut self.targets);
    }

    /// One frame later: the pose so far is the last one.
    pub(super) fn begin(&mut self) {
        self.previous.copy_from_slice(&self.state.q);
    }

    /// One step towards the targets; how far the joint that it moved most went, rad or m. `frame_s`: time since the
    /// last pose; `None` if there was none, and speed is free.
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
            // Without a last pose the pull only keeps the step small.
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

    /// How far a step may go.
    pub(super) fn bounds(&self, dof: usize, away: f64, frame_s: Option<f64>) -> [f64; 2] {
        let furthest = if self.model.slides[dof] { f64::INFINITY } else { STEP };
        let q = self.model.coordinates[dof].map(|coordinate| self.state.q[coordinate]);
        let [low, high] = self.model.ranges[dof];
        let (to_low, to_high) = q.map_or((-furthest, furthest), |q| (low - q, high - q));
        let most_s = frame_s.map_or(f64::INFINITY, |frame_s| self.model.speeds[dof] * frame_s);
        // The range comes first where both cannot be kept.
        let inside = |x: f64| x.clamp(to_low, to_high);
        let least = inside((-most_s - away).max(-furthest));
        let most = inside((most_s - away).min(furthest));
        [least, most.max(least)]
    }

    /// Squared errors, weighted, and how far the joints are from home.
    pub(super) fn cost(&mut self) -> [f64; 2] {
        let errors = self.terms.iter().zip(&self.targets);
        let errors = errors.map(|(term, target)| term.cost(&self.state, target)).sum();
        self.model.away(&self.state, &self.model.home, &mut self.home_away);
        let base = self.model.base_dofs();
        let home = self.unknown.iter().filter(|dof| !base.contains(dof));
        [errors, home.map(|dof| self.home_away[*dof] * self.home_away[*dof]).sum()]
    }

    /// The limbs that are asked for.
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

    /// Angle between each limb's direction and its target, rad.
    pub(crate) fn limb_errors_rad(&self) -> LandmarkMap<Option<f64>> {
        self.aims.limb_errors_rad(&self.state, &self.terms, &self.targets)
    }

    /// Joints that the last sweep held at a bound.
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

    /// Joint coordinates.
    pub(crate) fn q(&self) -> &[f64] {
        &self.state.q
    }
}
