//! Effort that gravity demands of each joint, in the worst pose.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::{DQuat, DVec3};

use crate::mechanism::{GRAVITY_M_S2, JointModel, Mechanism};

/// Number of starts of the search: the home pose, and poses spread over the ranges.
const STARTS: u32 = 9;

/// Maximum number of sweeps over all joints from one start. Each sweep optimizes one coordinate after the other.
const SWEEPS: usize = 12;

/// Number of rotations of a ball joint that are tried about one axis.
const TURNS: u32 = 24;

/// Maximum effort that gravity demands of one dof.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstLoad {
    /// Effort of the drive that holds the pose, N m or N; absolute value.
    pub effort: f64,
    /// Joint coordinates of the pose, ordered as [`Mechanism::home`].
    pub q: Vec<f64>,
}

/// Returns the effort of dof `axis` of joint `joint` that holds the pose `q` against gravity: N m, or N for a
/// slide. O(n).
pub fn holding_effort(mechanism: &Mechanism, q: &[f64], joint: usize, axis: usize) -> f64 {
    let poses = mechanism.poses(q);
    let range = mechanism.coordinate_ranges().into_iter().nth(joint).unwrap_or_default();
    let (Some(link), Some(pose)) = (mechanism.bodies.get(joint), poses.get(joint)) else {
        return 0.0;
    };
    let (turns, slides) = link.joint.axes(q.get(range).unwrap_or_default());
    let weights =
        mechanism.bodies.iter().zip(&poses).enumerate().filter_map(|(body, (link, at))| {
            let moved = mechanism.supports(joint, body);
            moved.then(|| (at.point(link.center_of_mass_m), link.mass_kg * GRAVITY_M_S2))
        });
    if let Some(turn) = turns.get(axis) {
        let moment: DVec3 =
            weights.map(|(center_m, weight_n)| (center_m - pose.position_m).cross(weight_n)).sum();
        -(pose.rotation * *turn).dot(moment)
    } else if let Some(slide) = slides.get(axis.saturating_sub(turns.len())) {
        let force: DVec3 = weights.map(|(_, weight_n)| weight_n).sum();
        -(pose.rotation * *slide).dot(force)
    } else {
        0.0
    }
}

/// Finds the worst pose for one dof, within the ranges of all joints.
///
/// The search optimizes one coordinate after the other. This is exact for each coordinate, because the effort is a
/// sine of every angle and linear in every translation. It uses several starts, so that the result is at most
/// slightly below the true maximum, and never above it. Ranges that join two joints are ignored.
pub fn worst_load(mechanism: &Mechanism, joint: usize, axis: usize) -> WorstLoad {
    let mut search = Search {
        mechanism,
        joint,
        axis,
        ranges: mechanism.coordinate_ranges(),
        q: mechanism.home(),
        effort: 0.0,
    };
    search.effort = search.effort_of(&search.q);
    let mut worst = WorstLoad { effort: search.effort, q: search.q.clone() };
    for start in 0..STARTS {
        search.q = if start == 0 { mechanism.home() } else { spread(mechanism, start) };
        search.effort = search.effort_of(&search.q);
        search.climb();
        if search.effort > worst.effort {
            worst = WorstLoad { effort: search.effort, q: search.q.clone() };
        }
    }
    worst
}

struct Search<'a> {
    mechanism: &'a Mechanism,
    joint: usize,
    axis: usize,
    ranges: Vec<Range<usize>>,
    q: Vec<f64>,
    effort: f64,
}

impl Search<'_> {
    fn effort_of(&self, q: &[f64]) -> f64 {
        holding_effort(self.mechanism, q, self.joint, self.axis).abs()
    }

    fn climb(&mut self) {
        for _ in 0..SWEEPS {
            let before = self.effort;
            for body in 0..self.mechanism.bodies.len() {
                // Only joints that carry this joint, or that this joint carries, change its load.
                if self.mechanism.supports(body, self.joint)
                    || self.mechanism.supports(self.joint, body)
                {
                    self.improve(body);
                }
            }
            if self.effort <= before * (1.0 + 1e-9) {
                break;
            }
        }
    }

    /// Moves the coordinates of one joint to the maximum effort.
    fn improve(&mut self, body: usize) {
        let mechanism = self.mechanism;
        let (Some(link), Some(range)) =
            (mechanism.bodies.get(body), self.ranges.get(body).cloned())
        else {
            return;
        };
        match link.joint {
            JointModel::Fixed | JointModel::Free => {}
            JointModel::Spherical => self.turn_ball(range, link.ranges.first()),
            JointModel::Revolute(_) | JointModel::Universal(_) => {
                for (place, index) in range.enumerate() {
                    let ends = link.ranges.get(place).copied().unwrap_or([-PI, PI]);
                    for angle in self.angles(index, ends) {
                        self.try_value(index, angle);
                    }
                }
            }
            JointModel::Prismatic(_) => {
                for end in link.ranges.first().copied().into_iter().flatten() {
                    self.try_value(range.start, end);
                }
            }
        }
    }

    /// Returns the ends of a range, and the extremes within it of the effort `a + b cos + c sin`.
    fn angles(&self, index: usize, [least, most]: [f64; 2]) -> Vec<f64> {
        let at = |angle: f64| {
            let mut q = self.q.clone();
            if let Some(slot) = q.get_mut(index) {
                *slot = angle;
            }
            holding_effort(self.mechanism, &q, self.joint, self.axis)
        };
        let third = TAU / 3.0;
        let [zero, plus, minus] = [0.0, third, -third].map(at);
        let cosine = (2.0 * zero - plus - minus) / 3.0;
        let sine = (plus - minus) / 3.0_f64.sqrt();
        let peak = libm::atan2(sine, cosine);
        // Ranges extend over a few turns at most.
        let extremes = (-8..=8).map(|half_turns| peak + PI * f64::from(half_turns));
        let within = extremes.filter(|angle| (least..=most).contains(angle));
        within.chain([least, most]).collect()
    }

    fn turn_ball(&mut self, range: Range<usize>, limit: Option<&[f64; 2]>) {
        let most = limit.map_or(PI, |[_, most]| *most);
        for axis in DVec3::AXES {
            let Some(&[x, y, z, w]) = self.q.get(range.clone()) else { return };
            let now = DQuat::from_xyzw(x, y, z, w);
            for turn in 1..TURNS {
                let angle = TAU * f64::from(turn) / f64::from(TURNS);
                let turned = now * DQuat::from_axis_angle(axis, angle);
                if 2.0 * libm::acos(turned.w.abs().min(1.0)) <= most {
                    let mut q = self.q.clone();
                    q.splice(range.clone(), turned.normalize().to_array());
                    self.try_pose(q);
                }
            }
        }
    }

    fn try_value(&mut self, index: usize, value: f64) {
        let mut q = self.q.clone();
        if let Some(slot) = q.get_mut(index) {
            *slot = value;
        }
        self.try_pose(q);
    }

    fn try_pose(&mut self, q: Vec<f64>) {
        let effort = self.effort_of(&q);
        if effort > self.effort {
            (self.q, self.effort) = (q, effort);
        }
    }
}

/// Returns a pose within the ranges; ball joints stay at home. Poses with different numbers are spread evenly (a
/// Kronecker sequence, which needs no seed and is equal everywhere).
pub(super) fn spread(mechanism: &Mechanism, number: u32) -> Vec<f64> {
    // Fraction of the golden ratio.
    const STEP: f64 = 0.618_033_988_749_894_9;
    let mut place = 0.0;
    let mut q = Vec::new();
    for link in &mechanism.bodies {
        for (axis, home) in link.home.iter().enumerate() {
            place += STEP * f64::from(number);
            let share = place - libm::floor(place);
            q.push(match (link.joint, link.ranges.get(axis)) {
                (
                    JointModel::Revolute(_) | JointModel::Universal(_) | JointModel::Prismatic(_),
                    Some([least, most]),
                ) => least + share * (most - least),
                (JointModel::Revolute(_) | JointModel::Universal(_), None) => TAU * share - PI,
                _ => *home,
            });
        }
    }
    q
}
