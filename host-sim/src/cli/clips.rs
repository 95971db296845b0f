//! Options that name clips.

use std::path::PathBuf;

use rayon::prelude::*;
use sinew_sim::builtin;
use sinew_sim::figure::{FigureMotion, mapping};
use sinew_sim::pipeline::{self, Notice, Settings};

use super::output::note;

/// Options that name clips.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct ClipArgs {
    /// BVH, AMC (its ASF beside it) or humanoid3d text files, or folders of them. Default: the built-in clips.
    #[arg(long, value_name = "PATH", num_args = 1..)]
    clips: Vec<PathBuf>,

    /// How the clips' skeleton maps on the figure, in TOML. Default: chosen among the known ones.
    #[arg(long, value_name = "FILE")]
    mapping: Option<PathBuf>,

    /// Rate of control and plant, in Hz; the clips are resampled to it. Default: 100 as in the paper, 500 for
    /// `rig`.
    #[arg(long, value_name = "HZ", value_parser = rate, allow_negative_numbers = true)]
    rate: Option<f64>,

    /// Rate of the frames that the controller is given, in Hz. It divides `--rate`; the controller interpolates
    /// smoothly. Default: a frame for every tick; 100 for `rig` and `latency`.
    #[arg(long, value_name = "HZ", value_parser = rate, allow_negative_numbers = true)]
    frames: Option<f64>,
}

type Prepared = Result<(FigureMotion, Vec<Notice>), pipeline::Error>;

impl ClipArgs {
    /// Whether a rate is given.
    pub(super) const fn has_rate(&self) -> bool {
        self.rate.is_some()
    }

    /// At this rate.
    pub(super) fn with_rate(&self, rate_hz: f64) -> Self {
        Self { rate: Some(rate_hz), ..self.clone() }
    }

    /// With these rates where none are given; a frame for every tick where the frames' rate does not divide the
    /// other.
    pub(super) fn at(&self, rate_hz: f64, frames_hz: f64) -> Self {
        let rate = self.rate.unwrap_or(rate_hz);
        let goes_in = (rate / frames_hz).fract().abs() < f64::EPSILON && rate >= frames_hz;
        let frames = self.frames.or(goes_in.then_some(frames_hz));
        Self { rate: Some(rate), frames, ..self.clone() }
    }

    /// Reads and prepares the clips, in their order, and tells what was done to them.
    pub(super) fn motions(&self) -> anyhow::Result<(Vec<FigureMotion>, Vec<String>)> {
        let (motions, lines) = self.read()?;
        for line in &lines {
            note(format_args!("{line}"));
        }
        Ok((motions, lines))
    }

    /// Reads and prepares the clips, in their order; what was done to them is only returned.
    pub(super) fn read(&self) -> anyhow::Result<(Vec<FigureMotion>, Vec<String>)> {
        let settings = Settings {
            mapping: self.mapping.as_deref().map(mapping::Mapping::read).transpose()?,
            rate_hz: self.rate.unwrap_or(100.0),
            frame_rate_hz: self.frames,
            ..Settings::default()
        };
        let prepared: Vec<Prepared> = if self.clips.is_empty() {
            builtin::clips()
                .into_par_iter()
                .map(|clip| pipeline::prepare(clip, &settings))
                .collect()
        } else {
            sinew_mocap::files::expand(&self.clips)?
                .par_iter()
                .map(|file| pipeline::prepare(pipeline::load(file, &settings)?, &settings))
                .collect()
        };
        let (mut motions, mut lines) = (Vec::with_capacity(prepared.len()), Vec::new());
        for prepared in prepared {
            let (motion, notices) = prepared?;
            for notice in notices {
                lines.push(format!("{}: {notice}", motion.name));
            }
            motions.push(motion);
        }
        Ok((motions, lines))
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
