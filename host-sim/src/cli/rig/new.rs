//! `sinew rig new`: a rig to start from.

use std::process::ExitCode;

use sinew_rig::{new, toml_file};

use super::files::OutputArgs;

/// Write a rig to start from, with plausible numbers that you replace with your own.
#[derive(Debug, clap::Args)]
#[group(id = "kind", required = true, multiple = false, args = ["arm", "face"])]
pub(super) struct NewArgs {
    /// Write a desk arm with this many revolute joints, 1 to 40, on bus servos.
    #[arg(long, value_name = "JOINTS", value_parser = clap::value_parser!(u8).range(1..=40))]
    arm: Option<u8>,

    /// Write a face without masses: jaw, eyes, lids, brows and neck.
    #[arg(long)]
    face: bool,

    #[command(flatten)]
    target: OutputArgs,
}

/// Writes a new arm or a new face.
pub(super) fn run(args: &NewArgs) -> anyhow::Result<ExitCode> {
    let rig = match args.arm {
        Some(joints) => new::arm(usize::from(joints))?,
        None => new::face(),
    };
    args.target.write(&toml_file::write(&rig))?;
    Ok(ExitCode::SUCCESS)
}
