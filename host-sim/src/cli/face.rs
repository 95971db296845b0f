//! `sinew clip face`: keys of a face's joints from a file of another program.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use sinew_host_util::command::note;
use sinew_host_util::output;
use sinew_life::face::{self, FaceMotion, FaceTrack, JointMeasure, Weights};
use sinew_pose_metrics::character;
use sinew_rig::description::FaceShape;

use super::output::OutputPath;
use super::performance::{ON_STAND, PerformanceArgs};

/// Make keys of a face from mouth cues or blend shapes, by the rig's `[[shape]]` tables.
///
/// Mouth cues: Rhubarb (JSON, TSV, .dat) and Papagayo (.dat, a Moho switch). Blend shapes: the CSV of Live Link Face,
/// or a glTF (.glb, .gltf) with animated shape keys. Cues become visemes with smooth transitions; blend shapes are
/// found in the rig by name. The motion keeps the file's time: if a joint is too slow, its motion is smoothed over 120
/// ms at most, and then made smaller. For each joint the command prints the correlation with the file's motion, and the
/// mean absolute jerk. `sinew bake face.csv --rig RIG` makes a show of the keys.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// File of the face: *.json, *.tsv, *.dat, *.csv, *.glb or *.gltf.
    #[arg(value_name = "FACE")]
    face: PathBuf,

    /// Rig with `[[shape]]` tables: rig.toml.
    #[arg(long, value_name = "RIG")]
    rig: PathBuf,

    /// Frames per second of a file that counts frames. Default: 24 for .dat; for Live Link Face, the rate that its
    /// frame numbers show.
    #[arg(long, value_name = "FPS", value_parser = fps, allow_negative_numbers = true)]
    fps: Option<f64>,

    /// Time by which the motion is moved earlier, in ms, from 0 to 500. It compensates the delay of the servos.
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = super::jaw::lead, allow_negative_numbers = true)]
    lead_ms: f64,

    /// CSV to write.
    #[arg(short, long, value_name = "FILE.csv")]
    output: OutputPath,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let of_file = || args.face.display().to_string();
    let rig = PerformanceArgs::default().rig(&args.rig, ON_STAND)?;
    let shapes = &rig.description.face_shapes;
    let mut weights = read(&args.face, args.fps, shapes)?;
    for time_s in &mut weights.times_s {
        *time_s -= args.lead_ms / 1000.0;
    }
    let motion = face::perform(&rig.mechanism, shapes, &weights).with_context(of_file)?;
    output::write(&args.output, motion.csv())?;
    tell(&of_file(), &motion);
    note(format_args!("wrote {}", args.output.display()));
    Ok(())
}

/// Reads the weights of a face's shapes.
fn read(path: &Path, fps: Option<f64>, shapes: &[FaceShape]) -> anyhow::Result<Weights> {
    let of_file = || path.display().to_string();
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if matches!(extension.to_str(), Some("glb" | "gltf" | "vrm")) {
        let keys = character::shape_keys(path)?;
        if keys.animations > 1 {
            let name = keys.animation.as_deref().unwrap_or("without a name");
            note(format_args!(
                "note: {}: {} animations of shape keys; the first one is read, `{name}`",
                of_file(),
                keys.animations
            ));
        }
        let weights = Weights { names: keys.names, times_s: keys.times_s, rows: keys.rows };
        return weights.checked().with_context(of_file);
    }
    let bytes = sinew_mocap::read::bytes(path).with_context(of_file)?;
    match face::read(&bytes, fps).with_context(of_file)? {
        FaceTrack::Weights(weights) => Ok(weights),
        FaceTrack::Cues(cues, end_s) => {
            let names: Vec<&str> = shapes.iter().map(|shape| shape.name.as_str()).collect();
            Weights::of_cues(&cues, end_s, &names).with_context(of_file)
        }
    }
}

/// Prints which shapes are used and not shown, and the measures of each joint.
fn tell(file: &str, motion: &FaceMotion) {
    let duration_s = (motion.rows.len() - 1) as f64 / face::RATE_HZ;
    note(format_args!("{file}: {duration_s:.2} s; shapes: {}", list(&motion.used)));
    if !motion.not_shown.is_empty() {
        note(format_args!(
            "not shown, as the rig has no pose for them: {}",
            list(&motion.not_shown)
        ));
    }
    if motion.fitted > 0.0 {
        note(format_args!(
            "shapes together leave a range in {:.1} % of the rows, and were fitted",
            100.0 * motion.fitted
        ));
    }
    for joint in motion.joints.iter().filter(|joint| joint.way > 0.0) {
        note(format_args!("{}", line(joint)));
    }
}

fn line(joint: &JointMeasure) -> String {
    let JointMeasure { name, slides, way, speed_share, smoothed_s, share, correlation, jerk } =
        joint;
    let (scale, unit) = if *slides { (1000.0, "mm") } else { (1_f64.to_degrees(), "deg") };
    format!(
        "{name}: {:.1} {unit}, {:.0} % of its speed, smoothed over {:.0} ms, {:.0} % of the way left; correlation {correlation:.3}, \
         mean absolute jerk {:.0} {unit}/s³",
        scale * way,
        100.0 * speed_share,
        1000.0 * smoothed_s,
        100.0 * share,
        scale * jerk,
    )
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

fn fps(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if (1.0..=240.0).contains(&number) => Ok(number),
        _ => Err("expected a number of frames per second from 1 to 240".to_owned()),
    }
}
