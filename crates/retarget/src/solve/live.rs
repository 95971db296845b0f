//! Converts a performance frame by frame, as it arrives.

use glam::DVec3;
use sinew_rig::Mechanism;

use super::contact::stands;
use super::settings::Settings;
use super::solver::{ActiveBound, Solver};
use super::terms::Target;
use crate::performer::{Performer, PerformerFrame};
use crate::rig::RigMatch;
use crate::{Landmark, LandmarkMap, Side};

/// Weights of the hips' position and of a standing toe's position, divided by the squared leg length.
const HIPS: f64 = 0.3;
const TOE: f64 = 60.0;
/// Time constants with which the hips return to the performer's path, horizontally and in height, s.
const HIPS_S: [f64; 2] = [1.6, 0.3];
/// Time constant of the low-pass of a toe's speed, s; and of the beginning and end of a contact, s.
const SPEED_S: f64 = 0.03;
const RAMP_S: f64 = 0.05;

/// Converts a performance to a rig as it arrives: after the first frame with one sweep per frame, without allocation.
#[derive(Debug, Clone)]
pub struct Live {
    solver: Solver,
    scale: Option<f64>,
    floor_m: f64,
    per_m2: f64,
    last: Option<Last>,
}

/// State of the previous frame.
#[derive(Debug, Clone, Copy)]
struct Last {
    hips_m: DVec3,
    feet: [Foot; 2],
}

#[derive(Debug, Clone, Copy, Default)]
struct Foot {
    toe_m: Option<DVec3>,
    speed_m_s: Option<f64>,
    contact: f64,
    pin_m: Option<DVec3>,
}

/// The error of a frame with a NaN or infinite number, or of a frame time that is not a finite number above 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected a frame of finite numbers and a time above 0, found others: the pose stays")]
pub struct NotFinite;

impl Live {
    /// Creates a converter for one rig and one performer.
    pub fn new(
        mechanism: &Mechanism,
        rig: &RigMatch,
        performer: &Performer,
        settings: &Settings,
    ) -> Self {
        let solver = Solver::new(mechanism, rig, settings);
        let leg_m = solver.aims.leg_m;
        let scale = settings.scale.or(leg_m.zip(performer.leg_m).map(|(rig, of)| rig / of));
        Self {
            per_m2: leg_m.map_or(0.0, |leg_m| (leg_m * leg_m).recip()),
            solver,
            scale,
            floor_m: performer.floor_m,
            last: None,
        }
    }

    /// Processes a frame, and returns the pose as joint coordinates in the order of
    /// [`Mechanism::coordinate_ranges`]. The first frame takes 16 starts of at most 40 sweeps; each later frame
    /// takes a single sweep.
    ///
    /// # Errors
    /// [`NotFinite`] if a number of the frame is NaN or infinite, or `frame_s` is not a finite number above 0; the pose
    /// is unchanged.
    pub fn step(&mut self, frame: &PerformerFrame, frame_s: f64) -> Result<&[f64], NotFinite> {
        if !(frame.is_finite() && frame_s > 0.0 && frame_s.is_finite()) {
            return Err(NotFinite);
        }
        self.solver.aim(frame);
        let is_first = self.last.is_none();
        if is_first {
            self.solver.find_first();
        }
        self.plan(frame, frame_s);
        self.solver.begin();
        self.solver.sweep((!is_first).then_some(frame_s));
        Ok(self.solver.q())
    }

    /// Returns the angle between each limb's direction and the performer's, rad, for the landmark at the limb's
    /// end.
    pub fn limb_errors_rad(&self) -> LandmarkMap<Option<f64>> {
        self.solver.limb_errors_rad()
    }

    /// Returns the joints at an end of their range, or at their maximum speed.
    pub fn held(&self) -> impl Iterator<Item = ActiveBound> + '_ {
        self.solver.held()
    }

    /// Sets the targets of hips and toes.
    fn plan(&mut self, frame: &PerformerFrame, frame_s: f64) {
        let solver = &mut self.solver;
        let (Some(term), Some(hips), Some(scale)) =
            (solver.aims.hips_term, solver.aims.hips, self.scale)
        else {
            self.last.get_or_insert(Last { hips_m: DVec3::ZERO, feet: [Foot::default(); 2] });
            return;
        };
        let seen = solver.aims.seen(frame);
        let Some(of_performer_m) = seen.hips_m() else { return };
        let wanted_m = (of_performer_m - DVec3::Y * self.floor_m) * scale;
        let hips_m = solver.state.point_m(&hips);
        let mut last = self.last.unwrap_or_else(|| {
            // At the start, the lower toe stands on the floor.
            let toes = solver.aims.toes.iter().flatten();
            let lowest = toes.map(|toe| solver.state.point_m(toe).y).fold(f64::INFINITY, f64::min);
            let height = if lowest.is_finite() { hips_m.y - lowest } else { wanted_m.y };
            let by_m = wanted_m.with_y(height) - hips_m;
            solver.move_base(by_m);
            Last { hips_m: wanted_m, feet: [Foot::default(); 2] }
        });
        let target_m = solver.state.point_m(&hips) + (wanted_m - last.hips_m);
        let back = DVec3::new(HIPS_S[0], HIPS_S[1], HIPS_S[0]).recip() * frame_s;
        let target_m = target_m + (wanted_m - target_m) * back.min(DVec3::ONE);
        let weight = HIPS * self.per_m2;
        solver.targets[term] = Target { vector: target_m, weight, ..Target::NONE };
        for (k, foot) in last.feet.iter_mut().enumerate() {
            let (Some(term), Some(toe)) = (solver.aims.toe_terms[k], solver.aims.toes[k]) else {
                continue;
            };
            let Some(toe_m) = seen.points_m[Landmark::Toe(Side::ALL[k])] else { continue };
            let here_m = solver.state.point_m(&toe);
            foot.update(toe_m, here_m, self.floor_m, frame_s);
            let weight = TOE * foot.contact * self.per_m2;
            let vector = foot.pin_m.unwrap_or(here_m);
            solver.targets[term] = Target { vector, weight, ..Target::NONE };
        }
        last.hips_m = wanted_m;
        self.last = Some(last);
    }
}

impl Foot {
    /// Updates a foot. `toe_m` is the performer's toe; `here_m` is the rig's.
    fn update(&mut self, toe_m: DVec3, here_m: DVec3, floor_m: f64, frame_s: f64) {
        let last = self.toe_m.replace(toe_m);
        // A single frame gives no speed, and therefore no contact.
        let Some(new_m_s) = last.map(|last| last.distance(toe_m) / frame_s) else { return };
        let speed_m_s = self.speed_m_s.map_or(new_m_s, |speed_m_s| {
            speed_m_s + (new_m_s - speed_m_s) * (frame_s / SPEED_S).min(1.0)
        });
        self.speed_m_s = Some(speed_m_s);
        let contact = stands(speed_m_s, toe_m.y - floor_m);
        let most = frame_s / RAMP_S;
        self.contact += (contact - self.contact).clamp(-most, most);
        if self.contact <= 0.0 {
            self.pin_m = None;
        } else if self.pin_m.is_none() {
            self.pin_m = Some(here_m.with_y(0.0));
        }
    }
}

impl Solver {
    /// Moves a free base by a vector in the world.
    fn move_base(&mut self, by_m: DVec3) {
        let base = self.model.base_dofs();
        self.step.fill(0.0);
        if base.len() == 6 {
            by_m.write_to_slice(&mut self.step[base.start + 3..base.end]);
            self.model.advance(&mut self.state, &self.step);
        }
    }
}
