//! `sinew clip map`: the mapping of a clip's joints to a rig's.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, anyhow};
use sinew_figure::mapping::{KnownSkeleton, choose, known_skeletons};
use sinew_figure::measured::{Measured, UnitOverrides};
use sinew_host_util::command::{note, print};
use sinew_mocap::files::ClipFile;
use sinew_mocap::{Up, format};
use sinew_performance::{ClipSettings, PreparedClip, propose_mapping};
use sinew_retarget::skeleton::{MapHead, SkeletonMatch, figure_mapping};

use super::rig::read;
use super::unit_args::UnitArgs;

/// Propose which joint of a rig follows which joint of a clip, as TOML to edit, for `--mapping`.
///
/// Comments in the TOML give the confidence of each pair, and its reason. Without `--rig`, the mapping is from any
/// human skeleton to the human figure of 18 bodies. Known skeletons need no mapping: `--list` prints them.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The clip: a BVH, AMC (its ASF beside it) or humanoid3d text file.
    #[arg(value_name = "CLIP", required_unless_present = "list")]
    clip: Option<PathBuf>,

    /// The rig: rig.toml, URDF or MJCF.
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,

    #[command(flatten)]
    units: UnitArgs,

    /// Print the names of the known skeletons. `--mapping NAME` selects one; by default the clip's joints select it.
    #[arg(long, conflicts_with_all = ["clip", "rig", "metres_per_unit", "up"])]
    list: bool,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let text = match (&args.clip, &args.rig) {
        (None, _) => listed(),
        (Some(clip), Some(rig)) => on_rig(clip, rig, args.units.overrides())?,
        (Some(clip), None) => on_figure(clip, args.units.overrides())?,
    };
    print(&text)?;
    Ok(())
}

/// Returns a line for each known skeleton.
fn listed() -> String {
    let line = |known: &KnownSkeleton| format!("{:<16}{}\n", known.mapping.name, known.about);
    known_skeletons().iter().map(line).collect()
}

fn on_rig(clip: &Path, rig: &Path, units: UnitOverrides) -> anyhow::Result<String> {
    let loaded = read(rig)?;
    let settings = ClipSettings { cutoff_hz: None, units };
    let clip = PreparedClip::read(&ClipFile::new(clip), settings)?;
    note(format_args!("note: {}: {}", clip.clip.name, clip.measured));
    let (mapping, of_rig) = propose_mapping(&loaded, &clip)?;
    for left_out in &of_rig.left_out {
        let joint = &loaded.mechanism.bodies[left_out.joint].joint_name;
        note(format_args!("left out: {joint}: {}", left_out.reason));
    }
    tell_lowest(
        mapping.landmarks.iter().map(|entry| {
            (entry.landmark.name().to_owned(), entry.confidence, entry.reason.clone())
        }),
    );
    Ok(mapping.text())
}

fn on_figure(path: &Path, units: UnitOverrides) -> anyhow::Result<String> {
    let file = ClipFile::new(path);
    let recording = format::read(&file.path)?;
    let matched = SkeletonMatch::of_recording(&recording);
    let measured = Measured::new(&recording, &matched, None, units);
    let unit = measured.unit().map_err(|reason| anyhow!("{}: {reason}", path.display()));
    note(format_args!("note: {}: {}", file.name, measured));
    for warning in measured.warnings() {
        note(format_args!("{}: {warning}", file.name));
    }
    if let Ok(known) = choose(&recording.skeleton) {
        let name = &known.name;
        note(format_args!("the skeleton is known as {name}: without --mapping, its own is taken"));
    }
    let metres_per_unit = unit?;
    if recording.frame_time_s.is_none() {
        note(format_args!(
            "note: {}: the file does not state its frame rate: add its rate, such as `rate_hz = 120` for CMU's files",
            file.name
        ));
    }
    let head = MapHead { name: &file.name, metres_per_unit, rate_hz: None };
    let mut proposal = figure_mapping(&recording.skeleton, &matched, head)
        .with_context(|| path.display().to_string())?;
    let axes = [Up::X, Up::Z];
    proposal.map.up = axes.into_iter().find(|up| up.axis() == measured.up.axis);
    for finding in &proposal.findings {
        note(format_args!("note: {finding}"));
    }
    let notes = proposal.notes.iter();
    tell_lowest(notes.map(|note| (note.body.clone(), note.confidence, note.reason.clone())));
    Ok(proposal.to_toml())
}

/// Prints the pair of a proposal with the lowest confidence, which the user should check first.
fn tell_lowest(parts: impl Iterator<Item = (String, f64, String)>) {
    if let Some((name, confidence, reason)) = parts.min_by(|a, b| a.1.total_cmp(&b.1)) {
        note(format_args!("least sure: {name}, {:.0} %: {reason}", 100.0 * confidence));
    }
}
