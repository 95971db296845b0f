//! `sinew clip export`: writes a clip, retargeted to a rig, for other programs.

use std::path::{Path, PathBuf};

use anyhow::bail;
use sinew_host_util::command::note;
use sinew_host_util::output;
use sinew_mocap::bvh;
use sinew_retarget::exchange::{blender, clip, servos, table};
use sinew_retarget::feasibility::Curve;

use super::clips::rate;
use super::output::OutputPath;
use super::performance::{FOR_OTHERS, PerformanceArgs};
use super::unit_args::UnitArgs;

/// Retarget a clip to a rig, and write the motion for other programs: CSV, BVH, or JSON.
///
/// CSV: time in s, then for each joint its angle in a column `NAME_deg`, or for a slide its position in `NAME_mm`; the
/// pose of a driven base in m, in a world with z up. BVH: the rig's bodies as a skeleton, in cm. JSON: positions of the
/// servos in the format of the Blender servo animation add-on: encoder steps of bus servos, pulses in us of hobby
/// servos.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The clip: the name of a built-in clip, or a BVH, AMC (its ASF beside it) or humanoid3d text file; or a CSV or
    /// JSON file of the rig's own motion.
    #[arg(value_name = "CLIP")]
    clip: PathBuf,

    /// The rig: rig.toml, URDF or MJCF.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Mapping of the clip's joints to the rig's, in TOML, as `sinew clip map` proposes it. Default: by names and
    /// geometry.
    #[arg(long, value_name = "FILE")]
    mapping: Option<PathBuf>,

    #[command(flatten)]
    on_rig: PerformanceArgs,

    #[command(flatten)]
    units: UnitArgs,

    /// Rate of the exported motion, in frames per second. Default: the clip's own.
    #[arg(long, value_name = "HZ", value_parser = rate, allow_negative_numbers = true)]
    rate_hz: Option<f64>,

    /// File to write: `.csv`, `.bvh` or `.json`.
    #[arg(short, long, value_name = "FILE")]
    output: OutputPath,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let kind = args.output.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    if !["csv", "bvh", "json"].contains(&kind) {
        bail!("{}: expected a name that ends in .csv, .bvh or .json", args.output.display());
    }
    let rig = args.on_rig.rig(&args.rig, FOR_OTHERS)?;
    let mapping = args.mapping.as_deref();
    let performance =
        args.on_rig.perform(&rig, &args.clip, mapping, None, (FOR_OTHERS, args.units))?;
    if let Some(line) = performance.headline(&rig.mechanism) {
        note(format_args!("{line}"));
    }
    if let Some(done) = performance.fit_summary(&rig.mechanism) {
        note(format_args!("fitted: {}", done.trim_end()));
    }
    let resampled;
    let motion = match args.rate_hz {
        Some(rate_hz) => {
            resampled = Curve::new(&rig.mechanism, performance.motion())?.resampled(rate_hz);
            &resampled
        }
        None => performance.motion(),
    };
    let (mechanism, name) = (&rig.mechanism, &performance.name);
    let text = match kind {
        "csv" => table::csv(mechanism, motion, performance.start_s),
        "bvh" => bvh::text(&clip::clip(name, mechanism, motion), 0.01)?,
        _ => {
            let tracks = servos::tracks(&rig.description, mechanism, motion)?;
            for track in tracks.iter().filter(|track| track.limited > 0) {
                note(format_args!(
                    "note: servo {}: held at an end of its range in {} of {} frames",
                    track.servo,
                    track.limited,
                    track.positions.len()
                ));
            }
            blender::write(&rig.description.name, &tracks, motion.dt_s.recip())?
        }
    };
    write(&args.output, &text)
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    output::write(path, text)?;
    note(format_args!("wrote {}", path.display()));
    Ok(())
}
