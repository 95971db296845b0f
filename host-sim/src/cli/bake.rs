//! `sinew bake`: a show for a board.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{bail, ensure};
use sinew_host_util::command::{note, print};
use sinew_host_util::output;
use sinew_performance::rig::LoadedRig;
use sinew_performance::{
    Baked, LayerChoice, Likeness, RigPerformance, ShowChoices, ShowPlayback, feasibility, led,
    rig_hash,
};
use sinew_report::feasibility::Page;
use sinew_show::sound::Sound;
use sinew_show::write::Settings as ShowSettings;
use sinew_show::{Show, TimeCode, TimeCodeKind};

use super::clips::seconds;
use super::driven::DriveArg;
use super::output::OutputPath;
use super::performance::{ON_STAND, PerformanceArgs};
use super::sound;
use super::unit_args::UnitArgs;

/// Bake a clip into a show, the file that a board plays.
///
/// The show contains the motion of your rig, as splines (`docs/show-format.md`). A report lists the joints that cannot
/// follow, at which time, and by how much.
///
/// A CSV of keys has a row for each time, with commas, semicolons or tabs: `time` in s or `time_ms`, at any intervals;
/// `NAME_deg` or `NAME_rad` of each joint in any order, `NAME_mm` or `NAME_m` of a slide. A joint without a column
/// stays at home. An empty field is not a key: the joint moves on to its next key. The column `easing` names the easing
/// to the next row; a row below the header with `easing` as its time names the easing of each joint: step, linear, ease
/// in, ease out, ease both, or cubic (default). Evenly spaced rows at 10 Hz or more, without easing, count as a
/// recording.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Motion to bake. A clip: the name of a built-in clip, or a BVH, AMC or humanoid3d text file. Or a motion of the
    /// rig itself: a show of the rig, a CSV of keys, a CSV recording (from `sinew record` or `sinew clip export`), or a
    /// JSON of servo positions. Default: the file of the first --layer; without layers, `punches_01`.
    #[arg(value_name = "CLIP")]
    clip: Option<String>,

    /// Motion of the rig that changes the motion to bake: a show, a CSV or a JSON of servo positions. `over`, the
    /// default, replaces the motion of the joints in the file; `add` adds their distance from home. A weight and the
    /// names of some joints can follow: `talk.csv:over:0.5:jaw,lid_*`. Both motions use the same times, and a loop is
    /// repeated. May be repeated; layers apply in their order.
    #[arg(long, value_name = "FILE[:over|add[:WEIGHT][:JOINT,..]]", requires = "rig")]
    layer: Vec<LayerChoice>,

    /// Rig that performs the show: rig.toml, URDF or MJCF. Required.
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,

    /// Mapping of the clip's joints to the rig's, in TOML, as `sinew clip map` proposes it. Default: by names and
    /// geometry.
    #[arg(long, value_name = "FILE")]
    mapping: Option<PathBuf>,

    #[command(flatten)]
    on_rig: PerformanceArgs,

    #[command(flatten)]
    units: UnitArgs,

    /// Quantity that servos will receive each tick. For servos that receive positions, the following error is
    /// predicted. Default: `current` for servos that have a current mode, else `position`, as in `sinew play`.
    #[arg(long, value_enum)]
    drive: Option<DriveArg>,

    /// Maximum error of the encoded joint angles, in degrees.
    #[arg(long, value_name = "DEG", default_value_t = 0.25, value_parser = error)]
    tolerance_deg: f64,

    /// Cue: its name, and its time in the clip in s. In a fitted show the cue moves with the motion. May be repeated.
    #[arg(long, value_name = "NAME@S", value_parser = cue)]
    cue: Vec<(String, f64)>,

    /// Time code at the start of the show: hours, minutes, seconds, frames, and frames per second (24, 25, 30, 50, 60).
    #[arg(long, value_name = "H:M:S:F@FPS", value_parser = time_code)]
    time_code: Option<TimeCode>,

    /// Sound of the show: a WAV file. The show's file stores its name, hash, length and start; the console and `sinew
    /// play --sound-with` play the sound with the show. Boards do not get it.
    #[arg(long, value_name = "FILE.wav")]
    sound: Option<PathBuf>,

    /// Time of the clip at which the sound begins, in s. It is negative if the sound begins before the clip.
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = place, allow_negative_numbers = true, requires = "sound")]
    sound_at_s: f64,

    /// Make a looping show. The end of the motion is blended into its start, with continuous position, speed and
    /// acceleration. Fails if the blend would exceed a limit or is longer than the clip, if a travelling base would
    /// have to return faster than it ever moves, or if a ball joint would have to turn back by 180 degrees.
    #[arg(long = "loop")]
    is_loop: bool,

    /// Length of the blend of --loop, in s: the loop leaves the clip this long before the clip's end.
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = seconds, allow_negative_numbers = true, requires = "is_loop")]
    loop_blend_s: f64,

    /// Use only the first S seconds of the clip.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,

    /// Also write a page with the rig in motion, and plots of each joint with its limits. The page is one file for
    /// any browser, and needs no network.
    #[arg(long, value_name = "FILE.html")]
    html: Option<OutputPath>,

    /// File to write.
    #[arg(short, long, value_name = "FILE")]
    output: OutputPath,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let Some(rig) = args.rig.as_deref() else {
        bail!(
            "--rig: expected the rig that performs the show: rig.toml, URDF or MJCF; `sinew rig new --arm 6 -o rig.toml` \
             writes one to begin with"
        );
    };
    let mut on_rig = args.on_rig.clone();
    on_rig.blend_s = args.is_loop.then_some(args.loop_blend_s);
    on_rig.has_clock = args.keeps_time();
    on_rig.driven = DriveArg::options(args.drive);
    on_rig.layers.clone_from(&args.layer);
    let clip = match (&args.clip, args.layer.first()) {
        (Some(clip), _) => PathBuf::from(clip),
        (None, None) => PathBuf::from("punches_01"),
        (None, Some(first)) => {
            ensure!(
                first.path.as_os_str() == first.text.as_str(),
                "--layer {}: without a clip the first layer is what the others are put on; it takes no mode, weight or joints",
                first.text
            );
            on_rig.layers.remove(0).path
        }
    };
    let rig = on_rig.rig(rig, ON_STAND)?;
    let mapping = args.mapping.as_deref();
    let mut performance =
        on_rig.perform(&rig, &clip, mapping, args.seconds, (ON_STAND, args.units))?;
    let settings =
        ShowSettings { angle_rad: args.tolerance_deg.to_radians(), ..ShowSettings::default() };
    let (hash, why_not) = rig_hash(&rig.description, &rig.mechanism);
    if let Some(line) = why_not {
        note(format_args!("note: {line}"));
    }
    let mechanism = &rig.mechanism;
    let choices =
        ShowChoices { rig_crc: hash, settings, cues: &args.cue, time_code: args.time_code };
    let (baked, report) = performance.bake(mechanism, &choices)?;
    let mut file = baked.written.bytes.clone();
    let sound = args.sound(&performance, &baked)?;
    if let Some(sound) = &sound {
        sound.append_to(&mut file);
    }
    output::write(&args.output, &file)?;
    let likeness = performance.likeness(mechanism);
    let strange = likeness.strange();
    let head = head(args, &rig, &performance, &baked, likeness) + &told(sound.as_ref());
    let done = performance.fit_summary(mechanism);
    if let Some(file) = &args.html {
        let page = Page {
            rig: &rig.description.name,
            clip: &performance.name,
            mechanism,
            limits: &performance.limits,
            report: &report,
            performance: &ShowPlayback::new(&baked.written.bytes)?,
            fitted: done.as_deref(),
            strange: strange.as_deref(),
            summary: &head,
        };
        output::write(file, page.html()?)?;
        note(format_args!("wrote {}", file.display()));
    }
    let rounding = [settings.angle_rad, settings.length_m];
    let text = feasibility(mechanism, &performance.limits, &report, rounding, strange.as_deref());
    let behind = performance.following_line().unwrap_or_default();
    let done = done.map_or_else(String::new, |done| format!("\nFitted: {done}"));
    print(&format!("{head}\n{text}{behind}{done}"))?;
    Ok(ExitCode::SUCCESS)
}

impl Args {
    /// Returns whether the show must keep the time of its performance, because a sound or a time code runs beside it.
    fn keeps_time(&self) -> bool {
        self.sound.is_some() || self.time_code.is_some()
    }

    /// Returns the description of the show's sound. Fails if a fit has slowed the show down, because sound and motion
    /// would no longer match.
    fn sound(&self, performance: &RigPerformance, baked: &Baked) -> anyhow::Result<Option<Sound>> {
        let Some(path) = &self.sound else { return Ok(None) };
        let given_s = performance.clip.motion.duration_s();
        ensure!(
            baked.duration_s <= given_s + 0.01,
            "--sound: the fit makes {given_s:.2} s of motion last {:.2} s, and the sound would come apart from it: \
             leave --fit out, or make the motion slower or smaller where the rig is too slow",
            baked.duration_s
        );
        sound::describe(path, performance.start_s - self.sound_at_s).map(Some)
    }
}

/// Returns the line about the sound.
fn told(sound: Option<&Sound>) -> String {
    sound.map_or_else(String::new, |sound| {
        let [duration_s, offset_s] =
            [sound.duration_us as f64, sound.offset_us as f64].map(|us| us * 1e-6);
        format!(
            "sound: {}, {duration_s:.2} s; the show begins at {offset_s:.2} s of it; keep it beside the show\n",
            sound.name
        )
    })
}

/// Returns the summary of the show: durations, how like the clip it is, cues and size.
fn head(
    args: &Args,
    rig: &LoadedRig,
    performance: &RigPerformance,
    baked: &Baked,
    likeness: Likeness,
) -> String {
    let written = &baked.written;
    let likeness = likeness.line(performance.clip.limbs);
    let headline = performance.headline(&rig.mechanism);
    let headline = headline.map_or_else(String::new, |line| line + "\n");
    let cue = |(name, given_s): &(String, f64)| {
        let show_s = performance.time_s(*given_s);
        format!("cue {name}: at {given_s:.2} s of the clip, {show_s:.2} s of the show\n")
    };
    let cues: String = args.cue.iter().map(cue).collect();
    let looped =
        performance.looped.as_ref().map_or_else(String::new, |looped| led(&rig.mechanism, looped));
    let code = clock(&baked.written.bytes);
    let minutes = |kb: usize| format!("{:.1} min in {kb} kB", baked.minutes_in(1000 * kb));
    format!(
        "{}: {} on {}, {:.2} s, {} degrees of freedom\n{headline}{likeness}{} bytes, {} knots; error at most {:.3} deg and {:.2} mm, \
         RMS {:.3} deg and {:.2} mm\nroom for such motion: {}, {}, {}\n{looped}{cues}{code}",
        args.output.display(),
        performance.name,
        rig.description.name,
        baked.duration_s,
        baked.dofs,
        written.bytes.len(),
        written.knots,
        written.angles.largest.to_degrees(),
        1000.0 * written.lengths.largest,
        written.angles.rms.to_degrees(),
        1000.0 * written.lengths.rms,
        // Memory sizes in kB: half the flash of an STM32F446; the flash of a usual RP2350 board; a 16 MB SPI flash.
        minutes(256),
        minutes(4_000),
        minutes(16_000),
    )
}

/// Returns the first and last time code of a show as a line, or an empty text if the show has no time code.
fn clock(bytes: &[u8]) -> String {
    let Ok(show) = Show::open(bytes) else { return String::new() };
    let (Some(begin), Some(end)) = (show.time_code(), show.time_code_at(show.length())) else {
        return String::new();
    };
    let slowed = if show.course().next().is_some() { ", slower where the motion is" } else { "" };
    let [begin_at, end_at] = [begin, end].map(|code| {
        let TimeCode { hours, minutes, seconds, frames, .. } = code;
        format!("{hours:02}:{minutes:02}:{seconds:02}:{frames:02}")
    });
    format!("time code: {begin_at} to {end_at} at {} a second{slowed}\n", begin.frames_per_second)
}

fn cue(text: &str) -> Result<(String, f64), String> {
    let expected = "expected a name and a time in s, such as bow@12.5";
    let (name, time) = text.rsplit_once('@').ok_or(expected)?;
    match time.trim().parse::<f64>() {
        Ok(time_s) if (0.0..=1e6).contains(&time_s) && !name.is_empty() => {
            Ok((name.to_owned(), time_s))
        }
        _ => Err(expected.into()),
    }
}

fn time_code(text: &str) -> Result<TimeCode, String> {
    let numbers: Option<Vec<u8>> = text.split([':', '@']).map(|part| part.parse().ok()).collect();
    let &[hours, minutes, seconds, frames, frames_per_second] =
        numbers.as_deref().unwrap_or_default()
    else {
        return Err("expected hours:minutes:seconds:frames@rate, such as 01:00:00:00@25".into());
    };
    let kind = TimeCodeKind::Whole;
    let code = TimeCode { hours, minutes, seconds, frames, frames_per_second, kind };
    if code.is_time() { Ok(code) } else { Err("expected a time code that a clock can show".into()) }
}

fn place(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(time_s) if (-7200.0..=7200.0).contains(&time_s) => Ok(time_s),
        _ => Err("expected a number of s from -7200 to 7200".into()),
    }
}

fn error(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(degrees) if (0.001..=10.0).contains(&degrees) => Ok(degrees),
        _ => Err("expected a number of degrees from 0.001 to 10".into()),
    }
}
