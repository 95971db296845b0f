//! `sinew clip find`: the nearest moments in a library of clips.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, ensure};
use clap::ValueEnum;
use sinew_figure::Mapping;
use sinew_figure::pipeline::{Notice, Settings};
use sinew_host_util::command::{ThreadArgs, note, print, with_progress};
use sinew_pose_metrics::find::{self, ClipPart, Library, Limits, Query, Reference, Search};
use sinew_pose_metrics::spatial::{
    BODY_COUNT, BODY_COUNT_MAX, Measure, MeasureArgs, RigMeasure, Rigid, SpatialRig,
};
use sinew_report::moments as picture;

use super::output::OutputPath;
use super::unit_args::UnitArgs;

/// Find the moments in clips that are most similar to a pose, or to a piece of a clip.
///
/// CLIP is a motion (*.bvh, *.amc with its ASF, humanoid3d_*.txt) or a folder of them, of
/// any skeleton with at most 256 joints that move: a human, an animal, a face. All poses
/// are moved to the skeleton of the query; joints are matched by their names. A clip with
/// other joints is refused if it is named, and left out if it is in a folder. Joints that
/// no clip moves do not count.
///
///   sinew clip find walks/ fights/ --like punch.bvh@1.25s
///   sinew clip find walks/ --like kick.bvh@40 --metric positions --weighted
///   sinew clip find fights/ --like punch.bvh@1.0s..1.6s --picture found.png
///
/// A pose is FILE@FRAME (from 0) or FILE@SECONDSs; a piece of a clip is FILE@FROM..TO, or
/// FILE for all of it. It is compared with every place of every clip; the distance is the
/// root mean square of the frames' distances. Among places close to each other, only the
/// nearest is reported. The query's own place does not count.
///
/// The result is the same as if all distances were computed: a place is left out only if a
/// lower bound of its distance is too large.
///
/// --metric geodesic takes about 50 ms of processor time for each pose that is near, for a
/// figure of 31 joints; for a piece of a clip, multiply by its number of frames. With
/// --check this time is needed for every pose of the library.
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// Clips, or folders of them (not their subfolders).
    #[arg(value_name = "CLIP", required = true)]
    clips: Vec<PathBuf>,

    /// Fail if a file in a folder cannot be searched, because it is damaged or has another skeleton than the query.
    /// Default: the command leaves the file out, and names it.
    #[arg(long)]
    strict: bool,

    /// The query: a pose, such as punch.bvh@40 (frame) or punch.bvh@1.25s (time), or a piece of a clip, such as
    /// punch.bvh@1.0s..1.6s or punch.bvh.
    #[arg(long, value_name = "POSE|CLIP")]
    like: Reference,

    #[command(flatten)]
    measure: MeasureArgs,

    /// Rate at which clips are searched, in Hz; clips are resampled to it. The time of a moment has an error of at most
    /// half a frame. At 30 Hz this is 10 cm for a fist that moves at 6 m/s.
    #[arg(long, value_name = "HZ", default_value_t = 30.0, value_parser = rate, allow_negative_numbers = true)]
    rate_hz: f64,

    /// Number of moments to find.
    #[arg(long, value_name = "K", default_value = "10")]
    count: NonZeroUsize,

    /// Minimum time between two moments of one clip, in s.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.5, value_parser = seconds, allow_negative_numbers = true)]
    apart_s: f64,

    /// Mapping of the clips' skeleton to the figure: a TOML file, or the name of a known skeleton (`sinew clip map
    /// --list`). Default: the known skeleton that fits; else the proposal of `sinew clip map`; else no mapping. Clips
    /// of any skeleton can be compared.
    #[arg(long, value_name = "FILE|NAME")]
    mapping: Option<PathBuf>,

    #[command(flatten)]
    units: UnitArgs,

    /// Format of the output.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,

    /// Also draw the query and the moments into this file.
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    picture: Option<OutputPath>,

    /// Also compute every distance, fail if the result differs, and print the durations of both searches.
    #[arg(long)]
    check: bool,

    #[command(flatten)]
    threads: ThreadArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// An aligned table.
    Table,
    /// One JSON object, schema `sinew-find/1`.
    Json,
    /// A row per moment.
    Csv,
}

fn rate(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(rate) if (1.0..=1000.0).contains(&rate) => Ok(rate),
        _ => Err("expected a number of Hz from 1 to 1000".into()),
    }
}

/// Parses a time in s, which may be zero.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(seconds) if (0.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("expected a number of seconds from 0 to 1000000".into()),
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    args.threads.install(|| args.search())
}

impl Args {
    fn search(&self) -> anyhow::Result<()> {
        let measure = self.measure.measure()?;
        if let Some(path) = &self.picture {
            picture::check(path).with_context(|| format!("--picture {}", path.display()))?;
        }
        let mapping = self.mapping.as_deref().map(Mapping::named).transpose()?;
        let settings = Settings { mapping, units: self.units.overrides(), ..Settings::default() };
        let query = Query::read(&self.like, &settings, self.rate_hz)?;
        for notice in &query.notices {
            note(format_args!("{}: {notice}", query.name));
        }
        let files = sinew_mocap::files::expand(&self.clips)?.len();
        let library = with_progress(files, |done| {
            Library::read(&self.clips, &query, &settings, self.strict, done)
        })?;
        tell(&library, query.poses.len());
        let rigid = library.rigid(&query, self.measure.root.as_deref());
        // With a root other than the skeleton's own, there is one more body.
        let bodies = rigid.skeleton.joints.len() + usize::from(self.measure.root.is_some());
        ensure_room(&query.file, bodies)?;
        if bodies <= BODY_COUNT {
            self.among::<BODY_COUNT>(measure, &query, &library, &rigid)
        } else {
            self.among::<BODY_COUNT_MAX>(measure, &query, &library, &rigid)
        }
    }

    /// Searches the library for the query, on a skeleton of at most `N` bodies.
    fn among<const N: usize>(
        &self,
        measure: Measure,
        query: &Query,
        library: &Library,
        rigid: &Rigid,
    ) -> anyhow::Result<()> {
        let rig = SpatialRig::<N>::sized(&rigid.skeleton, self.measure.root.as_deref())
            .with_context(|| query.file.display().to_string())?;
        let measuring = RigMeasure::new(&rig, measure);
        let of_query = query.measured(&measuring, rigid)?;
        let of_clips = library.measured(&measuring, rigid)?;
        let apart = frames(self.apart_s * self.rate_hz);
        let limits = Limits { count: self.count.get(), apart };
        let start = Instant::now();
        let mut search = Search::new(&rig, &measuring, &of_query, &of_clips);
        if let Some((clip, poses)) = self.own(query, library, apart) {
            search = search.without(clip, poses);
        }
        let found = with_progress(search.place_count(), |done| search.nearest(limits, done));
        let pruned_s = start.elapsed().as_secs_f64();
        if self.check {
            let start = Instant::now();
            let all =
                with_progress(search.place_count(), |done| search.nearest_of_all(limits, done));
            let all_s = start.elapsed().as_secs_f64();
            ensure!(
                all.moments == found.moments,
                "--check: computing every distance finds other moments: this is a bug of the program"
            );
            note(format_args!(
                "checked: the same moments; {:.1} ms, and {:.1} ms by computing every distance",
                1e3 * pruned_s,
                1e3 * all_s
            ));
        }
        if let Some(path) = &self.picture {
            picture::write(path, query, library, measure, &found)
                .with_context(|| format!("--picture {}", path.display()))?;
        }
        print(&match self.format {
            Format::Table => find::text(query, library, measure, &found),
            Format::Json => find::json(query, library, measure, &found),
            Format::Csv => find::csv(query, library, &found),
        })?;
        Ok(())
    }

    /// If the query's file is among the searched clips: returns its index, and the range of its frames that do not
    /// count.
    fn own(
        &self,
        query: &Query,
        library: &Library,
        apart: usize,
    ) -> Option<(usize, std::ops::Range<usize>)> {
        let place = |file: &PathBuf| file.canonicalize().ok();
        let clip = library.clips.iter().position(|clip| place(&clip.file) == place(&query.file))?;
        note(format_args!("{}: the query's own place does not count", query.name));
        if self.like.part == ClipPart::Whole {
            return Some((clip, 0..usize::MAX));
        }
        let shelved = &library.clips[clip];
        let middle = frames((query.start_s - shelved.start_s) * self.rate_hz - 0.5);
        // Places that overlap the query do not count either.
        let apart = apart.max(query.poses.len()).max(1);
        Some((clip, (middle + 1).saturating_sub(apart)..middle + apart))
    }
}

/// Refuses a skeleton that has too many moving joints to be compared.
pub(super) fn ensure_room(file: &Path, bodies: usize) -> anyhow::Result<()> {
    ensure!(
        bodies <= BODY_COUNT_MAX,
        "{}: expected at most {BODY_COUNT_MAX} joints that move, found {bodies}",
        file.display()
    );
    Ok(())
}

/// Rounds a number of frames up.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not negative, and saturates"
)]
pub(super) fn frames(count: f64) -> usize {
    libm::ceil(count - 1e-6).max(0.0) as usize
}

/// Prints, in a few lines, which changes were made to the clips.
fn tell(library: &Library, length: usize) {
    let (mut lowest_m, mut highest_m) = (f64::INFINITY, 0.0);
    let (mut t_poses, mut others) = (Vec::new(), Vec::new());
    for clip in &library.clips {
        for notice in &clip.notices {
            match notice {
                Notice::Measured(measured) => {
                    let height_m = measured.height_m().unwrap_or_default();
                    lowest_m = f64::min(lowest_m, height_m);
                    highest_m = f64::max(highest_m, height_m);
                }
                Notice::TPoseSkipped => t_poses.push(clip),
                _ => others.push((clip, notice)),
            }
        }
    }
    if lowest_m <= highest_m {
        let count = library.clips.len();
        note(format_args!("{count} clips, {lowest_m:.2} to {highest_m:.2} m tall"));
    }
    if !t_poses.is_empty() {
        note(format_args!("skipped frame 0, an inserted T-pose, of {} clips", t_poses.len()));
    }
    for (clip, notice) in others {
        note(format_args!("{}: {notice}", clip.name));
    }
    for why in &library.left_out {
        note(format_args!("left out: {why}"));
    }
    let short = library.clips.iter().filter(|clip| clip.poses.len() < length).count();
    if short > 0 {
        note(format_args!("{short} clips are shorter than the query: nothing is found in them"));
    }
}
