//! `sinew board faults`: the fault log of a controller.

use std::process::ExitCode;

use sinew_host_util::command::print;
use sinew_link::message::{Command, FaultRecord};

use super::{BoardPort, remedy, text::fault_text};

/// Print the faults that a board has stored, each with its remedy; or clear the faults.
///
/// A board keeps its faults when power is lost. The first fault since the last clear is printed first, then the others,
/// the latest first. Without --clear, the exit code is 1 if there are faults other than warnings. docs/faults.md
/// explains each fault.
#[derive(Debug, clap::Args)]
pub(super) struct FaultsArgs {
    #[command(flatten)]
    board: BoardPort,

    /// Clear the latched faults. Nothing moves. The board refuses to clear them while the cause of a fault is present.
    #[arg(long)]
    clear: bool,
}

/// Prints the faults, or clears them.
pub(super) fn run(args: &FaultsArgs) -> anyhow::Result<ExitCode> {
    let mut board = args.board.open()?;
    let records = board.fault_log()?;
    let mut text = String::new();
    for record in &records {
        text.extend([format!("{}\n", fault_text(record))]);
        if let Some(remedy) = remedy(record.fault) {
            text.extend([format!("  {remedy}\n")]);
        }
    }
    if records.is_empty() {
        text += "no faults are kept\n";
    }
    print(&text)?;
    if args.clear {
        board.ask(Command::ClearFaults)?;
        print("cleared\n")?;
        return Ok(ExitCode::SUCCESS);
    }
    let is_well = records.iter().all(FaultRecord::is_warning);
    Ok(if is_well { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
