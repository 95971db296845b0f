//! `sinew map`: which joint follows which.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use sinew_mocap::files::ClipFile;
use sinew_mocap::format;
use sinew_retarget::Landmark;
use sinew_retarget::mapping::Mapping;
use sinew_retarget::performer::Performer;
use sinew_retarget::rig::RigMatch;
use sinew_retarget::skeleton::{MapHead, SkeletonMatch, figure_mapping};
use sinew_retarget::solve::{Settings, best_tilt};
use sinew_sim::command::{note, print};
use sinew_sim::performance::{ClipSettings, PreparedClip};

use super::performance::unit;
use super::rig::read;

/// Propose which joint of a rig follows which joint of a clip, as TOML to edit, for `--mapping`.
///
/// With how sure each is, and why, as comments. Without `--rig`: of the human figure of 18 bodies, for any human
/// skeleton.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The clip: a BVH, AMC (its ASF beside it) or humanoid3d text file.
    #[arg(value_name = "CLIP")]
    clip: PathBuf,

    /// The rig: rig.toml, URDF or MJCF.
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,

    /// Length of the clip's unit in metres, where the file does not tell it. Default: by the body's height.
    #[arg(long, value_name = "M", value_parser = unit, allow_negative_numbers = true)]
    metres_per_unit: Option<f64>,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let text = match &args.rig {
        Some(rig) => on_rig(&args.clip, rig, args.metres_per_unit)?,
        None => on_figure(&args.clip, args.metres_per_unit)?,
    };
    print(&text)?;
    Ok(())
}

fn on_rig(clip: &Path, rig: &Path, metres_per_unit: Option<f64>) -> anyhow::Result<String> {
    let loaded = read(rig)?;
    let settings = ClipSettings { cutoff_hz: None, metres_per_unit };
    let clip = PreparedClip::read(&ClipFile::new(clip), settings)?;
    let mechanism = &loaded.mechanism;
    let of_rig = RigMatch::of(mechanism).with_context(|| loaded.description.name.clone())?;
    let joints = clip.joints();
    let names = [loaded.description.name.as_str(), clip.clip.name.as_str()];
    let of_clip = |landmark: Landmark| {
        let found = clip.matched.get(landmark);
        found.map_or((0.0, "nothing".to_owned()), |found| (found.confidence, found.reason.clone()))
    };
    let skeleton = &clip.clip.skeleton;
    let mut mapping = Mapping::propose(names, mechanism, &of_rig, skeleton, &joints, of_clip);
    if let Ok(performer) = Performer::of(&clip.clip, &joints) {
        mapping.performance.tilt_rad =
            best_tilt(mechanism, &of_rig, &clip.clip, &performer, &Settings::default());
    }
    for left_out in &of_rig.left_out {
        let joint = &mechanism.bodies[left_out.joint].joint_name;
        note(format_args!("left out: {joint}: {}", left_out.reason));
    }
    tell_lowest(
        mapping.landmarks.iter().map(|entry| {
            (entry.landmark.name().to_owned(), entry.confidence, entry.reason.clone())
        }),
    );
    Ok(mapping.text())
}

fn on_figure(path: &Path, given: Option<f64>) -> anyhow::Result<String> {
    let file = ClipFile::new(path);
    let recording = format::read(&file.path)?;
    let matched = SkeletonMatch::of_recording(&recording);
    let guess = matched.unit.as_ref().and_then(|unit| unit.metres_per_unit);
    let Some(metres_per_unit) = given.or(recording.metres_per_unit).or(guess) else {
        let reason = matched
            .unit
            .as_ref()
            .map_or("no arms and legs tell the body's height", |unit| unit.reason.as_str());
        bail!(
            "{}: the unit of length is not known: {reason}; give it with --metres-per-unit",
            path.display()
        );
    };
    let rate_hz = recording.frame_time_s.is_none().then_some(30.0);
    let head = MapHead { name: &file.name, metres_per_unit, rate_hz };
    let proposal = figure_mapping(&recording.skeleton, &matched, head)
        .with_context(|| path.display().to_string())?;
    for finding in &proposal.findings {
        note(format_args!("note: {finding}"));
    }
    let notes = proposal.notes.iter();
    tell_lowest(notes.map(|note| (note.body.clone(), note.confidence, note.reason.clone())));
    Ok(proposal.to_toml())
}

/// Says which part of a proposal is to be looked at first.
fn tell_lowest(parts: impl Iterator<Item = (String, f64, String)>) {
    if let Some((name, confidence, reason)) = parts.min_by(|a, b| a.1.total_cmp(&b.1)) {
        note(format_args!("least sure: {name}, {:.0} %: {reason}", 100.0 * confidence));
    }
}
