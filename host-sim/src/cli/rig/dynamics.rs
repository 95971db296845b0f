//! `sinew rig dynamics`: torques for given motions.

use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

use sinew_host_util::command::print;
use sinew_performance::rig::{dof_names, inverse_dynamics};

use super::files::read_as;
use crate::cli::unit_args::UnitArgs;

/// Compute the efforts that given motions need: CSV from standard input, CSV to standard output.
///
/// Columns in: q.NAME, qd.NAME, qdd.NAME in any order (in rad or m, per s, per s²; the base
/// is at rest). Ball joints have q.NAME.x, .y, .z, .w and qd.NAME.0, .1, .2. Columns out:
/// tau.NAME, in N m or N. Without any qd or qdd column these values are zero.
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct DynamicsArgs {
    /// The rig: rig.toml, URDF or MJCF.
    #[arg(value_name = "RIG")]
    rig: PathBuf,

    #[command(flatten)]
    units: UnitArgs,

    /// Include the rotors' inertias, reflected through their gears.
    #[arg(long)]
    rotor: bool,

    /// Print only the names of the dofs, comma-separated.
    #[arg(long)]
    header: bool,
}

/// Computes the efforts, or only the header, and prints them.
pub(super) fn run(args: &DynamicsArgs) -> anyhow::Result<ExitCode> {
    let loaded = read_as(&args.rig, &args.units.import())?;
    if args.header {
        print(&format!("{}\n", dof_names(&loaded.mechanism).join(",")))?;
    } else {
        print(&inverse_dynamics(&loaded.mechanism, args.rotor, io::stdin().lock())?)?;
    }
    Ok(ExitCode::SUCCESS)
}
