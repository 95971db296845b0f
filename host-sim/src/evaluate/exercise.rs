//! Built-in motions of a rig's own joints: each in turn, then all together.
//!
//! An axis goes from place to place by minimum jerk (Flash and Hogan 1985), at rest in each: smooth up to its
//! acceleration, within its range, and at a stated share of what it can. A ball joint goes along the three components of
//! its rotation vector. A root that is free, and other free bodies, stay where they are at home.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};
use std::sync::Arc;

use glam::{DQuat, DVec3};
use sinew_rig::mechanism::{Freedom, Link, Mechanism, Pose};
use thiserror::Error;

use super::error::RunError;
use super::setup::Setup;
use super::take::Take;
use crate::plant::{PlantError, check_link};
use crate::random::{Random, Subject};

/// Which motions there are.
#[derive(Debug, Clone, PartialEq)]
pub struct Exercises {
    /// Frames a second, which is the rate of control too.
    pub rate_hz: f64,
    /// Shares of the largest speed and acceleration of every axis that it goes at, above 0 and at most 1: two motions
    /// for each.
    pub shares: Vec<f64>,
    /// How long all joints move together, s.
    pub seconds: f64,
    /// Seed of where they go then.
    pub seed: u64,
}

impl Default for Exercises {
    fn default() -> Self {
        Self { rate_hz: 500.0, shares: vec![0.2, 0.6], seconds: 10.0, seed: 1 }
    }
}

/// Why a rig has no such motions.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ExerciseError {
    /// A setting that cannot be.
    #[error("{key}: expected {expected}, found {found}")]
    Setting {
        /// Its name.
        key: &'static str,
        /// What it may be.
        expected: &'static str,
        /// What it is.
        found: f64,
    },
    /// A number of the rig that no machine has.
    #[error(transparent)]
    Rig(#[from] PlantError),
    /// A joint has another number of coordinates than its home.
    #[error("joint {joint}: expected {expected} finite coordinates of its home, found {found:?}")]
    Home {
        /// The joint.
        joint: String,
        /// How many there must be.
        expected: usize,
        /// What there are.
        found: Vec<f64>,
    },
    /// There is nothing to move.
    #[error(
        "the rig has no joint that moves; expected a hinge, a slide, a universal or a ball joint"
    )]
    NothingMoves,
}

/// A motion of a rig's own joints.
#[derive(Debug, Clone)]
pub struct Exercise {
    name: String,
    rig: String,
    mechanism: Arc<Mechanism>,
    dt_s: f64,
    frames: usize,
    /// Of every joint, as many as it has axes.
    courses: Vec<Vec<Course>>,
}

/// Slower than any servo: the speed of an axis that has no limit, rad/s and m/s.
const SPEED: [f64; 2] = [2.0, 0.5];
/// The acceleration of an axis that has no limit, rad/s² and m/s².
const ACCELERATION: [f64; 2] = [20.0, 5.0];
/// How far an axis without range goes to both sides of its home, rad and m.
const REACH: [f64; 2] = [FRAC_PI_2, 0.1];
/// How far a ball joint without range goes, rad.
const BALL_RAD: f64 = FRAC_PI_3;
/// Share of a range that is kept free at both ends.
const MARGIN: f64 = 0.05;

/// The motions of a rig: for each share one with all joints in turn, and one with all together.
///
/// # Errors
/// [`ExerciseError`] if a setting or the rig cannot be, or nothing of it moves.
pub fn exercises(
    name: &str,
    mechanism: &Mechanism,
    settings: &Exercises,
) -> Result<Vec<Exercise>, ExerciseError> {
    settings.check()?;
    let mut axes = Vec::with_capacity(mechanism.bodies.len());
    for (body, link) in mechanism.bodies.iter().enumerate() {
        check_link(body, link)?;
        axes.push(Axis::of_joint(link)?);
    }
    if axes.iter().all(Vec::is_empty) {
        return Err(ExerciseError::NothingMoves);
    }
    let mechanism = Arc::new(mechanism.clone());
    let mut exercises = Vec::with_capacity(2 * settings.shares.len());
    for share in &settings.shares {
        let together = together(&axes, *share, settings);
        for (kind, courses) in [("in_turn", in_turn(&axes, *share)), ("together", together)] {
            let ends = courses.iter().flatten().map(Course::end_s);
            let last = ends.fold(0.0, f64::max) * settings.rate_hz;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative, and saturates"
            )]
            let frames = last.ceil() as usize + 3;
            exercises.push(Exercise {
                name: format!("{kind}_{:.0}", share * 100.0),
                rig: name.to_owned(),
                mechanism: Arc::clone(&mechanism),
                dt_s: settings.rate_hz.recip(),
                frames,
                courses,
            });
        }
    }
    Ok(exercises)
}

impl Exercises {
    fn check(&self) -> Result<(), ExerciseError> {
        let fault = |key, expected, found| Err(ExerciseError::Setting { key, expected, found });
        if !(1.0..=10_000.0).contains(&self.rate_hz) {
            return fault("rate_hz", "1 to 10000 Hz", self.rate_hz);
        }
        if !(1.0..=3600.0).contains(&self.seconds) {
            return fault("seconds", "1 to 3600 s", self.seconds);
        }
        match self.shares.iter().find(|share| !(0.01..=1.0).contains(*share)) {
            Some(share) => fault("shares", "shares from 0.01 to 1", *share),
            None => Ok(()),
        }
    }
}

impl Take for Exercise {
    fn name(&self) -> &str {
        &self.name
    }

    fn rig_name(&self) -> Option<&str> {
        Some(&self.rig)
    }

    fn dt_s(&self) -> f64 {
        self.dt_s
    }

    fn frame_count(&self) -> usize {
        self.frames
    }

    fn mechanism(&self, _: &Setup) -> Result<Mechanism, RunError> {
        Ok(self.mechanism.as_ref().clone())
    }

    fn joint_poses(&self, _: &Setup, frame: usize, out: &mut Vec<Pose>) {
        let time_s = frame.min(self.frames - 1) as f64 * self.dt_s;
        out.clear();
        out.extend(self.mechanism.bodies.iter().zip(&self.courses).map(|(link, courses)| {
            let mut along = [0.0; 3];
            for (along, course) in along.iter_mut().zip(courses) {
                *along = course.at(time_s);
            }
            let in_joint = in_joint(link, along);
            let placement = Pose { rotation: link.rotation, position_m: link.position_m };
            placement.child(in_joint.position_m, in_joint.rotation)
        }));
    }
}

/// Pose of a body in its joint frame at coordinates along its axes.
fn in_joint(link: &Link, along: [f64; 3]) -> Pose {
    match link.joint {
        Freedom::Spherical => {
            let rotation = DQuat::from_scaled_axis(DVec3::from_array(along));
            Pose { rotation, ..Pose::IDENTITY }
        }
        Freedom::Free => link.joint.motion(&link.home),
        _ => link.joint.motion(&along),
    }
}

/// An axis of a joint: where it may go, and how fast.
#[derive(Debug, Clone, Copy)]
struct Axis {
    home: f64,
    least: f64,
    most: f64,
    speed: f64,
    acceleration: f64,
}

impl Axis {
    /// The axes of a joint.
    fn of_joint(link: &Link) -> Result<Vec<Self>, ExerciseError> {
        let expected = link.joint.kind().coordinate_count();
        if link.home.len() != expected || !link.home.iter().all(|at| at.is_finite()) {
            let (joint, found) = (link.joint_name.clone(), link.home.clone());
            return Err(ExerciseError::Home { joint, expected, found });
        }
        let slides = usize::from(matches!(link.joint, Freedom::Prismatic(_)));
        let limit = |limit: f64, without: f64| if limit.is_finite() { limit } else { without };
        let axis = |home: f64, range: [f64; 2]| {
            let [least, most] = range;
            let margin = MARGIN * (most - least);
            Self {
                home: home.clamp(least, most),
                least: least + margin,
                most: most - margin,
                speed: limit(link.speed, SPEED[slides]),
                acceleration: limit(link.acceleration, ACCELERATION[slides]),
            }
        };
        Ok(match link.joint {
            Freedom::Fixed | Freedom::Free => Vec::new(),
            Freedom::Spherical => {
                let most = link.ranges.first().map_or(BALL_RAD, |range| range[1].min(BALL_RAD));
                // The corners of the cube that they go through are within the range; so is their speed together.
                let most = most / f64::sqrt(3.0);
                let &[x, y, z, w] = link.home.as_slice() else { return Ok(Vec::new()) };
                let q = DQuat::from_xyzw(x, y, z, w).normalize();
                let home = if q.w < 0.0 { -q } else { q }.to_scaled_axis().to_array();
                let shared = |axis: Self| Self {
                    speed: axis.speed / f64::sqrt(3.0),
                    acceleration: axis.acceleration / f64::sqrt(3.0),
                    ..axis
                };
                home.map(|home| shared(axis(home, [-most, most]))).to_vec()
            }
            _ => {
                let reach = REACH[slides];
                let range = |index: usize, home: f64| {
                    let [least, most] = link
                        .ranges
                        .get(index)
                        .copied()
                        .unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
                    // Where there is no limit, as far as from home.
                    let least = if least.is_finite() { least } else { home.min(most) - reach };
                    let most = if most.is_finite() { most } else { home.max(least) + reach };
                    [least, most]
                };
                let homes = link.home.iter().enumerate();
                homes.map(|(index, home)| axis(*home, range(index, *home))).collect()
            }
        })
    }

    /// Time from one place to another at a share of what the axis can, s.
    fn duration_s(&self, way: f64, share: f64) -> f64 {
        // The largest speed and acceleration of minimum jerk over a way of 1 in 1 s.
        const SPEED: f64 = 1.875;
        // 10 / √3.
        const ACCELERATION: f64 = 5.773_502_691_896_258;
        let way = way.abs();
        (SPEED * way / (share * self.speed))
            .max(f64::sqrt(ACCELERATION * way / (share * self.acceleration)))
    }
}

/// The places that an axis goes through.
#[derive(Debug, Clone)]
struct Course {
    home: f64,
    /// In the order of time: when each begins and how long it takes, in s, and where it leads.
    moves: Vec<Move>,
}

#[derive(Debug, Clone, Copy)]
struct Move {
    from_s: f64,
    duration_s: f64,
    to: f64,
}

impl Course {
    fn end_s(&self) -> f64 {
        self.moves.last().map_or(0.0, |last| last.from_s + last.duration_s)
    }

    /// Goes on to a place, from a time on.
    fn go(&mut self, axis: &Axis, from_s: f64, to: f64, share: f64) {
        let from = self.moves.last().map_or(self.home, |last| last.to);
        self.moves.push(Move { from_s, duration_s: axis.duration_s(to - from, share), to });
    }

    /// Where it is at a time.
    fn at(&self, time_s: f64) -> f64 {
        let begun = self.moves.partition_point(|one| one.from_s <= time_s);
        let Some(last) = begun.checked_sub(1) else { return self.home };
        let from = last.checked_sub(1).map_or(self.home, |before| self.moves[before].to);
        let Move { from_s, duration_s, to } = self.moves[last];
        if time_s - from_s >= duration_s {
            return to;
        }
        let t = (time_s - from_s) / duration_s;
        from + (to - from) * t * t * t * (10.0 + t * (6.0 * t - 15.0))
    }
}

/// Every axis goes to one end, to the other, and home, one after the other.
fn in_turn(axes: &[Vec<Axis>], share: f64) -> Vec<Vec<Course>> {
    let mut now_s = 0.0;
    let mut course = |axis: &Axis| {
        let mut course = Course { home: axis.home, moves: Vec::new() };
        for to in [axis.least, axis.most, axis.home] {
            course.go(axis, now_s, to, share);
            now_s = course.end_s();
        }
        course
    };
    axes.iter().map(|axes| axes.iter().map(&mut course).collect()).collect()
}

/// Every axis goes anywhere in its range and on, each in its own time.
fn together(axes: &[Vec<Axis>], share: f64, settings: &Exercises) -> Vec<Vec<Course>> {
    let mut number = 0;
    let mut course = |axis: &Axis| {
        let mut random = Random::numbered(settings.seed, number, Subject::Exercise);
        number += 1;
        let mut course = Course { home: axis.home, moves: Vec::new() };
        // A rig whose range is a point stays there.
        while course.end_s() < settings.seconds && axis.most > axis.least {
            let from_s = course.end_s();
            course.go(axis, from_s, random.between(axis.least, axis.most), share);
        }
        course
    };
    axes.iter().map(|axes| axes.iter().map(&mut course).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::{Errors, Evaluation, MethodName, Protocol, evaluate, report};
    use crate::figure::MassProperties;
    use crate::plant::{PlantKind, link};

    /// An arm: turntable, shoulder, elbow, a slide, a wrist of two axes and a ball joint, standing on `base`.
    fn arm(base: DQuat) -> Mechanism {
        let mass = |mass_kg: f64, length_m: f64| MassProperties {
            mass_kg,
            center_of_mass_m: DVec3::Y * (0.5 * length_m),
            rotational_kg_m2: glam::DMat3::from_diagonal(
                DVec3::new(1.0, 0.3, 1.0) * (mass_kg * length_m * length_m / 12.0),
            ),
        };
        let joints = [
            (Freedom::Fixed, 1.0, 0.1),
            (Freedom::Revolute(DVec3::Y), 0.5, 0.1),
            (Freedom::Revolute(DVec3::X), 0.4, 0.2),
            (Freedom::Revolute(DVec3::X), 0.3, 0.2),
            (Freedom::Prismatic(DVec3::Y), 0.2, 0.1),
            (Freedom::Universal([DVec3::X, DVec3::Z]), 0.1, 0.08),
            (Freedom::Spherical, 0.1, 0.08),
        ];
        let mut bodies: Vec<Link> = Vec::new();
        for (index, (joint, mass_kg, length_m)) in joints.into_iter().enumerate() {
            let parent = index.checked_sub(1);
            let up = bodies.last().map_or(0.0, |below| 2.0 * below.center_of_mass_m.y);
            let mut body = link(parent, joint, DVec3::Y * up, &mass(mass_kg, length_m));
            body.joint_name = format!("joint_{index}");
            body.name = format!("body_{index}");
            if parent.is_none() {
                body.rotation = base;
            } else {
                // A little aside, as joints are.
                body.rotation = DQuat::from_rotation_z(0.2);
            }
            match joint {
                Freedom::Revolute(_) => {
                    body.ranges = vec![[-1.5, 1.0]];
                    (body.speed, body.acceleration) = (6.0, 60.0);
                }
                Freedom::Prismatic(_) => {
                    body.ranges = vec![[0.0, 0.05]];
                    (body.speed, body.acceleration) = (0.2, 3.0);
                }
                Freedom::Universal(_) => body.ranges = vec![[-0.5, 0.5], [-0.3, 0.7]],
                _ => {}
            }
            bodies.push(body);
        }
        Mechanism { bodies }
    }

    fn evaluated(mechanism: &Mechanism, change: impl FnOnce(&mut Protocol)) -> Evaluation {
        let settings = Exercises { seconds: 2.0, ..Exercises::default() };
        let takes = exercises("arm", mechanism, &settings).unwrap();
        let mut protocol = Protocol { scales: vec![1.0], ..Protocol::default() };
        protocol.setup.plant.kind = PlantKind::Articulated;
        change(&mut protocol);
        evaluate(&takes, &protocol, |_| ()).unwrap()
    }

    fn totals(evaluation: &Evaluation) -> impl Iterator<Item = (MethodName, &Errors)> {
        let methods = evaluation.figures.iter().flat_map(|figure| &figure.methods);
        methods.map(|result| (result.method, &result.total))
    }

    #[test]
    fn a_true_model_is_followed_by_every_method_however_it_stands() {
        let quarter = DQuat::from_rotation_z(FRAC_PI_2);
        for base in [DQuat::IDENTITY, quarter, quarter * quarter] {
            let methods = MethodName::ALL.into_iter().filter(|one| *one != MethodName::Accumulated);
            let evaluation = evaluated(&arm(base), |protocol| protocol.methods = methods.collect());
            for (method, errors) in totals(&evaluation) {
                assert!(errors.all.n > 10_000);
                // What the issue asks of rigs.
                let mean_deg = errors.all.angular_mean_deg();
                assert!(mean_deg < 0.1 && mean_deg > 0.0, "{method}: {mean_deg}");
                assert!(errors.all.linear_mean_cm() < 0.05, "{method}");
            }
        }
    }

    #[test]
    fn wrong_masses_are_learnt() {
        let evaluation = evaluated(&arm(DQuat::IDENTITY), |protocol| {
            protocol.methods = vec![MethodName::Recommended];
            protocol.setup.disturbance.masses = 0.15;
        });
        let (_, errors) = totals(&evaluation).next().unwrap();
        assert!(errors.all.angular_mean_deg() < 0.1, "{}", errors.all.angular_mean_deg());
    }

    #[test]
    fn axes_stay_in_their_ranges_and_below_their_limits_and_are_smooth() {
        let mechanism = arm(DQuat::IDENTITY);
        for exercise in exercises("arm", &mechanism, &Exercises::default()).unwrap() {
            let share = if exercise.name.ends_with("20") { 0.2 } else { 0.6 };
            for (link, courses) in mechanism.bodies.iter().zip(&exercise.courses) {
                for (index, course) in courses.iter().enumerate() {
                    let h = exercise.dt_s;
                    let at: Vec<f64> =
                        (0..exercise.frames).map(|f| course.at(f as f64 * h)).collect();
                    if let Some([least, most]) = link.ranges.get(index) {
                        assert!(at.iter().all(|at| (*least..=*most).contains(at)), "{}", link.name);
                    }
                    assert!(at.iter().any(|there| *there != at[0]), "{}: it moves", link.name);
                    let limit =
                        |limit: f64, without: f64| if limit.is_finite() { limit } else { without };
                    let speed = share * limit(link.speed, SPEED[0]);
                    let acceleration = share * limit(link.acceleration, ACCELERATION[0]);
                    let mut before = 0.0;
                    for three in at.windows(3) {
                        assert!((three[1] - three[0]).abs() / h <= speed * (1.0 + 1e-9));
                        let now = (three[0] - 2.0 * three[1] + three[2]) / (h * h);
                        // Differences of numbers near 1 over h².
                        assert!(now.abs() <= acceleration + 1e-9 / h, "{}: {now}", link.name);
                        // The largest jerk is at the ends, 60 ways in T³: with T from above, 60 / 5.77^1.5 times
                        // a^1.5 / way^0.5, here of ways of a degree or more; a step of acceleration is none of time.
                        assert!(
                            (now - before).abs() < 0.5 * acceleration,
                            "{}: {before} {now}",
                            link.name
                        );
                        before = now;
                    }
                }
            }
        }
    }

    #[test]
    fn the_same_seed_moves_the_same_way() {
        let mechanism = arm(DQuat::IDENTITY);
        let poses = |seed| {
            let settings = Exercises { seed, ..Exercises::default() };
            let together = exercises("arm", &mechanism, &settings).unwrap().swap_remove(1);
            assert_eq!(together.name(), "together_20");
            let mut poses = Vec::new();
            together.joint_poses(&Setup::default(), 1000, &mut poses);
            poses
        };
        assert_eq!(poses(1), poses(1));
        assert_ne!(poses(1), poses(2));
    }

    #[test]
    fn tables_are_of_the_rig_and_not_beside_the_papers() {
        let evaluation = evaluated(&arm(DQuat::IDENTITY), |_| ());
        let text = report::tables(&evaluation);
        assert!(text.contains("Rig arm: errors divided by Local's"), "{text}");
        assert!(!text.contains("paper") && !text.contains("Table 1"), "{text}");
    }

    #[test]
    fn what_cannot_be_moved_is_refused_in_words() {
        let refused = |mechanism: &Mechanism, settings: &Exercises| {
            exercises("arm", mechanism, settings).unwrap_err().to_string()
        };
        let good = arm(DQuat::IDENTITY);
        for shares in [vec![0.0], vec![0.2, 1.5], vec![f64::NAN]] {
            let message = refused(&good, &Exercises { shares, ..Exercises::default() });
            assert!(message.starts_with("shares: expected shares from 0.01 to 1"), "{message}");
        }
        let message = refused(&good, &Exercises { rate_hz: f64::INFINITY, ..Exercises::default() });
        assert!(message.starts_with("rate_hz"), "{message}");
        let mut bad = good.clone();
        bad.bodies[1].ranges = vec![[0.5, f64::NAN]];
        assert!(refused(&bad, &Exercises::default()).starts_with("body 1, ranges"));
        let mut bad = good.clone();
        bad.bodies[2].home = vec![];
        assert!(refused(&bad, &Exercises::default()).starts_with("joint joint_2: expected 1"));
        let stiff = Mechanism { bodies: vec![good.bodies[0].clone()] };
        assert!(refused(&stiff, &Exercises::default()).contains("no joint that moves"));
    }
}
