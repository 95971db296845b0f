//! Converts a frame of a performance to targets of the rig's terms.

use glam::{DMat3, DQuat, DVec3};

use super::limb::Hand;
use super::model::{Model, State};
use super::settings::{Limb, Settings};
use super::terms::{Kind, Target, Term, upright};
use crate::performer::{PerformerFrame, segment_above};
use crate::rig::{RigMatch, RigPoint};
use crate::{Landmark, LandmarkMap, Side};

/// Weights of posture terms, per rad².
const PELVIS: f64 = 1.0;
const CHEST: f64 = 0.5;
const HEAD: f64 = 0.2;
const FOOT: f64 = 0.1;
const SEGMENT: f64 = 0.5;
const TWIST: f64 = 0.05;
/// Weights of a limb with too few joints: of its first and of its second priority.
const FIRST: f64 = 1.0;
const AFTER: f64 = 0.1;
/// Weights of a hand's place, divided by the squared length of the arm, and of the directions of its arm.
const HAND: f64 = 10.0;
const GUIDE: f64 = 0.05;
/// Minimum certainty of a limb's bending axis. Below it, the limb gets no twist target.
const CERTAIN: f64 = 0.5;
/// Minimum number of joints of a ball that can twist its limb in addition to pointing it.
const BALL: usize = 3;

/// The property of the performer that a term takes its target from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    Segment(Landmark),
    Limb {
        from: Landmark,
        to: Landmark,
    },
    Part(Landmark),
    Bend(Landmark),
    /// Way from shoulder to hand: the landmarks of the arm, and the length of the rig's arm, m.
    Hand {
        chain: [Landmark; 3],
        arm_m: f64,
    },
    /// Set by the planner of root and feet.
    Planned,
}

/// Sources of the targets, with their weights.
#[derive(Debug, Clone)]
pub(super) struct Aims {
    sources: Vec<(Source, f64)>,
    /// Midpoint between the hips, on the pelvis; `None` if the rig lacks a hip or the pelvis.
    pub(super) hips: Option<RigPoint>,
    /// Indices of the terms of the hips and of the toes.
    pub(super) hips_term: Option<usize>,
    pub(super) toe_terms: [Option<usize>; 2],
    pub(super) toes: [Option<RigPoint>; 2],
    /// Length of the rig's legs, m.
    pub(super) leg_m: Option<f64>,
    /// Length of the longest limb, m.
    pub(super) reach_m: f64,
    /// For a rig with a fixed base: the part of the performer that corresponds to the base, and the orientation of
    /// the base.
    seen_from: Option<(Landmark, DQuat)>,
    is_mirrored: bool,
    /// Tilt of the performance, in the axes of a part.
    tilt: DQuat,
    /// Body that is oriented like the performer at the start, with forward, left, up in its frame, and its
    /// landmark.
    pub(super) stands: Option<(usize, DQuat, Landmark)>,
}

impl Aims {
    pub(super) fn new(
        model: &Model,
        state: &State,
        rig: &RigMatch,
        settings: &Settings,
    ) -> (Self, Vec<Term>) {
        let is_free = !model.base_dofs().is_empty();
        let mut list = List { model, all: Vec::new(), sources: Vec::new() };
        let directions = DMat3::from_quat(rig.directions.rotation());
        let upright_of = |body: usize| upright(rig.rotations_at_zero[body], directions);
        let [hips, shoulders] = [Landmark::Hip as fn(Side) -> Landmark, Landmark::Shoulder];
        let ball_joints = |ball: Landmark| rig.joints(ball).len();

        list.part(rig.pelvis, upright_of, Landmark::Pelvis, PELVIS);
        let chest = rig.chest.filter(|chest| Some(*chest) != rig.pelvis);
        list.part(chest, upright_of, Landmark::Chest, CHEST);
        list.part(rig.head, upright_of, Landmark::Head, HEAD);
        for side in Side::ALL {
            list.part(rig.body(Landmark::Ankle(side)), upright_of, Landmark::Ankle(side), FOOT);
            for (limb, ball, middle, end) in [
                (settings.legs, hips(side), Landmark::Knee(side), Landmark::Ankle(side)),
                (settings.arms, shoulders(side), Landmark::Elbow(side), Landmark::Wrist(side)),
            ] {
                let (Some(top), Some(joint)) = (rig.points[ball], rig.points[middle]) else {
                    continue;
                };
                let upper_weight = match limb {
                    Limb::Both => SEGMENT,
                    Limb::End => AFTER,
                    Limb::Upper => FIRST,
                    Limb::Path => GUIDE,
                };
                list.direction(top, joint, Source::Segment(middle), upper_weight);
                if let Some(tip) = end_point(rig, state, end) {
                    let lower_weight = match limb {
                        Limb::Both => SEGMENT,
                        Limb::End | Limb::Upper => AFTER,
                        Limb::Path => GUIDE,
                    };
                    list.direction(joint, tip, Source::Segment(end), lower_weight);
                    if limb == Limb::End {
                        list.direction(top, tip, Source::Limb { from: ball, to: end }, FIRST);
                    }
                    if limb == Limb::Path {
                        let hand = rig.tips[end].unwrap_or(tip);
                        list.hand(state, [ball, middle, end], [top, joint, tip, hand]);
                    }
                }
                if let Some(hinge) = rig.hinges[middle].filter(|hinge| hinge.is_sure)
                    && ball_joints(ball) >= BALL
                {
                    let (body, axis) = (hinge.body, hinge.axis);
                    let kind = Kind::Twist { body, axis, from: top, to: joint };
                    list.add(kind, Source::Bend(middle), TWIST);
                }
            }
        }
        let reach_m = list.reach_m(state);
        let mut aims = Self {
            sources: Vec::new(),
            hips: middle(rig, state),
            hips_term: None,
            toe_terms: [None; 2],
            toes: Side::ALL
                .map(|side| rig.points[Landmark::Toe(side)].or(rig.points[Landmark::Ankle(side)])),
            leg_m: leg_m(rig, state),
            reach_m,
            seen_from: (!is_free).then(|| {
                let base_is_pelvis = rig.pelvis == Some(0);
                let part = if base_is_pelvis || rig.chest.is_none() {
                    Landmark::Pelvis
                } else {
                    Landmark::Chest
                };
                (part, rig.directions.rotation())
            }),
            is_mirrored: settings.is_mirrored,
            tilt: DQuat::from_rotation_y(-settings.tilt_rad),
            stands: [(rig.pelvis, Landmark::Pelvis), (rig.chest, Landmark::Chest)]
                .into_iter()
                .find_map(|(body, part)| body.map(|body| (body, upright_of(body), part))),
        };
        if is_free
            && settings.travels
            && let (Some(hips), true) = (aims.hips, aims.leg_m.is_some())
        {
            // The base follows the hips. Height is decided by the standing feet.
            let kind = Kind::Position { point: hips, parts: [1.0, 1.0] };
            aims.hips_term = Some(list.add(kind, Source::Planned, 0.0));
            for (k, toe) in aims.toes.into_iter().enumerate() {
                let Some(point) = toe else { continue };
                let kind = Kind::Position { point, parts: [1.0, 1.0] };
                aims.toe_terms[k] = Some(list.add(kind, Source::Planned, 0.0));
            }
        }
        aims.sources = list.sources;
        (aims, list.all)
    }

    /// Sets the targets of posture. Those of root and feet are unchanged.
    pub(super) fn aim(&self, frame: &PerformerFrame, targets: &mut [Target]) {
        let frame = &self.seen(frame);
        for ((source, weight), target) in self.sources.iter().zip(targets) {
            let direction = |from, to| {
                frame.direction(from, to).map(|vector| Target {
                    vector,
                    weight: *weight,
                    ..Target::NONE
                })
            };
            let found = match *source {
                Source::Planned => continue,
                Source::Segment(landmark) => {
                    segment_above(landmark).and_then(|above| direction(above, landmark))
                }
                Source::Limb { from, to } => direction(from, to),
                Source::Hand { chain, arm_m } => frame.reach(chain).map(|reach| Target {
                    vector: reach * arm_m,
                    weight: *weight,
                    ..Target::NONE
                }),
                Source::Part(landmark) => frame.parts[landmark].map(|rotation| Target {
                    rotation,
                    weight: *weight,
                    ..Target::NONE
                }),
                Source::Bend(landmark) => frame.bends[landmark]
                    .filter(|(_, certainty)| *certainty >= CERTAIN)
                    .map(|(vector, certainty)| Target {
                        vector,
                        weight: *weight * certainty,
                        ..Target::NONE
                    }),
            };
            *target = found.unwrap_or(Target::NONE);
        }
    }

    /// Returns the target orientation of a part: forward, left, up in the world. `None` if the part has no target at
    /// present.
    pub(super) fn part_target(&self, part: Landmark, targets: &[Target]) -> Option<DQuat> {
        let place = self.sources.iter().position(|(source, _)| *source == Source::Part(part))?;
        Some(targets[place].rotation).filter(|_| targets[place].weight > 0.0)
    }

    /// Returns the performance as the rig uses it: mirrored if requested, and for a rig with a fixed base, relative
    /// to that base.
    pub(super) fn seen(&self, frame: &PerformerFrame) -> PerformerFrame {
        let frame = if self.is_mirrored { frame.mirrored() } else { *frame };
        let Some((part, base)) = self.seen_from else { return frame };
        let stands =
            frame.parts[part].or(frame.parts[Landmark::Chest]).or(frame.parts[Landmark::Pelvis]);
        let turn = base * self.tilt * stands.unwrap_or(base).conjugate();
        frame.moved(turn, DVec3::ZERO)
    }

    /// Returns the angle between each limb's direction and its target, rad, for the landmark at its end.
    pub(super) fn limb_errors_rad(
        &self,
        state: &State,
        terms: &[Term],
        targets: &[Target],
    ) -> LandmarkMap<Option<f64>> {
        let mut errors = LandmarkMap::default();
        for (((source, _), term), target) in self.sources.iter().zip(terms).zip(targets) {
            if let (Source::Segment(landmark), Kind::Direction { from, to }) = (source, &term.kind)
                && target.weight > 0.0
            {
                let u = (state.point_m(to) - state.point_m(from)).normalize_or_zero();
                let sine = u.cross(target.vector).length();
                errors[*landmark] = Some(libm::atan2(sine, u.dot(target.vector)));
            }
        }
        errors
    }

    /// Returns the hands whose paths are followed, with the indices of their terms.
    pub(super) fn hands<'a>(
        &'a self,
        terms: &'a [Term],
    ) -> impl Iterator<Item = (usize, Hand)> + 'a {
        let places = self.sources.iter().zip(terms).enumerate();
        places.filter_map(|(place, ((source, _), term))| match (source, &term.kind) {
            (Source::Hand { arm_m, .. }, Kind::Way { from, to }) => {
                Some((place, Hand { shoulder: *from, point: *to, arm_m: *arm_m }))
            }
            _ => None,
        })
    }

    /// Returns the target direction of each limb in the rig's world, for the landmark at its end.
    pub(super) fn limb_targets(&self, targets: &[Target]) -> LandmarkMap<Option<DVec3>> {
        let mut limbs = LandmarkMap::default();
        for ((source, _), target) in self.sources.iter().zip(targets) {
            if let Source::Segment(landmark) = source
                && target.weight > 0.0
            {
                limbs[*landmark] = Some(target.vector);
            }
        }
        limbs
    }
}

/// Collects terms with their sources.
struct List<'m> {
    model: &'m Model,
    all: Vec<Term>,
    sources: Vec<(Source, f64)>,
}

impl List<'_> {
    fn add(&mut self, kind: Kind, source: Source, weight: f64) -> usize {
        self.all.push(Term::new(self.model, kind));
        self.sources.push((source, weight));
        self.all.len() - 1
    }

    fn part(
        &mut self,
        body: Option<usize>,
        upright: impl Fn(usize) -> DQuat,
        landmark: Landmark,
        weight: f64,
    ) {
        if let Some(body) = body {
            let kind = Kind::Orientation { body, upright: upright(body) };
            self.add(kind, Source::Part(landmark), weight);
        }
    }

    fn direction(&mut self, from: RigPoint, to: RigPoint, source: Source, weight: f64) {
        self.add(Kind::Direction { from, to }, source, weight);
    }

    /// Adds the place of a hand relative to its shoulder.
    fn hand(&mut self, state: &State, chain: [Landmark; 3], points: [RigPoint; 4]) {
        let places_m = points.map(|point| state.point_m(&point));
        let arm_m: f64 = places_m.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        if arm_m <= f64::EPSILON {
            return;
        }
        let kind = Kind::Way { from: points[0], to: points[3] };
        self.add(kind, Source::Hand { chain, arm_m }, HAND / (arm_m * arm_m));
    }

    fn reach_m(&self, state: &State) -> f64 {
        let lengths = self.all.iter().filter_map(|term| match &term.kind {
            Kind::Direction { from, to } => Some(state.point_m(from).distance(state.point_m(to))),
            _ => None,
        });
        lengths.fold(0.0, f64::max)
    }
}

/// Returns the end of a limb. The end of an arm is fixed to the forearm, because the hand's own joints must not be used
/// to point the forearm.
fn end_point(rig: &RigMatch, state: &State, end: Landmark) -> Option<RigPoint> {
    let point = rig.points[end]?;
    let first = rig.joints(end).first().copied();
    let forearm = match end {
        Landmark::Wrist(side) => rig.joints(Landmark::Elbow(side)).last().copied(),
        _ => None,
    };
    let Some((forearm, _)) = forearm.zip(first) else { return Some(point) };
    let pose = sinew_rig::mechanism::Pose {
        rotation: state.rotations[forearm],
        position_m: state.positions_m[forearm],
    };
    Some(RigPoint { body: forearm, position_m: pose.to_local(state.point_m(&point)) })
}

/// Returns the midpoint between the hips, on the pelvis; `None` if the rig lacks a hip or the pelvis.
fn middle(rig: &RigMatch, state: &State) -> Option<RigPoint> {
    let [left, right] = Side::ALL.map(|side| rig.points[Landmark::Hip(side)]);
    let body = rig.pelvis?;
    let world_m = (state.point_m(&left?) + state.point_m(&right?)) / 2.0;
    let position_m = state.rotations[body].conjugate() * (world_m - state.positions_m[body]);
    Some(RigPoint { body, position_m })
}

/// Returns the mean length of the legs from hip over knee to ankle, m. `None` if a leg lacks one of these points.
fn leg_m(rig: &RigMatch, state: &State) -> Option<f64> {
    let of_side = |side| {
        let point = |landmark: Landmark| Some(state.point_m(&rig.points[landmark]?));
        let [hip, knee, ankle] =
            [Landmark::Hip(side), Landmark::Knee(side), Landmark::Ankle(side)].map(point);
        Some(hip?.distance(knee?) + knee?.distance(ankle?))
    };
    let [left, right] = Side::ALL.map(of_side);
    Some(f64::midpoint(left?, right?))
}
