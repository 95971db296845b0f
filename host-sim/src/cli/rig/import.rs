//! `sinew rig import`: a rig.toml from a URDF or an MJCF file.

use std::path::PathBuf;
use std::process::ExitCode;

use sinew_rig::import::Options;
use sinew_rig::toml_file;
use sinew_sim::command::note;
use sinew_sim::rig::load;

use super::Target;

/// Write a rig.toml from a URDF or an MJCF file. It says what it changed, filled in or left out.
#[derive(Debug, clap::Args)]
pub(super) struct ImportArgs {
    /// URDF (with `xacro` expanded) or MJCF.
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Leave out these joints, with what hangs on them: so a closed loop is cut open.
    #[arg(long, value_name = "JOINT,..", value_delimiter = ',')]
    cut: Vec<String>,

    /// Take a mechanism with closed loops as the tree that the file holds: the loops stay open.
    #[arg(long)]
    open_loops: bool,

    /// Replace inertia that no body can have by a ball's, and inertia that is missing by a point's.
    #[arg(long)]
    repair_inertia: bool,

    #[command(flatten)]
    target: Target,
}

/// Reads and writes.
pub(super) fn run(args: &ImportArgs) -> anyhow::Result<ExitCode> {
    let options = Options {
        cut: args.cut.clone(),
        open_loops: args.open_loops,
        repair_inertia: args.repair_inertia,
    };
    let loaded = load(&args.file, &options)?;
    for line in &loaded.notes {
        note(format_args!("note: {line}"));
    }
    args.target.write(&toml_file::write(&loaded.description))?;
    Ok(ExitCode::SUCCESS)
}
