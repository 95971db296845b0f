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

    /// Take masses without an inertia, or with an impossible one, as points at their centre.
    #[arg(long)]
    point_masses: bool,

    #[command(flatten)]
    target: Target,
}

/// Reads and writes.
pub(super) fn run(args: &ImportArgs) -> anyhow::Result<ExitCode> {
    let options = Options { cut: args.cut.clone(), point_masses: args.point_masses, ..Options::default() };
    let loaded = load(&args.file, &options)?;
    for line in &loaded.notes {
        note(format_args!("note: {line}"));
    }
    args.target.write(&toml_file::write(&loaded.description))?;
    Ok(ExitCode::SUCCESS)
}
