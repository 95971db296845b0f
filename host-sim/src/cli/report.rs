//! `sinew report`: a page of a recording of `sinew play` or `sinew console`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, bail};
use sinew_host_util::command::note;
use sinew_host_util::output;
use sinew_performance::play::Recording;
use sinew_report::recording::{Page, cut, duration_s};
use sinew_rig::toml_file;
use sinew_rig::{Description, Mechanism};

use super::output::OutputPath;
use super::rig::read;

/// Make a page of a recording of `sinew play` or `sinew console`: the rig in motion, and plots of each joint.
///
/// The page is one HTML file that any browser opens from disk, without a network. It plots over time each joint's
/// target and measured position, error, torque and the limit that acted on it, and the current of its servo; it lists
/// states and faults, and has a table of all joints.
///
/// If the machine stopped or the disk was full, the recording is cut off. The page then shows the complete part.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Recording of `sinew play --record` or `sinew console --record`.
    #[arg(value_name = "RECORDING.parquet")]
    recording: PathBuf,

    /// The rig that moves: rig.toml, URDF or MJCF. Default: the rig that is stored in the recording.
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,

    /// File to write. Default: beside the recording, with its name and the extension `.html`.
    #[arg(short, long, value_name = "FILE.html")]
    output: Option<OutputPath>,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let out = args.output.as_ref().map(|path| path.to_path_buf());
    let out = out.unwrap_or_else(|| args.recording.with_extension("html"));
    // The default name of the page may be the name of the rig's file.
    let files = [("recording", Some(args.recording.as_path())), ("rig", args.rig.as_deref())];
    output::distinct(&[&out], &files)?;
    let named = || args.recording.display().to_string();
    let recording = Recording::open(&args.recording).with_context(named)?;
    let (rig, mechanism) = rig_of(&recording, &args.recording, args.rig.as_deref())?;
    let page = Page { recording: &recording, rig: &rig, mechanism: &mechanism };
    let html = page.html().with_context(named)?;
    output::write(&out, html)?;
    if !recording.is_whole() {
        note(format_args!("{}: {}", named(), cut(duration_s(&recording)?)));
    }
    note(format_args!("wrote {}", out.display()));
    Ok(ExitCode::SUCCESS)
}

/// Returns the description and the mechanism of a recording's rig. The mechanism is that of `rig` if it is given; the
/// description is the one in the recording if there is one.
pub(super) fn rig_of(
    recording: &Recording,
    path: &Path,
    rig: Option<&Path>,
) -> anyhow::Result<(Description, Mechanism)> {
    let named = || path.display().to_string();
    let kept = kept(recording, path, rig.is_some())?;
    let given = rig.map(read).transpose()?;
    let mechanism = match (&given, &kept) {
        (Some(given), _) => given.mechanism.clone(),
        (None, Some(kept)) => kept.mechanism().with_context(named)?,
        (None, None) => bail!("{}: keeps no rig: give it by --rig", named()),
    };
    let rig = kept.or(given.map(|given| given.description)).context("a rig is kept or given")?;
    Ok((rig, mechanism))
}

/// Returns the rig that is stored in a recording. An unreadable rig is an error only if no other rig is given.
fn kept(recording: &Recording, path: &Path, is_given: bool) -> anyhow::Result<Option<Description>> {
    let Some(text) = recording.note("rig") else { return Ok(None) };
    match toml_file::read(text) {
        Ok(rig) => Ok(Some(rig)),
        Err(_) if is_given => Ok(None),
        Err(why) => Err(why).with_context(|| {
            format!("{}: the rig in it cannot be read: give it by --rig", path.display())
        }),
    }
}
