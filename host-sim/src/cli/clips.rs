//! Options that name the motions to track: clips, or motions of a rig's own joints.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::bail;
use rayon::prelude::*;
use sinew_evaluation::EvaluatedMotion;
use sinew_evaluation::exercise::{Exercise, ExerciseSettings, make_exercises};
use sinew_figure::builtin;
use sinew_figure::pipeline::{self, Notice, Settings};
use sinew_figure::{FigureMotion, mapping};
use sinew_host_util::command::{ThreadArgs, note};
use sinew_mocap::files::{ClipFile, expand_all};
use sinew_performance::RigClip;
use sinew_performance::rig::LoadedRig;

use super::performance::{ON_STAND, PerformanceArgs};
use super::unit_args::UnitArgs;

/// Options that name the motions to track.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct ClipArgs {
    /// BVH, AMC (its ASF beside it) or humanoid3d text files, or folders of them; with --rig also built-in clips by
    /// name, and CSV or JSON files of the rig's own motion. Default: the built-in clips; with --rig, motions of the
    /// rig's own joints.
    #[arg(long, value_name = "PATH", num_args = 1..)]
    clips: Vec<PathBuf>,

    /// Fail if a file in a folder cannot be used, because it is damaged or no mapping fits its skeleton. Default: the
    /// command leaves the file out, and names it.
    #[arg(long, requires = "clips")]
    strict: bool,

    /// Mapping of the clips' skeleton to the figure or the rig, in TOML: see `sinew clip map`. Default: chosen among
    /// the known mappings; with --rig, by names and geometry.
    #[arg(long, value_name = "FILE")]
    mapping: Option<PathBuf>,

    #[command(flatten)]
    units: UnitArgs,

    /// Rate of control and plant, in Hz; the clips are resampled to it. Default: 100 as in the paper, 500 for
    /// `robustness` and for `--rig`. Not for `latency`, which has `--rates-hz`.
    #[arg(long, value_name = "HZ", value_parser = rate, allow_negative_numbers = true)]
    rate_hz: Option<f64>,

    /// Rate of the frames that the controller receives, in Hz. It must divide `--rate-hz`; the controller
    /// interpolates smoothly. Default: a frame for every tick; 100 for `robustness` and `latency`.
    #[arg(long, value_name = "HZ", value_parser = rate, allow_negative_numbers = true, conflicts_with = "rig")]
    frame_rate_hz: Option<f64>,

    /// Your own rig instead of the figure: rig.toml, URDF or MJCF. It tracks `--clips`, or without clips built-in
    /// motions: of all joints together, and for `evaluate` also of each joint in turn. Default plant: `articulated`,
    /// the exact one.
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,

    /// Speeds of the motions of the rig's own joints, as shares of each joint's maximum speed and acceleration, 0.01 to
    /// 1.
    #[arg(
        long,
        value_name = "SHARE,..",
        value_delimiter = ',',
        default_value = "0.2,0.6",
        requires = "rig",
        allow_negative_numbers = true
    )]
    speed_shares: Vec<f64>,

    /// Seed of the built-in motions of --rig, which are used without --clips.
    #[arg(long, value_name = "SEED", default_value_t = 1, requires = "rig")]
    motion_seed: u64,
}

/// Motions to track: clips on the figure, clips on a rig, or a rig's own motions.
type Motions = Vec<Box<dyn EvaluatedMotion>>;

/// Default rate of control and plant for a user's rig, Hz.
pub(super) const RIG_RATE_HZ: f64 = 500.0;

impl ClipArgs {
    /// Returns the input files, each with its role.
    pub(super) fn files(&self) -> Vec<(&'static str, Option<&Path>)> {
        let clips = self.clips.iter().map(|clip| ("clip", Some(clip.as_path())));
        let others = [("mapping", self.mapping.as_deref()), ("rig", self.rig.as_deref())];
        clips.chain(others).collect()
    }

    /// Runs `work` with the user's rig, if one is named, in a pool of threads.
    pub(super) fn in_pool(
        &self,
        threads: &ThreadArgs,
        on_rig: &PerformanceArgs,
        work: impl FnOnce(Option<&LoadedRig>) -> anyhow::Result<ExitCode> + Send,
    ) -> anyhow::Result<ExitCode> {
        threads.install(|| {
            let rig = self.rig(on_rig)?;
            work(rig.as_ref())
        })
    }

    /// Reads the user's rig, if one is named. Notes of the import go to standard error.
    pub(super) fn rig(&self, on_rig: &PerformanceArgs) -> anyhow::Result<Option<LoadedRig>> {
        self.rig.as_deref().map(|path| on_rig.rig(path, ON_STAND)).transpose()
    }

    /// Refuses options that apply only to clips. Callers use it if a rig tracks motions of its own joints.
    pub(super) fn ensure_no_clips(&self, on_rig: &PerformanceArgs) -> anyhow::Result<()> {
        let mapping = self.mapping.is_some().then_some("--mapping");
        let given = mapping
            .or(on_rig.of_clips())
            .or(on_rig.of_own())
            .or(self.units.given())
            .or(on_rig.fits().then_some("--fit"));
        if let Some(option) = given {
            bail!("{option} has no effect on a rig's motions of its own joints; it is for --clips");
        }
        Ok(())
    }

    /// Returns whether a rig tracks clips.
    pub(super) fn of_rig(&self) -> bool {
        self.rig.is_some() && !self.clips.is_empty()
    }

    /// Reads the clips and maps them to a rig.
    pub(super) fn performances(
        &self,
        rig: &LoadedRig,
        on_rig: &PerformanceArgs,
    ) -> anyhow::Result<Vec<RigClip>> {
        let expanded = expand_all(&self.clips)?;
        let mechanism = Arc::new(rig.mechanism.clone());
        let rate_hz = self.rate_hz.unwrap_or(RIG_RATE_HZ);
        let performed = |file: &ClipFile| -> anyhow::Result<RigClip> {
            let mapping = self.mapping.as_deref();
            let performance =
                on_rig.perform(rig, &file.path, mapping, None, (ON_STAND, self.units))?;
            let names = [file.name.as_str(), rig.description.name.as_str()];
            let (taken, fit) = (Arc::new(performance.clip), performance.fit.as_ref());
            Ok(RigClip::new(names, &mechanism, &taken, fit, rate_hz)?)
        };
        let performances = expanded.clips.iter().map(performed);
        let (performances, left_out) = expanded.take(performances, self.strict)?;
        tell(&left_out_lines(&left_out));
        Ok(performances)
    }

    /// Returns motions of a rig's own joints. With `in_turn`, also motions of each joint alone.
    pub(super) fn exercises(
        &self,
        rig: &LoadedRig,
        in_turn: bool,
    ) -> anyhow::Result<Vec<Exercise>> {
        let settings = ExerciseSettings {
            rate_hz: self.rate_hz.unwrap_or(RIG_RATE_HZ),
            shares: self.speed_shares.clone(),
            seed: self.motion_seed,
            in_turn,
            ..ExerciseSettings::default()
        };
        Ok(make_exercises(&rig.description.name, &rig.mechanism, &settings)?)
    }

    /// Returns the motions to track, of the figure or of a rig, and lines about changes that were made to the clips. A
    /// rig without clips gets only motions of all joints together: motions of one joint at a time take long, and most
    /// joints stand still.
    pub(super) fn takes(&self, rig: Option<&LoadedRig>) -> anyhow::Result<(Motions, Vec<String>)> {
        fn boxed<T: EvaluatedMotion + 'static>(takes: Vec<T>) -> Motions {
            takes.into_iter().map(|take| Box::new(take) as Box<dyn EvaluatedMotion>).collect()
        }
        match rig {
            Some(rig) if self.of_rig() => {
                Ok((boxed(self.performances(rig, &PerformanceArgs::default())?), Vec::new()))
            }
            Some(rig) => Ok((boxed(self.exercises(rig, false)?), Vec::new())),
            None => self.read().map(|(motions, lines)| (boxed(motions), lines)),
        }
    }

    /// Returns whether a rate is given.
    pub(super) const fn has_rate(&self) -> bool {
        self.rate_hz.is_some()
    }

    /// Returns these options with another rate.
    pub(super) fn with_rate(&self, rate_hz: f64) -> Self {
        Self { rate_hz: Some(rate_hz), ..self.clone() }
    }

    /// Fills in rates that are not given. If `frames_hz` does not divide the rate, every tick has a frame.
    pub(super) fn at(&self, rate_hz: f64, frames_hz: f64) -> Self {
        let rate = self.rate_hz.unwrap_or(rate_hz);
        let goes_in = (rate / frames_hz).fract().abs() < f64::EPSILON && rate >= frames_hz;
        let frames = self.frame_rate_hz.or(goes_in.then_some(frames_hz));
        Self { rate_hz: Some(rate), frame_rate_hz: frames, ..self.clone() }
    }

    /// Reads and prepares the clips, in their order. Also returns lines about changes that were made to them.
    pub(super) fn read(&self) -> anyhow::Result<(Vec<FigureMotion>, Vec<String>)> {
        let settings = Settings {
            mapping: self.mapping.as_deref().map(mapping::Mapping::named).transpose()?,
            rate_hz: self.rate_hz.unwrap_or(100.0),
            frame_rate_hz: self.frame_rate_hz,
            units: self.units.overrides(),
            ..Settings::default()
        };
        settings.check()?;
        let (prepared, left_out) = if self.clips.is_empty() {
            let prepared: Result<Vec<_>, _> =
                builtin::par_clips().map(|clip| pipeline::prepare(clip, &settings)).collect();
            (prepared?, Vec::new())
        } else {
            let expanded = expand_all(&self.clips)?;
            let prepare =
                |file: &ClipFile| pipeline::prepare(pipeline::load(file, &settings)?, &settings);
            let prepared: Vec<_> = expanded.clips.par_iter().map(prepare).collect();
            expanded.take(prepared, self.strict)?
        };
        let mut lines = left_out_lines(&left_out);
        let mut motions = Vec::with_capacity(prepared.len());
        for (motion, notices) in prepared {
            // Measurements of built-in clips are known; they are not printed.
            let is_told =
                |notice: &Notice| !(self.clips.is_empty() && matches!(notice, Notice::Measured(_)));
            for notice in notices.into_iter().filter(is_told) {
                lines.push(format!("{}: {notice}", motion.name));
            }
            motions.push(motion);
        }
        Ok((motions, lines))
    }
}

/// Returns the subject of a report: the number of clips, or the rig and the number of motions.
pub(super) fn what(rig: Option<&LoadedRig>, count: usize) -> String {
    match rig {
        Some(rig) => format!("rig {}, {count} motions", rig.description.name),
        None => format!("{count} clips"),
    }
}

/// Returns the figure's dimensions for a report. Empty for a rig, which has its own.
pub(super) fn dimensions(rig: Option<&LoadedRig>, scale: f64) -> String {
    rig.map_or_else(|| format!(", {scale} times the dimensions"), |_| String::new())
}

/// Returns a line for each file of a folder that is left out.
fn left_out_lines(left_out: &[String]) -> Vec<String> {
    left_out.iter().map(|why| format!("left out: {why}")).collect()
}

/// Prints notes on changes that were made to the clips.
pub(super) fn tell(lines: &[String]) {
    for line in lines {
        note(format_args!("{line}"));
    }
}

pub(super) fn rate(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(rate) if (10.0..=10_000.0).contains(&rate) => Ok(rate),
        _ => Err("expected a number of Hz from 10 to 10000".into()),
    }
}

pub(super) fn seconds(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds.is_finite() => Ok(seconds),
        _ => Err("expected a number of seconds above 0".into()),
    }
}
