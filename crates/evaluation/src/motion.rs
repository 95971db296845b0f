//! Evaluated motions, each with the rig that performs it.

use sinew_figure::plant::Pose;
use sinew_figure::{FigureMotion, Root};
use sinew_rig::Mechanism;

use super::error::RunError;
use super::rig::Rig;
use super::setup::Setup;

/// A motion, evenly sampled, and the rig that performs it in a setup.
///
/// The motion's dimensions may differ from the rig's. Errors are measured relative to the motion.
pub trait EvaluatedMotion: Sync {
    /// Returns the name of the motion.
    fn name(&self) -> &str;

    /// Returns the name of the rig; `None` for the paper's figure.
    fn rig_name(&self) -> Option<&str> {
        None
    }

    /// Visits all numbers of the motion and its rig, for a checksum that identifies them.
    fn visit_numbers(&self, see: &mut dyn FnMut(&[f64]));

    /// Returns the time from one frame to the next, s.
    fn dt_s(&self) -> f64;

    /// Returns the number of frames.
    fn frame_count(&self) -> usize;

    /// Returns the rig as its controller knows it.
    ///
    /// # Errors
    /// [`RunError`] if there is no rig for this motion.
    fn mechanism(&self, setup: &Setup) -> Result<Mechanism, RunError>;

    /// Makes the rig for a setup. If a user's rig is on a stand, the error of its base does not count.
    ///
    /// # Errors
    /// [`RunError`] if there is no rig for this motion, the rig has too many bodies, or a value is not representable in
    /// f32.
    fn rig(&self, setup: &Setup) -> Result<Rig, RunError> {
        let rig = Rig::new(self.mechanism(setup)?)?;
        Ok(if self.rig_name().is_some() { rig.without_stand() } else { rig })
    }

    /// Writes the poses of all joints in a frame to `out`, each in its parent's frame, the root's in the world, in
    /// the order of the rig's bodies. After the end the last frame is used.
    fn joint_poses(&self, setup: &Setup, frame: usize, out: &mut Vec<Pose>);

    /// Calls `see` with the angles in deg between the limbs of the rig, whose bodies have these poses in the
    /// world, and the limbs of the performer in a frame. Does nothing if the motion has no performer.
    fn limb_errors_deg(&self, _frame: usize, _poses: &[Pose], _see: &mut dyn FnMut(f64)) {}
}

/// Visits all numbers of a rig.
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

/// A clip on the figure, which is made from the clip. The setup selects the body model and the support of the
/// pelvis.
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

/// A boxed motion, for lists of motions of different kinds.
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

/// Returns the number of steps of a run. It starts at frame 0, where the rig has no error, and ends at the second frame
/// from the end. A step needs the desired motion of three frames (second-order forward differences), so the last step
/// starts at the third frame from the end.
pub fn count_steps(motion: &dyn EvaluatedMotion, seconds: Option<f64>) -> usize {
    count_frames(motion, seconds).saturating_sub(2)
}

/// Returns the number of frames of a run, at least enough for one step if the motion has them.
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
