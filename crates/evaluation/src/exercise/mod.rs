//! Built-in motions of a rig's own joints: each joint in turn, then all together.
//!
//! An axis moves from position to position by minimum jerk (Flash and Hogan 1985), and rests at each position. Its
//! motion is smooth up to the acceleration, within its range, and at a stated share of its maximum speed and
//! acceleration. A ball joint moves along the three components of its rotation vector. Free roots and other free bodies
//! stay at home.

mod axis;
mod error;
mod linked;
mod profile;
mod settings;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::{DQuat, DVec3};
use sinew_figure::plant::check_link;
use sinew_rig::mechanism::{JointModel, Link, Mechanism, Pose};

use super::error::RunError;
use super::motion::{EvaluatedMotion, visit_numbers};
use super::setup::Setup;
use axis::Axis;
use linked::{follow, tie};
use profile::{Profile, plan_in_turn, plan_together};

pub use error::ExerciseError;
pub use settings::ExerciseSettings;

/// A motion of a rig's own joints.
#[derive(Debug, Clone)]
pub struct Exercise {
    name: String,
    rig: String,
    mechanism: Arc<Mechanism>,
    dt_s: f64,
    frames: usize,
    /// Profiles of every joint, one per axis.
    profiles: Vec<Vec<Profile>>,
}

/// Makes the motions of a rig: for each share a motion of all joints together and, with `settings.in_turn`, before it a
/// motion of one joint after the other.
///
/// # Errors
/// [`ExerciseError`] if a setting or the rig is invalid, or nothing moves.
pub fn make_exercises(
    name: &str,
    mechanism: &Mechanism,
    settings: &ExerciseSettings,
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
        let in_turn = settings.in_turn.then(|| ("in_turn", plan_in_turn(&axes, *share)));
        let together = Some(("together", plan_together(&axes, *share, settings)));
        for (kind, mut profiles) in in_turn.into_iter().chain(together) {
            follow(&followers, &mut profiles);
            let ends = profiles.iter().flatten().map(Profile::end_s);
            let last_s = ends.fold(0.0, f64::max);
            // The motion of all joints together stops abruptly, wherever the axes are.
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
                profiles,
            });
        }
    }
    Ok(exercises)
}

impl EvaluatedMotion for Exercise {
    fn name(&self) -> &str {
        &self.name
    }

    fn rig_name(&self) -> Option<&str> {
        Some(&self.rig)
    }

    fn visit_numbers(&self, see: &mut dyn FnMut(&[f64])) {
        visit_numbers(&self.mechanism, see);
        for profile in self.profiles.iter().flatten() {
            for one in &profile.moves {
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
        out.extend(self.mechanism.bodies.iter().zip(&self.profiles).map(|(link, profiles)| {
            let mut along = [0.0; 3];
            for (along, profile) in along.iter_mut().zip(profiles) {
                *along = profile.at(time_s);
            }
            let in_joint = in_joint(link, along);
            let placement = Pose { rotation: link.rotation, position_m: link.position_m };
            placement.child(in_joint.position_m, in_joint.rotation)
        }));
    }
}

/// Returns the pose of a body in its joint frame, from coordinates along its axes.
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
