//! `sinew faults`: the log of a controller.

use std::process::ExitCode;

use sinew_host_util::command::print;
use sinew_link::message::Command;

use super::{BoardPort, remedy, words::told};

/// Show the faults that a controller keeps, over power loss too: the first since they were cleared, then from the
/// latest back, each with what to do.
///
/// Exit code 1 if there are any. What each means: docs/faults.md.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct FaultsArgs {
    #[command(flatten)]
    board: BoardPort,

    /// Clear those that are latched. Nothing moves by it; it is refused while a condition is still there.
    #[arg(long)]
    clear: bool,
}

/// Prints them, or clears them.
pub(in crate::cli) fn run(args: &FaultsArgs) -> anyhow::Result<ExitCode> {
    let mut board = args.board.open()?;
    let records = board.fault_log()?;
    let mut text = String::new();
    for record in &records {
        text.extend([format!("{}\n", told(record))]);
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
    Ok(if records.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
