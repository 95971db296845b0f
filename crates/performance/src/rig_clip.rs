//! A clip that was retargeted to a rig, for the evaluation.

use std::sync::Arc;

use sinew_evaluation::{EvaluatedMotion, RunError, Setup};
use sinew_figure::plant::Pose;
use sinew_retarget::feasibility::{Curve, Fit, MotionError, RigMotion};
use sinew_rig::Mechanism;

use super::retargeted_clip::RetargetedClip;

/// A clip that was retargeted to a rig, at the control rate.
#[derive(Debug, Clone)]
pub struct RigClip {
    name: String,
    rig: String,
    mechanism: Arc<Mechanism>,
    motion: RigMotion,
    taken: Arc<RetargetedClip>,
    /// Time in the clip of every frame, s.
    clip_s: Vec<f64>,
}

impl RigClip {
    /// Resamples a clip on a rig, or its fit, to `rate_hz`.
    ///
    /// # Errors
    /// [`MotionError`] if it is not a motion of the rig.
    pub fn new(
        [name, rig]: [&str; 2],
        mechanism: &Arc<Mechanism>,
        taken: &Arc<RetargetedClip>,
        fit: Option<&Fit>,
        rate_hz: f64,
    ) -> Result<Self, MotionError> {
        let motion = fit.map_or(&taken.motion, |fit| &fit.motion);
        let motion = Curve::new(mechanism, motion)?.resampled(rate_hz);
        let clip_s = |frame: usize| {
            let time_s = frame as f64 * motion.dt_s;
            fit.map_or(time_s, |fit| fit.given_time_s(time_s))
        };
        Ok(Self {
            name: name.to_owned(),
            rig: rig.to_owned(),
            mechanism: Arc::clone(mechanism),
            taken: Arc::clone(taken),
            clip_s: (0..motion.rows.len()).map(clip_s).collect(),
            motion,
        })
    }
}

impl EvaluatedMotion for RigClip {
    fn name(&self) -> &str {
        &self.name
    }

    fn rig_name(&self) -> Option<&str> {
        Some(&self.rig)
    }

    fn visit_numbers(&self, see: &mut dyn FnMut(&[f64])) {
        sinew_evaluation::visit_numbers(&self.mechanism, see);
        for row in &self.motion.rows {
            see(row);
        }
    }

    fn dt_s(&self) -> f64 {
        self.motion.dt_s
    }

    fn frame_count(&self) -> usize {
        self.motion.rows.len()
    }

    fn mechanism(&self, _: &Setup) -> Result<Mechanism, RunError> {
        Ok(self.mechanism.as_ref().clone())
    }

    fn joint_poses(&self, _: &Setup, frame: usize, out: &mut Vec<Pose>) {
        let last = self.motion.rows.len() - 1;
        let q = &self.motion.rows[frame.min(last)];
        out.clear();
        out.extend(self.mechanism.joint_poses(q));
    }

    fn limb_errors_deg(&self, frame: usize, poses: &[Pose], see: &mut dyn FnMut(f64)) {
        if let Some(clip_s) = self.clip_s.get(frame) {
            self.taken.limb_errors_deg(*clip_s, poses).for_each(see);
        }
    }
}
