//! Built-in motions of a rig's own joints: each in turn, then all together.
//!
//! An axis goes from place to place by minimum jerk (Flash and Hogan 1985), at rest in each: smooth up to its
//! acceleration, within its range, and at a stated share of what it can. A ball joint goes along the three components
//! of its rotation vector. A root that is free, and other free bodies, stay where they are at home.

mod axis;
mod course;
mod linked;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::{DQuat, DVec3};
use sinew_figure::plant::{PlantError, check_link};
use sinew_rig::mechanism::{JointModel, Link, Mechanism, Pose};
use thiserror::Error;

use super::error::RunError;
use super::setup::Setup;
use super::take::{Take, numbers_of};
use axis::Axis;
use course::{Course, in_turn, together};
use linked::{follow, tie};

/// Which motions there are.
#[derive(Debug, Clone, PartialEq)]
pub struct Exercises {
    /// Frames a second, which is the rate of control too.
    pub rate_hz: f64,
    /// Shares of the largest speed and acceleration of every axis that it goes at, above 0 and at most 1: two motions
    /// for each.
    pub shares: Vec<f64>,
    /// Whether the joints go each in turn, too, in a motion of their own.
    pub in_turn: bool,
    /// How long all joints move together, s.
    pub seconds: f64,
    /// Seed of where they go then.
    pub seed: u64,
}

impl Default for Exercises {
    fn default() -> Self {
        Self { rate_hz: 500.0, shares: vec![0.2, 0.6], in_turn: true, seconds: 10.0, seed: 1 }
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
    /// A kinematic rig.
    #[error(
        "no body of the rig has mass, so there is nothing to simulate; expected masses, or `sinew rig view` to see it move"
    )]
    NoMass,
    /// There is nothing to move.
    #[error(
        "the rig has no joint that can move; expected a hinge, a slide, a universal or a ball joint with room in its range and in \
         the limits that join it to others"
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
    let followers = tie(mechanism, &mut axes);
    if !axes.iter().flatten().any(|axis| axis.most > axis.least) {
        return Err(ExerciseError::NothingMoves);
    }
    if mechanism.bodies.iter().all(|link| link.mass_kg == 0.0) {
        return Err(ExerciseError::NoMass);
    }
    let mechanism = Arc::new(mechanism.clone());
    let mut exercises = Vec::with_capacity(2 * settings.shares.len());
    for share in &settings.shares {
        let in_turn = settings.in_turn.then(|| ("in_turn", in_turn(&axes, *share)));
        let together = Some(("together", together(&axes, *share, settings)));
        for (kind, mut courses) in in_turn.into_iter().chain(together) {
            follow(&followers, &mut courses);
            let ends = courses.iter().flatten().map(Course::end_s);
            let last_s = ends.fold(0.0, f64::max);
            // All together they stop at once, wherever they are.
            let last_s = if kind == "together" { last_s.min(settings.seconds) } else { last_s };
            let last = last_s * settings.rate_hz;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative, and saturates"
            )]
            let frames = last.ceil() as usize + 3;
            exercises.push(Exercise {
                name: format!("{kind}_{}", (share * 1e4).round() / 100.0),
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
        let repeated = |(index, share): (usize, &f64)| self.shares[..index].contains(share);
        if let Some(place) = self.shares.iter().enumerate().position(repeated) {
            return fault("shares", "each share once", self.shares[place]);
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

    fn numbers(&self, see: &mut dyn FnMut(&[f64])) {
        numbers_of(&self.mechanism, see);
        for course in self.courses.iter().flatten() {
            for one in &course.moves {
                see(&[one.from_s, one.duration_s, one.to]);
            }
        }
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
        JointModel::Spherical => {
            let rotation = DQuat::from_scaled_axis(DVec3::from_array(along));
            Pose { rotation, ..Pose::IDENTITY }
        }
        JointModel::Free => link.joint.motion(&link.home),
        _ => link.joint.motion(&along),
    }
}
