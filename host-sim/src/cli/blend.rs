//! `sinew clip blend`: blends one clip into another.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use anyhow::{Context as _, bail};
use clap::ValueEnum;
use sinew_figure::Mapping;
use sinew_figure::pipeline::{LoadedClip, Settings, load_clip};
use sinew_host_util::command::{ThreadArgs, note, print, with_progress};
use sinew_host_util::output;
use sinew_mocap::bvh;
use sinew_mocap::files::ClipFile;
use sinew_pose_metrics::blend::{self, FrameRanges, Outcome, Pair, Side};
use sinew_pose_metrics::find::{ClipPart, Reference};
use sinew_pose_metrics::spatial::{
    BODY_COUNT_MAX, Measure, Metric, RigMeasure, SpatialRig, Workspace,
};
use sinew_report::blend as picture;

use super::clips::seconds;
use super::find::{self, ensure_room, frames};
use super::output::OutputPath;
use super::unit_args::UnitArgs;

/// Blend one clip into another where their poses are nearest, and write the motion as BVH.
///
/// The middle of the blend is the pair of frames with the shortest geodesic: the path of
/// the joints through space that keeps bone lengths. Both clips play on during the blend.
/// Every pose is on the geodesic between the poses of the two clips. The share of its
/// length grows smoothly, so that velocity is continuous at both ends. For long chains a
/// geodesic may not be found: then every joint takes its own shortest path, and the report
/// says so. The second clip is turned about the vertical and shifted so that the clips
/// meet. Feet are not held on the floor, and may slide.
///
///   sinew clip blend walk.bvh run.bvh --output walk-run.bvh
///   sinew clip blend walk.bvh@1s..2.5s run.bvh --output walk-run.bvh --blend-s 0.4 --picture walk-run.png
///   sinew clip blend walk.bvh@120 run.bvh@0.6s --output walk-run.bvh
///
/// A and B are motions (*.bvh, *.amc with its ASF, humanoid3d_*.txt) of the same joints, of
/// any skeleton with at most 256 joints that move: a human, an animal, a face.
/// FILE@FROM..TO gives the part in which the middle may be (in frames from 0, or seconds),
/// FILE@PLACE its exact place. Default: any place that leaves enough of both clips, see
/// --alone-s.
///
/// The file has the skeleton, the unit of length and the rate of A.
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The first clip, in which the blend starts.
    #[arg(value_name = "A")]
    a: Reference,

    /// The second clip, in which the blend ends.
    #[arg(value_name = "B")]
    b: Reference,

    /// The BVH file to write.
    #[arg(long, value_name = "FILE.bvh")]
    output: OutputPath,

    /// Length of the blend, in s, rounded to an even number of A's frames. 0.5 s is about one step of a walk. A shorter
    /// blend is more abrupt; a longer one mixes different steps.
    #[arg(long, value_name = "S", default_value_t = 0.5, value_parser = seconds, allow_negative_numbers = true)]
    blend_s: f64,

    /// Minimum time, in s, that A plays alone before the blend, and B after it. With 0 the blend may begin and end
    /// with the clips.
    #[arg(long, value_name = "S", default_value_t = 0.5, value_parser = find::seconds, allow_negative_numbers = true)]
    alone_s: f64,

    /// Mapping of the clips' skeleton to the figure: a TOML file, or the name of a known skeleton (`sinew clip map
    /// --list`). Default: the known skeleton that fits; else the proposal of `sinew clip map`; else no mapping. Clips
    /// of any skeleton can be compared.
    #[arg(long, value_name = "FILE|NAME")]
    mapping: Option<PathBuf>,

    #[command(flatten)]
    units: UnitArgs,

    /// Format of the output.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,

    /// Also draw a picture into this file: figures during the blend, the places where the clips are near each other,
    /// and speeds.
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    picture: Option<OutputPath>,

    #[command(flatten)]
    threads: ThreadArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A line for each result.
    Text,
    /// One JSON object, schema `sinew-blend/1`.
    Json,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    args.threads.install(|| args.blend())
}

impl Args {
    fn blend(&self) -> anyhow::Result<()> {
        if let Some(path) = &self.picture {
            picture::check(path).with_context(|| format!("--picture {}", path.display()))?;
        }
        if !self.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("bvh")) {
            bail!("--output {}: expected a file named *.bvh", self.output.display());
        }
        let mapping = self.mapping.as_deref().map(Mapping::named).transpose()?;
        let settings = Settings { mapping, units: self.units.overrides(), ..Settings::default() };
        let read = |reference: &Reference| -> anyhow::Result<(LoadedClip, (usize, usize))> {
            let file = ClipFile::new(&reference.file);
            let (recorded, notices) = load_clip(&file, &settings)?;
            for notice in notices {
                note(format_args!("{}: {notice}", file.name));
            }
            let frames = reference.frames(&recorded)?;
            Ok((recorded, frames))
        };
        let (a, frames_a) = read(&self.a)?;
        let (b, frames_b) = read(&self.b)?;
        let rate_hz = a.clip.rate_hz();
        let half = half(0.5 * self.blend_s * rate_hz);
        let left = half + frames(self.alone_s * rate_hz);
        let (clip_a, clip_b) = (a.clip.clone(), &b.clip);
        let pair = Pair::new(clip_a, clip_b).with_context(|| self.b.file.display().to_string())?;
        ensure_room(&self.a.file, pair.body().joints.len())?;
        let places = FrameRanges {
            a: Room { frames: pair.a.frames.len(), around: [left, half], rate_hz }
                .places(&self.a, frames_a, 1.0)?,
            b: Room { frames: pair.b.frames.len(), around: [half, left], rate_hz }.places(
                &self.b,
                frames_b,
                rate_hz / b.clip.rate_hz(),
            )?,
        };
        let pairs = places.a.clone().count() * places.b.clone().count();
        let nearest = with_progress(pairs, |done| blend::nearest(&pair, &places, done))?;
        let blend = with_progress(2 * half + 1, |done| {
            blend::blend(&pair, nearest.a, nearest.b, half, done)
        })?;
        let text = bvh::text(&blend.clip, a.metres_per_unit)
            .with_context(|| format!("--output {}", self.output.display()))?;
        output::write(&self.output, text)?;
        let side = |recorded: &LoadedClip| {
            (recorded.skipped as f64 * recorded.clip.frame_time_s, recorded.clip.rate_hz())
        };
        let (of_a, of_b) = (side(&a), side(&b));
        let sides = [
            Side { name: &a.clip.name, start_s: of_a.0, file_rate_hz: of_a.1 },
            Side { name: &b.clip.name, start_s: of_b.0, file_rate_hz: of_b.1 },
        ];
        if let Some(path) = &self.picture {
            let drawing = picture::Drawing {
                pair: &pair,
                mapping: a.mapping.as_ref(),
                sides,
                nearest: &nearest,
                blend: &blend,
            };
            picture::write(path, &drawing)
                .with_context(|| format!("--picture {}", path.display()))?;
        }
        let outcome = Outcome {
            a: sides[0],
            b: sides[1],
            nearest: &nearest,
            line_m: line_m(&pair, nearest.a, nearest.b)?,
            blend: &blend,
            scale: pair.scale,
        };
        print(&match self.format {
            Format::Text => blend::text(&outcome),
            Format::Json => blend::json(&outcome),
        })?;
        Ok(())
    }
}

/// Returns half of the length of a blend in frames, at least one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not negative, and saturates"
)]
fn half(frames: f64) -> usize {
    libm::round(frames).max(1.0) as usize
}

/// The size of a clip, and the numbers of frames that must remain before and after the blend's middle.
struct Room {
    frames: usize,
    around: [usize; 2],
    rate_hz: f64,
}

impl Room {
    /// Returns the frames of the file where the blend's middle may be: the requested part, cut to the frames with
    /// enough room around them.
    fn places(
        &self,
        reference: &Reference,
        (first, last): (usize, usize),
        factor: f64,
    ) -> anyhow::Result<RangeInclusive<usize>> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "frames of the clip"
        )]
        let at_rate = |frame: usize| libm::round(frame as f64 * factor) as usize;
        let end = self.frames.saturating_sub(1);
        let (first, last) = (at_rate(first), at_rate(last).min(end));
        let file = reference.file.display();
        let seconds = |frames: usize| frames as f64 / self.rate_hz;
        let [before, after] = self.around;
        if end < before + after {
            let (half, left) = (before.min(after), before.abs_diff(after));
            // Rounded down to the precision of the printed times.
            let at_most = |frames: usize| libm::floor(1e3 * seconds(frames)) / 1e3;
            let would_do = match end.checked_sub(2 * half) {
                Some(rest) => format!("--alone-s {:.3} would do", at_most(rest)),
                None if end < 2 => "take a longer clip".to_owned(),
                None => format!("--alone-s 0 --blend-s {:.3} would do", at_most(end - end % 2)),
            };
            bail!(
                "{file}: expected at least {:.3} s, the blend and {:.3} s of the clip alone, found {:.3} s; {would_do}",
                seconds(before + after),
                seconds(left),
                seconds(end)
            );
        }
        let places = first.max(before)..=last.min(end - after);
        let is_one = reference.part != ClipPart::Whole && first == last;
        if places.is_empty() || (is_one && first != *places.start()) {
            bail!(
                "{file}: expected a place at least {:.3} s from the clip's start and {:.3} s from its end, for half of \
                 the blend on both sides and the part that plays alone (see --alone-s)",
                seconds(before),
                seconds(after)
            );
        }
        Ok(places)
    }
}

/// Returns the length of the line between two poses, m, in the metric `line` of `sinew clip find`.
fn line_m(pair: &Pair, a: usize, b: usize) -> anyhow::Result<f64> {
    let rig = SpatialRig::<BODY_COUNT_MAX>::sized(pair.body(), None)?;
    let measuring = RigMeasure::new(&rig, Measure::new(Metric::Line));
    let pose = |frame: &[_]| measuring.pose(&pair.rotations(frame));
    let (a, b) = (pose(&pair.a.frames[a])?, pose(&pair.b.frames[b])?);
    Ok(f64::from(measuring.distance(&a, &b, &mut Workspace::new())))
}
