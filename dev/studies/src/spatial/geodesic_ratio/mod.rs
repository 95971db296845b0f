//! Ratio of a geodesic to the line that approximates it: `r = L(geodesic) / L(line)`, eq. (8).
//!
//! The paper draws 100 pairs of poses from walking, and finds no r below 0.94.

mod draw;
mod line;
mod report;

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use rayon::prelude::*;
use sinew_core::JointKind;
use sinew_core::projection::JointRange;
use sinew_pose_metrics::geodesic::{self, JointPosition, Options, Rig, RigError, RigJoint};
use sinew_pose_metrics::spatial::{SpatialError, SpatialRig};

use crate::recordings::{Class, Pose, Recordings};
pub use draw::{Moment, Pairing};
pub use line::Line;
pub use report::{json, tables};

/// The lowest r of the paper's 100 pairs.
pub const PAPER_LOWEST_RATIO: f64 = 0.94;

/// Settings of the study.
#[derive(Debug, Clone, Copy)]
pub struct Plan<'a> {
    /// Recordings from which pairs are drawn.
    pub recordings: &'a Recordings,
    /// Joint relative to which poses are compared; if `None`, the skeleton's root.
    pub root: Option<&'a str>,
    /// Pairs for each condition.
    pub pairs: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Steps of curves, N.
    pub steps: usize,
}

/// Weights of the joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counting {
    /// All joints count equally.
    All,
    /// Joints with children count equally; ends (fingers, toes, head) do not count.
    WithoutEnds,
    /// All joints count by their importance.
    Importance,
    /// All joints count equally, and none turns further from rest than in the recordings of the condition.
    WithinRanges,
}

/// A condition of the experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    /// Name of the difference from the first condition.
    pub name: String,
    /// Whether this is the first condition, which is that of the paper.
    pub is_first: bool,
    /// Class of the recordings; if `None`, any.
    pub class: Option<Class>,
    /// Subject of the recordings; if `None`, any.
    pub subject: Option<String>,
    /// Origin of the poses of a pair.
    pub pairing: Pairing,
    /// Steps of curves, N.
    pub steps: usize,
    /// Coordinates of the line.
    pub line: Line,
    /// Weights of the joints.
    pub counting: Counting,
}

impl Condition {
    /// Returns whether the picture shows the condition: poses of anybody, of one recording, of one person.
    pub(crate) fn is_shown(&self) -> bool {
        let of_one = self.pairing == Pairing::OneRecording || self.subject.is_some();
        of_one || self.is_first
    }
}

/// A geodesic and the line.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Files and frames of both poses.
    pub ends: [(String, usize); 2],
    /// The largest turn of a joint between the poses, rad.
    pub turn_rad: f64,
    /// Distance of the joints' positions, m: a lower bound of every length.
    pub positions_m: f64,
    /// Length of the line, m.
    pub line_m: f64,
    /// Length of the geodesic, m.
    pub geodesic_m: f64,
    /// Number of iterations of the solver.
    pub iterations: usize,
    /// Whether the gradient is below the tolerance.
    pub converged: bool,
}

impl Pair {
    /// Returns `L(geodesic) / L(line)`.
    pub fn ratio(&self) -> f64 {
        self.geodesic_m / self.line_m
    }
}

/// A condition and its pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Condition under which the pairs were drawn.
    pub condition: Condition,
    /// Results of the pairs of this condition.
    pub pairs: Vec<Pair>,
}

/// Error of poses that cannot be compared.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The skeleton is invalid.
    #[error(transparent)]
    Skeleton(#[from] SpatialError),
    /// The rig or a pose is invalid.
    #[error(transparent)]
    Rig(#[from] RigError),
}

impl Plan<'_> {
    /// Returns the paper's experiment, and experiments with one difference each, as far as there are recordings for
    /// them.
    pub fn conditions(&self) -> Vec<Condition> {
        let walks = self.recordings.sequences.iter().any(|s| s.class == Class::Walk);
        let class = walks.then_some(Class::Walk);
        let paper = Condition {
            name: if walks { "walking" } else { "all recordings" }.to_owned(),
            is_first: true,
            class,
            subject: None,
            pairing: Pairing::Any,
            steps: self.steps,
            line: Line::RotationVectors,
            counting: Counting::All,
        };
        let often = self.often(class);
        let like =
            |name: &str| Condition { name: name.to_owned(), is_first: false, ..paper.clone() };
        let mut conditions = vec![
            paper.clone(),
            Condition { pairing: Pairing::OneRecording, ..like("of one recording") },
            Condition { pairing: Pairing::TwoPeople, ..like("of two people") },
            Condition { subject: Some(often.clone()), ..like(&format!("of subject {often}")) },
            Condition { steps: 2 * self.steps, ..like(&format!("N = {}", 2 * self.steps)) },
            Condition { steps: 4 * self.steps, ..like(&format!("N = {}", 4 * self.steps)) },
            Condition { line: Line::GreatArcs, ..like("line in quaternions") },
            Condition { line: Line::EulerAngles, ..like("line in Euler angles") },
            Condition { counting: Counting::WithoutEnds, ..like("ends not counted") },
            Condition { counting: Counting::Importance, ..like("joints by importance") },
            Condition { counting: Counting::WithinRanges, ..like("joints within ranges") },
        ];
        for (class, name) in [
            (Some(Class::Run), "running"),
            (Some(Class::Kick), "kicks"),
            (Some(Class::Other), "other motion"),
            (None, "any motion"),
        ] {
            if class != paper.class {
                conditions.push(Condition { class, ..like(name) });
            }
        }
        let possible = |condition: &Condition| self.draw(condition, 1).is_some();
        conditions.retain(possible);
        conditions
    }

    /// Returns the subject with the most recordings of a class; the first of several.
    fn often(&self, class: Option<Class>) -> String {
        let of_class =
            self.recordings.sequences.iter().filter(|s| class.is_none_or(|c| c == s.class));
        let mut counts = BTreeMap::<&str, usize>::new();
        for sequence in of_class {
            *counts.entry(&sequence.subject).or_default() += 1;
        }
        let often = counts.iter().rev().max_by_key(|(_, count)| **count);
        often.map_or(String::new(), |(subject, _)| (*subject).to_owned())
    }

    fn moments(&self, condition: &Condition) -> Vec<Moment<'_>> {
        let mut moments = draw::moments(self.recordings, condition.class);
        if let Some(subject) = &condition.subject {
            moments.retain(|moment| moment.sequence.subject == *subject);
        }
        moments
    }

    fn draw(&self, condition: &Condition, count: usize) -> Option<Vec<[Moment<'_>; 2]>> {
        draw::pairs(&self.moments(condition), condition.pairing, count, self.seed)
    }
}

/// Runs all conditions, with pairs in parallel; `done` is called for every pair. The result is the same for any
/// number of threads.
///
/// # Errors
/// [`Error`] if the skeleton does not have the root, or if the rig or a pose is invalid.
pub fn run(
    plan: &Plan<'_>,
    conditions: &[Condition],
    done: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Outcome>, Error> {
    let spatial = SpatialRig::new(&plan.recordings.skeleton, plan.root)?;
    let outcome = |condition: &Condition| {
        let counting = Counted::new(&spatial, condition.counting, &plan.moments(condition))?;
        let pairs = plan.draw(condition, plan.pairs).unwrap_or_default();
        let pairs = pairs.into_par_iter().map(|pair| {
            let result = counting.compare(pair, condition);
            done(1);
            result
        });
        let pairs = pairs.collect::<Result<_, Error>>()?;
        Ok(Outcome { condition: condition.clone(), pairs })
    };
    conditions.iter().map(outcome).collect()
}

/// A rig with weights of its joints.
struct Counted<'r> {
    spatial: &'r SpatialRig,
    rig: Rig,
    weights: Vec<f64>,
}

impl<'r> Counted<'r> {
    fn new(
        spatial: &'r SpatialRig,
        counting: Counting,
        moments: &[Moment<'_>],
    ) -> Result<Self, Error> {
        let bodies = spatial.tree().bodies();
        let carries = |body: usize| bodies.iter().any(|other| other.parent == Some(body));
        let weight = |body: usize| match counting {
            Counting::All | Counting::WithinRanges => 1.0,
            Counting::WithoutEnds => f64::from(u8::from(carries(body))),
            Counting::Importance => f64::from(spatial.importance()[body]),
        };
        let weights: Vec<f64> = (0..bodies.len()).map(weight).collect();
        let joints = bodies.iter().zip(&weights);
        let mut joints: Vec<RigJoint> = joints
            .map(|(body, weight)| RigJoint { weight: *weight, ..RigJoint::from(body) })
            .collect();
        if counting == Counting::WithinRanges {
            for (body, most) in most_turned_rad(spatial, moments).into_iter().enumerate() {
                // The solver needs a range, but a joint that never turns has none: a milliradian is almost zero.
                #[expect(clippy::cast_possible_truncation, reason = "a range is f32")]
                let most = most.clamp(1e-3, core::f64::consts::PI) as f32;
                if bodies[body].joint == JointKind::Spherical {
                    joints[body].range = JointRange::Turn(most.min(core::f32::consts::PI));
                }
            }
        }
        Ok(Self { spatial, rig: Rig::new(&joints)?, weights })
    }

    fn compare(&self, [from, to]: [Moment<'_>; 2], condition: &Condition) -> Result<Pair, Error> {
        let [a, b] = [from, to].map(|moment| positions(self.spatial, moment.pose()));
        let options = Options { steps: condition.steps, ..Options::default() };
        let geodesic = geodesic::solve(&self.rig, &a, &b, &options)?;
        let on_line = |k: usize| -> Vec<JointPosition> {
            let t = k as f64 / condition.steps as f64;
            let joints = a.iter().zip(&b);
            joints
                .map(|(a, b)| match (a, b) {
                    (JointPosition::Turn(a), JointPosition::Turn(b)) => {
                        JointPosition::Turn(condition.line.between(*a, *b, t))
                    }
                    _ => *a,
                })
                .collect()
        };
        let line: Vec<_> = (0..=condition.steps).map(on_line).collect();
        let turns = a.iter().zip(&b).map(|(a, b)| match (a, b) {
            (JointPosition::Turn(a), JointPosition::Turn(b)) => a.angle_between(*b),
            _ => 0.0,
        });
        let end = |moment: Moment<'_>| (moment.sequence.file.clone(), moment.frame);
        Ok(Pair {
            ends: [end(from), end(to)],
            turn_rad: turns.fold(0.0, f64::max),
            positions_m: self.length_m(&[a.clone(), b.clone()]),
            line_m: self.length_m(&line),
            geodesic_m: geodesic.length_m,
            iterations: geodesic.course.len(),
            converged: geodesic.converged,
        })
    }

    /// Returns the length in space of a curve through poses, m.
    fn length_m(&self, curve: &[Vec<JointPosition>]) -> f64 {
        let places: Vec<_> = curve.iter().map(|pose| self.rig.positions_m(pose)).collect();
        let step = |pair: &[Vec<DVec3>]| {
            let joints = pair[0].iter().zip(&pair[1]).zip(&self.weights);
            let squares = joints.map(|((a, b), weight)| weight * a.distance_squared(*b));
            libm::sqrt(squares.sum())
        };
        places.windows(2).map(step).sum()
    }
}

/// Returns the rotations of a rig's joints in a pose.
fn positions(spatial: &SpatialRig, pose: &Pose) -> Vec<JointPosition> {
    let places = spatial.tree().bodies().iter().zip(spatial.joint_poses(pose));
    places
        .map(|(body, place)| match body.joint {
            JointKind::Spherical => JointPosition::Turn(place.rotation.as_dquat().normalize()),
            _ => JointPosition::Fixed,
        })
        .collect()
}

/// Returns the largest turn of every joint from rest, rad.
fn most_turned_rad(spatial: &SpatialRig, moments: &[Moment<'_>]) -> Vec<f64> {
    let mut most_rad = vec![0.0; spatial.tree().bodies().len()];
    for moment in moments {
        for (most_rad, position) in most_rad.iter_mut().zip(positions(spatial, moment.pose())) {
            if let JointPosition::Turn(turn) = position {
                *most_rad = f64::max(*most_rad, turn.angle_between(DQuat::IDENTITY));
            }
        }
    }
    most_rad
}
