//! `sinew rig view`: a page that shows a rig.

use std::path::PathBuf;
use std::process::ExitCode;

use sinew_performance::rig::review;
use sinew_report::rig::page;

use super::check::LoopArgs;
use super::files::{read_as, write_file};
use crate::cli::output::OutputPath;
use crate::cli::unit_args::UnitArgs;

/// Write a page that shows the rig in 3D: a slider for each joint, its axes, ranges and loads.
///
/// The page is one file that any browser opens from disk, without a network.
#[derive(Debug, clap::Args)]
pub(super) struct ViewArgs {
    /// The rig: rig.toml, URDF or MJCF.
    #[arg(value_name = "RIG")]
    rig: PathBuf,

    #[command(flatten)]
    units: UnitArgs,

    /// Page to write.
    #[arg(short, long, value_name = "FILE.html", default_value = "rig.html")]
    output: OutputPath,

    #[command(flatten)]
    control: LoopArgs,
}

/// Checks the rig and writes the page.
pub(super) fn run(args: &ViewArgs) -> anyhow::Result<ExitCode> {
    let loaded = read_as(&args.rig, &args.units.import())?;
    let review = review(&loaded, args.control.control())?;
    write_file(&args.output, &page(&loaded.description.name, &loaded.mechanism, &review))?;
    Ok(ExitCode::SUCCESS)
}
