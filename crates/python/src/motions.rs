//! Motions that an evaluation tracks: clips on the figure or on a rig, or built-in motions of a rig's joints.

use std::path::PathBuf;
use std::sync::Arc;

use crate::work::Progress;
use sinew_evaluation::exercise::{ExerciseSettings, make_exercises};
use sinew_evaluation::{EvaluatedMotion, Rig, RunError, Setup};
use sinew_figure::builtin;
use sinew_figure::mapping::Mapping;
use sinew_figure::pipeline::{self, Settings};
use sinew_figure::plant::Pose;
use sinew_mocap::files::{ClipFile, expand_all};
use sinew_performance::rig::LoadedRig;
use sinew_performance::{
    ClipSettings, MotionChoices, PreparedClip, RigClip, RigPerformance, read_mapping, retarget_clip,
};
use sinew_rig::Mechanism;

/// Motions of any kind.
pub(crate) type Motions = Vec<Box<dyn EvaluatedMotion>>;

/// A motion that ends its evaluation after Python has cancelled the call.
pub(crate) struct Watched {
    motion: Box<dyn EvaluatedMotion>,
    progress: Progress,
}

/// Makes motions end their evaluation if `progress` is cancelled.
pub(crate) fn watched(motions: Motions, progress: &Progress) -> Vec<Watched> {
    let one = |motion| Watched { motion, progress: progress.clone() };
    motions.into_iter().map(one).collect()
}

impl EvaluatedMotion for Watched {
    fn name(&self) -> &str {
        self.motion.name()
    }

    fn rig_name(&self) -> Option<&str> {
        self.motion.rig_name()
    }

    fn visit_numbers(&self, see: &mut dyn FnMut(&[f64])) {
        self.motion.visit_numbers(see);
    }

    fn dt_s(&self) -> f64 {
        self.motion.dt_s()
    }

    fn frame_count(&self) -> usize {
        self.motion.frame_count()
    }

    fn mechanism(&self, setup: &Setup) -> Result<Mechanism, RunError> {
        self.motion.mechanism(setup)
    }

    fn rig(&self, setup: &Setup) -> Result<Rig, RunError> {
        self.motion.rig(setup)
    }

    fn joint_poses(&self, setup: &Setup, frame: usize, out: &mut Vec<Pose>) {
        self.progress.look();
        self.motion.joint_poses(setup, frame, out);
    }

    fn limb_errors_deg(&self, frame: usize, poses: &[Pose], see: &mut dyn FnMut(f64)) {
        self.motion.limb_errors_deg(frame, poses, see);
    }
}

/// Choice of the motions for an evaluation.
#[derive(Debug, Clone)]
pub(crate) struct MotionArgs {
    /// Files and folders of clips. If empty: the built-in clips for the figure, the built-in motions for a rig.
    pub(crate) clips: Vec<PathBuf>,
    /// Rig of the user; `None` for the figure.
    pub(crate) rig: Option<Arc<LoadedRig>>,
    /// Name or file of the mapping.
    pub(crate) mapping: Option<String>,
    /// Rate of control and plant, Hz; `None` for the default of `sinew evaluate`.
    pub(crate) rate_hz: Option<f64>,
    /// Whether the built-in motions of a rig include a motion that moves the joints one after the other.
    pub(crate) in_turn: bool,
}

/// Default rates of `sinew evaluate`, Hz: for the figure, and for a rig.
const RATES_HZ: [f64; 2] = [100.0, 500.0];

impl MotionArgs {
    /// Reads the clips, or creates the built-in motions.
    pub(crate) fn read(&self) -> anyhow::Result<Motions> {
        match &self.rig {
            None => self.of_figure(),
            Some(rig) if self.clips.is_empty() => self.of_joints(rig),
            Some(rig) => self.of_rig(rig),
        }
    }

    fn of_figure(&self) -> anyhow::Result<Motions> {
        let settings = Settings {
            mapping: self
                .mapping
                .as_deref()
                .map(|name| Mapping::named(name.as_ref()))
                .transpose()?,
            rate_hz: self.rate_hz.unwrap_or(RATES_HZ[0]),
            ..Settings::default()
        };
        settings.check()?;
        let prepared = if self.clips.is_empty() {
            let clips = builtin::clips().into_iter();
            clips.map(|clip| pipeline::prepare(clip, &settings)).collect::<Result<Vec<_>, _>>()?
        } else {
            let expanded = expand_all(&self.clips)?;
            let prepare =
                |file: &ClipFile| pipeline::prepare(pipeline::load(file, &settings)?, &settings);
            expanded.take(expanded.clips.iter().map(prepare), false)?.0
        };
        Ok(prepared.into_iter().map(|(motion, _)| Box::new(motion) as _).collect())
    }

    fn of_joints(&self, rig: &LoadedRig) -> anyhow::Result<Motions> {
        let settings = ExerciseSettings {
            rate_hz: self.rate_hz.unwrap_or(RATES_HZ[1]),
            in_turn: self.in_turn,
            ..ExerciseSettings::default()
        };
        let made = make_exercises(&rig.description.name, &rig.mechanism, &settings)?;
        Ok(made.into_iter().map(|exercise| Box::new(exercise) as _).collect())
    }

    fn of_rig(&self, rig: &LoadedRig) -> anyhow::Result<Motions> {
        let expanded = expand_all(&self.clips)?;
        let mapping =
            self.mapping.as_deref().map(|path| read_mapping(path.as_ref())).transpose()?;
        let mechanism = Arc::new(rig.mechanism.clone());
        let performed = |file: &ClipFile| -> anyhow::Result<RigClip> {
            let clip = PreparedClip::read(file, ClipSettings::default())?;
            let taken = retarget_clip(&rig.mechanism, &clip, mapping.as_ref(), false)?;
            let choices = MotionChoices::default();
            let made = RigPerformance::new(rig, &clip.clip.name, clip.start_s, taken, choices)?;
            let names = [file.name.as_str(), rig.description.name.as_str()];
            let rate_hz = self.rate_hz.unwrap_or(RATES_HZ[1]);
            Ok(RigClip::new(names, &mechanism, &Arc::new(made.clip), None, rate_hz)?)
        };
        let (made, _) = expanded.take(expanded.clips.iter().map(performed), false)?;
        Ok(made.into_iter().map(|clip| Box::new(clip) as _).collect())
    }
}
