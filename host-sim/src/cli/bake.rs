//! `sinew bake`: a show for a board.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use sinew_mocap::files::ClipFile;
use sinew_sim::figure::{BodyModel, mapping};
use sinew_sim::pipeline::{self, Settings};
use sinew_sim::{builtin, show};

use super::clips::seconds;
use super::evaluate::scale;
use super::output::{note, print};

/// Bake a clip and the figure that performs it into a file that a board's image reads from its flash.
///
/// `firmware/src/show.rs` describes the format. To build it into the boards' images, set the environment variable
/// `SINEW_SHOW` to the file's path.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A built-in clip's name, or a BVH, AMC or humanoid3d text file.
    #[arg(long, value_name = "CLIP", default_value = "punches_01")]
    clip: String,

    /// Factor on the figure's dimensions, 0.1 to 10. The clip keeps its own.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = scale, allow_negative_numbers = true)]
    scale: f64,

    /// Only the first S seconds.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,

    /// How the clip's skeleton maps on the figure, in TOML. Default: chosen among the known ones.
    #[arg(long, value_name = "FILE")]
    mapping: Option<PathBuf>,

    /// The file to write.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let settings = Settings {
        mapping: args.mapping.as_deref().map(mapping::Mapping::read).transpose()?,
        ..Settings::default()
    };
    let clip = match builtin::clips().into_iter().find(|clip| clip.name == args.clip) {
        Some(clip) => clip,
        None => {
            pipeline::load(&ClipFile::new(Path::new(&args.clip)), &settings).with_context(|| {
                let names: Vec<_> = builtin::clips().into_iter().map(|clip| clip.name).collect();
                format!(
                    "{} is no built-in clip ({}) and no readable file",
                    args.clip,
                    names.join(", ")
                )
            })?
        }
    };
    let (motion, notices) = pipeline::prepare(clip, &settings)?;
    for notice in notices {
        note(format_args!("{}: {notice}", motion.name));
    }
    let model = BodyModel::from_motion(&motion)?.scaled(args.scale);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative, and saturates"
    )]
    let frames = args.seconds.map_or(usize::MAX, |s| (s / motion.dt_s).round().max(1.0) as usize);
    let bytes = show::bake(&motion, &model, frames)?;
    std::fs::write(&args.out, &bytes).with_context(|| format!("{}", args.out.display()))?;
    print(&format!(
        "{}: {} frames of {}, {} bytes\n",
        args.out.display(),
        motion.rotation.len().min(frames),
        motion.name,
        bytes.len()
    ))?;
    Ok(())
}
