//! `sinew board doctor`: checks a board while its rig is limp.

mod bus;
mod findings;
mod own;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context as _;
use sinew_host_util::command::{note, print};
use sinew_performance::play::RigParts;

use self::findings::Findings;
use super::BoardPort;
use crate::cli::driven::DrivenArgs;
use crate::cli::output::OutputPath;
use crate::cli::rig::read;

/// Check a board while its rig is limp, and write a report that you can send.
///
/// It checks versions, faults, the duration of ticks, host link and supply; with --rig also the answers of each servo,
/// at each baud rate. Nothing moves. Each line of the report says ok, doubtful or wrong, and gives the remedy. The exit
/// code is 1 if anything is wrong.
#[derive(Debug, clap::Args)]
pub(super) struct DoctorArgs {
    #[command(flatten)]
    board: BoardPort,

    /// Rig on the board: rig.toml, URDF or MJCF. With it, the command also checks the rig's servos.
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,

    #[command(flatten)]
    driven: DrivenArgs,

    /// File to write the report to.
    #[arg(short, long, value_name = "FILE", default_value = "sinew-doctor.txt")]
    output: OutputPath,
}

/// Checks the board, prints the report and writes it.
pub(super) fn run(args: &DoctorArgs) -> anyhow::Result<ExitCode> {
    let rig = args.rig.as_deref().map(read).transpose()?;
    let parts = rig.as_ref().map(|rig| {
        let parts = RigParts::new(&rig.description, &rig.mechanism, args.driven.on_board());
        parts.with_context(|| rig.description.name.clone())
    });
    let parts = parts.transpose()?;
    let mut board = args.board.open()?;
    let mut findings = Findings::default();
    let passes = own::look(&mut board, parts.as_ref(), &mut findings)?;
    match &parts {
        Some(parts) if passes => bus::look(board, parts, &mut findings)?,
        Some(_) => {}
        None => {
            findings.lines += "          servos were not checked: --rig RIG names them\n";
        }
    }
    let head = format!("sinew {} doctor\n", env!("CARGO_PKG_VERSION"));
    print(&findings.lines)?;
    sinew_host_util::output::write(&args.output, &(head + &findings.lines))?;
    note(format_args!("wrote {}", args.output.display()));
    Ok(if findings.is_wrong { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
