//! The motions that are evaluated, each with the rig that performs it.

use sinew_figure::plant::Pose;
use sinew_figure::{FigureMotion, Root};
use sinew_rig::Mechanism;

use super::error::RunError;
use super::rig::Rig;
use super::setup::Setup;

/// A motion, evenly sampled, and the rig that performs it in a setup.
///
/// Its dimensions may be others than the rig's: it is what the errors are measured against.
pub trait EvaluatedMotion: Sync {
    /// What people call it.
    fn name(&self) -> &str;

    /// What people call the rig; `None` for the paper's figure.
    fn rig_name(&self) -> Option<&str> {
        None
    }

    /// Visits all numbers that the motion and its rig are made of, by which it is known again.
    fn visit_numbers(&self, see: &mut dyn FnMut(&[f64]));

    /// Time from one frame to the next, s.
    fn dt_s(&self) -> f64;

    /// Number of frames.
    fn frame_count(&self) -> usize;

    /// The rig, as its controller knows it.
    ///
    /// # Errors
    /// [`RunError`] if there is none for this motion.
    fn mechanism(&self, setup: &Setup) -> Result<Mechanism, RunError>;

    /// Makes the rig in a setup. Of a user's rig on a stand the base is not judged.
    ///
    /// # Errors
    /// [`RunError`] if there is none, its measures do not survive f32, or it has no surface.
    fn rig(&self, setup: &Setup) -> Result<Rig, RunError> {
        let rig = Rig::new(self.mechanism(setup)?)?;
        Ok(if self.rig_name().is_some() { rig.without_stand() } else { rig })
    }

    /// Puts the poses of all joints in a frame (the last one, beyond the end) into `out`, each in its parent's frame,
    /// the root's in the world; by body of the rig.
    fn joint_poses(&self, setup: &Setup, frame: usize, out: &mut Vec<Pose>);

    /// Shows the angles in deg between the limbs of the rig, its bodies at these poses in the world, and the limbs of
    /// the performer in a frame. None, if the motion is no performer's.
    fn limb_errors_deg(&self, _frame: usize, _poses: &[Pose], _see: &mut dyn FnMut(f64)) {}
}

/// Visits all numbers that a rig is made of.
pub fn visit_numbers(mechanism: &Mechanism, see: &mut dyn FnMut(&[f64])) {
    for link in &mechanism.bodies {
        see(&[link.parent.map_or(-1.0, |parent| parent as f64)]);
        see(&link.position_m.to_array());
        see(&link.rotation.to_array());
        see(&[link.mass_kg, link.rotor_inertia, link.friction, link.damping, link.effort]);
        see(&link.center_of_mass_m.to_array());
        see(&link.inertia_kg_m2.to_cols_array());
        let (turns, slides) = link.joint.axes(&link.home);
        see(&[turns.len() as f64, slides.len() as f64]);
        for axis in turns.iter().chain(&slides) {
            see(&axis.to_array());
        }
        link.ranges.iter().for_each(|range| see(range));
        see(&link.home);
    }
}

/// A clip on the figure, which is made from it: the setup says with which body model, and how its pelvis is held.
impl EvaluatedMotion for FigureMotion {
    fn name(&self) -> &str {
        &self.name
    }

    fn visit_numbers(&self, see: &mut dyn FnMut(&[f64])) {
        let vectors = self.offset_m.iter().chain(&self.segment_end_m).chain(&self.root_position_m);
        for vector in vectors {
            see(&vector.to_array());
        }
        for rotation in self.rotation.iter().flatten() {
            see(&rotation.to_array());
        }
    }

    fn dt_s(&self) -> f64 {
        self.dt_s
    }

    fn frame_count(&self) -> usize {
        self.rotation.len()
    }

    fn mechanism(&self, setup: &Setup) -> Result<Mechanism, RunError> {
        Ok(setup.model(self)?.mechanism(setup.root))
    }

    fn joint_poses(&self, setup: &Setup, frame: usize, out: &mut Vec<Pose>) {
        let frame = frame.min(self.rotation.len() - 1);
        let joints = self.rotation[frame].iter().zip(&self.offset_m);
        out.clear();
        out.extend(
            joints.map(|(rotation, offset_m)| Pose { rotation: *rotation, position_m: *offset_m }),
        );
        let held = if setup.root == Root::Fixed { 0 } else { frame };
        out[0] = Pose { rotation: self.rotation[held][0], position_m: self.root_position_m[held] };
    }
}

/// Motions of different kinds, side by side.
impl<T: EvaluatedMotion + ?Sized> EvaluatedMotion for Box<T> {
    fn name(&self) -> &str {
        self.as_ref().name()
    }

    fn rig_name(&self) -> Option<&str> {
        self.as_ref().rig_name()
    }

    fn visit_numbers(&self, see: &mut dyn FnMut(&[f64])) {
        self.as_ref().visit_numbers(see);
    }

    fn dt_s(&self) -> f64 {
        self.as_ref().dt_s()
    }

    fn frame_count(&self) -> usize {
        self.as_ref().frame_count()
    }

    fn mechanism(&self, setup: &Setup) -> Result<Mechanism, RunError> {
        self.as_ref().mechanism(setup)
    }

    fn joint_poses(&self, setup: &Setup, frame: usize, out: &mut Vec<Pose>) {
        self.as_ref().joint_poses(setup, frame, out);
    }

    fn limb_errors_deg(&self, frame: usize, poses: &[Pose], see: &mut dyn FnMut(f64)) {
        self.as_ref().limb_errors_deg(frame, poses, see);
    }
}

/// Returns the number of steps of a run: from frame 0, where the rig starts without error, to the last frame but one. A
/// step needs the desired motion of three frames (forward differences of second order), so it starts from the last but
/// two at the latest.
pub fn count_steps(motion: &dyn EvaluatedMotion, seconds: Option<f64>) -> usize {
    count_frames(motion, seconds).saturating_sub(2)
}

/// Returns the number of frames of a run, at least those of one step if the motion has them.
pub(super) fn count_frames(motion: &dyn EvaluatedMotion, seconds: Option<f64>) -> usize {
    let frames = motion.frame_count();
    match seconds {
        Some(seconds) => {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not negative, and saturates"
            )]
            let within = (seconds / motion.dt_s()).round() as usize;
            frames.min(within.max(3))
        }
        None => frames,
    }
}
