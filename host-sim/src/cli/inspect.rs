//! `sinew clip inspect`: the content of files.

use std::path::PathBuf;
use std::process::ExitCode;

use sinew_host_util::command::print;

use crate::inspect::Entry;
use clap::ValueEnum;

use super::unit_args::UnitArgs;

/// Show the content of files: motions, characters and rigs.
///
/// For each file it prints the format and the program that wrote it; frames and rate; the unit and the up axis, each
/// with its reason; height and span; the nearest known skeleton and joints that are missing; T-pose, gaps and joint
/// flips; and all joints as a tree.
///
/// If a file cannot be read, the command names it, shows the others, and ends with exit code 1.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The files: BVH, AMC (its ASF beside it), humanoid3d text, glTF, VRM, Geno.bin (a skinned character), URDF, MJCF,
    /// rig.toml.
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,

    #[command(flatten)]
    units: UnitArgs,

    /// Format of the output.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A block of lines for each file.
    Text,
    /// A list of JSON objects.
    Json,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let entries: Vec<Entry> =
        args.files.iter().map(|file| Entry::of(file, args.units.overrides())).collect();
    print(&match args.format {
        Format::Json => serde_json::to_string_pretty(&entries)? + "\n",
        Format::Text => {
            let block =
                |(file, entry): (&PathBuf, &Entry)| format!("{}\n{}", file.display(), entry.text());
            args.files.iter().zip(&entries).map(block).collect::<Vec<_>>().join("\n")
        }
    })?;
    let all_read = entries.iter().all(Entry::is_read);
    Ok(if all_read { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
