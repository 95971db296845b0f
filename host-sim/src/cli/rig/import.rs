//! `sinew rig import`: a rig.toml from a URDF or an MJCF file.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context as _;
use sinew_host_util::command::note;
use sinew_performance::rig::load;
use sinew_rig::import::Options;
use sinew_rig::review;
use sinew_rig::toml_file;

use super::files::OutputArgs;
use crate::cli::unit_args::UnitArgs;

/// Write a rig.toml from a URDF or an MJCF file. It reports what it changed, filled in or left out.
#[derive(Debug, clap::Args)]
pub(super) struct ImportArgs {
    /// URDF (with `xacro` expanded) or MJCF.
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Leave out these joints, and all bodies beyond them, to open a closed loop.
    #[arg(long, value_name = "JOINT,..", value_delimiter = ',')]
    cut: Vec<String>,

    /// Import a mechanism with closed loops as the tree of bodies that the file contains. The loops are left open.
    #[arg(long)]
    open_loops: bool,

    /// Replace impossible inertia by the inertia of a ball. A body without inertia becomes a point mass.
    #[arg(long)]
    repair_inertia: bool,

    /// Reverse the axes of these joints. `sinew rig check` names joints whose axis is not the mirror image of the axis
    /// on the other side. Ranges stay as they are.
    #[arg(long, value_name = "JOINT,..", value_delimiter = ',')]
    turn_axis: Vec<String>,

    /// Read the inertia of these bodies in g mm², as CAD programs print it. `sinew rig check` reports such bodies.
    #[arg(long, value_name = "BODY,..", value_delimiter = ',')]
    inertia_g_mm2: Vec<String>,

    #[command(flatten)]
    units: UnitArgs,

    #[command(flatten)]
    target: OutputArgs,
}

/// Reads the file, applies the options and writes the rig.
pub(super) fn run(args: &ImportArgs) -> anyhow::Result<ExitCode> {
    let options = Options {
        cut: args.cut.clone(),
        open_loops: args.open_loops,
        repair_inertia: args.repair_inertia,
        ..args.units.import()
    };
    let mut loaded = load(&args.file, &options)?;
    for name in &args.turn_axis {
        let joint = loaded.description.joints.iter_mut().find(|joint| joint.name == *name);
        let axis = joint.and_then(|joint| joint.axis.as_mut());
        let axis = axis.with_context(|| {
            format!(
                "--turn-axis {name}: {} has no joint of that name with an axis",
                args.file.display()
            )
        })?;
        *axis = axis.map(|x| 0.0 - x);
    }
    // A name that is given twice counts once.
    for name in args.inertia_g_mm2.iter().collect::<BTreeSet<_>>() {
        let body = loaded.description.bodies.iter_mut().find(|body| body.name == *name);
        let inertia = body.and_then(|body| body.inertia_kg_m2.as_mut());
        let inertia = inertia.with_context(|| {
            format!(
                "--inertia-g-mm2 {name}: {} has no body of that name with inertia",
                args.file.display()
            )
        })?;
        *inertia = inertia.scaled(review::KG_M2_PER_G_MM2);
    }
    for line in &loaded.notes {
        note(format_args!("note: {line}"));
    }
    args.target.write(&toml_file::write(&loaded.description))?;
    Ok(ExitCode::SUCCESS)
}
