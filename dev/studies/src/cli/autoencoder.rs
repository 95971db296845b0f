//! `sinew-studies autoencoder`: weights for a loss on joint rotations.

use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::ValueEnum;
use sinew_host_util::command::{ThreadArgs, note, print, with_progress};
use sinew_host_util::output::Folder;
use sinew_pose_metrics::character;
use sinew_pose_metrics::weights::{self, Method, weigh};
use sinew_studies::autoencoder::{self, Plan, Poses, Schedule};
use sinew_studies::pictures::write_study;

use super::data::{DataArgs, count};
use super::results::tell_pictures;

/// Train auto-encoders of poses with five losses, and compare their reconstructions.
///
/// The study repeats D. Holden, "Joint Error Propagation" (2025). A network of two layers encodes the rotations of
/// all joints in a few numbers, and decodes them. Five losses are compared, with all else equal: differences of local
/// rotations; these plus differences of global positions and rotations (forward kinematics); and local differences
/// weighted by joint: by the length of the bones beyond it, by the surface of cylinders around these bones, and by
/// the skin of the character Geno, whose joints are matched by name. No network is trained with poses of the test
/// subjects.
///
/// With `--out`, an interrupted run resumes, and pictures are written.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    data: DataArgs,

    /// Latent units of the networks. Default: 150 and 24, or 12 with `--quick`.
    #[arg(long, value_name = "N,..", value_delimiter = ',', value_parser = count)]
    latent: Vec<NonZeroUsize>,

    /// Train every network with seeds from 1 to N. Default: 3, or 1 with `--quick`.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: Option<u64>,

    /// Steps of every training. Default: 5000, or 40 with `--quick`.
    #[arg(long, value_name = "N", value_parser = count)]
    steps: Option<NonZeroUsize>,

    /// Poses in every step.
    #[arg(long, value_name = "N", default_value = "128", value_parser = count)]
    batch: NonZeroUsize,

    /// Weight of a metre in the forward-kinematics loss, relative to a number of a rotation's two columns.
    #[arg(long, value_name = "FACTOR", default_value = "1.0", value_parser = factor)]
    position_per_m: f64,

    /// Format of the output.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,

    /// Folder for checkpoints, table, JSON and pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Do not measure the time of the steps.
    #[arg(long)]
    no_times: bool,

    #[command(flatten)]
    threads: ThreadArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Tables as text.
    Table,
    /// One JSON object, with the errors of every joint.
    Json,
}

fn factor(text: &str) -> Result<f64, String> {
    let value = text.trim().parse().unwrap_or(f64::NAN);
    if (0.0..=1e6).contains(&value) {
        Ok(value)
    } else {
        Err("expected a number from 0 to 1000000".into())
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let threads = args.threads.install(|| Ok(rayon::current_num_threads()))?;
    let quick = args.data.quick;
    let (poses, character) = match args.data.folder()? {
        Some(data) => read(&data)?,
        None => (Poses::built_in(), None),
    };
    let latents: &[usize] = if quick { &[12] } else { &[150, 24] };
    let plan = Plan {
        poses: &poses,
        character: character.as_deref(),
        latents: if args.latent.is_empty() {
            latents.to_vec()
        } else {
            args.latent.iter().map(|latent| latent.get()).collect()
        },
        seeds: args.seeds.unwrap_or(if quick { 1 } else { 3 }),
        schedule: Schedule {
            steps: args.steps.map_or(if quick { 40 } else { 5_000 }, NonZeroUsize::get),
            batch: args.batch.get(),
            position_per_m: args.position_per_m,
            ..Schedule::default()
        },
        checkpoints: args.out.as_ref().map(|out| out.join("checkpoints")),
        threads,
    };
    // Opened before the work, because its checkpoints belong to one run, too.
    let folder = args.out.as_ref().map(|out| Folder::open(out, "autoencoder", &[])).transpose()?;
    let study = with_progress(plan.steps(), |progress| autoencoder::run(&plan, progress))?;
    let times = if args.no_times { Vec::new() } else { autoencoder::time_steps(&plan)? };
    let table = autoencoder::tables(&plan, &study, &times);
    let json = format!("{:#}\n", autoencoder::json(&plan, &study, &times));
    if let Some(folder) = folder {
        let stage = folder.stage();
        let write = |name: &str, text: &str| fs::write(stage.join(name), text);
        write_study(&study, &poses.skeleton, &stage)
            .and_then(|_| write("autoencoder.txt", &table))
            .and_then(|()| write("autoencoder.json", &json))
            .with_context(|| format!("{}: cannot be written", stage.display()))?;
        tell_pictures(&folder.finish()?);
    }
    print(match args.format {
        Format::Table => &table,
        Format::Json => &json,
    })?;
    Ok(())
}

/// Weights of a character's joints by name.
type Character = Vec<(String, f64)>;

/// Reads the poses of CMU, and the importance of Geno's joints.
fn read(data: &Path) -> anyhow::Result<(Poses, Option<Character>)> {
    let geno = data.join("geno").join("Geno.bin");
    let character = if geno.exists() {
        Some(importance_by_mesh(&geno)?)
    } else {
        note(format_args!("{}: is not there, so there are no weights by a mesh", geno.display()));
        None
    };
    Ok((Poses::cmu(&data.join("cmu"))?, character))
}

fn importance_by_mesh(file: &Path) -> anyhow::Result<Character> {
    let character = character::read(file, &character::Options::default())?;
    let weighing = weigh(&character, Method::Mesh, &weights::Settings::default())?;
    let names = character.joints().iter().map(|joint| joint.name.clone());
    Ok(names.zip(weighing.weights).collect())
}
