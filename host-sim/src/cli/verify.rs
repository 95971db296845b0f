//! `sinew evaluate verify`: recomputes golden numbers with the core.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::ensure;
use clap::Args;
use comfy_table::Table;
use sinew_host_util::command::{self, note, print};
use sinew_verification::{Kind, Report, Tally, verify_folder};

/// Recompute the numbers in golden files with the core, and print the core's errors and their limits.
#[derive(Debug, Args)]
pub(super) struct VerifyArgs {
    /// Folder of golden files (*.json).
    folder: PathBuf,
    /// Kinds of golden files to leave out.
    #[arg(long, value_delimiter = ',')]
    skip: Vec<Kind>,
}

/// Prints a line for each quantity. If a quantity exceeds its limit, the result is bad: exit code 1.
///
/// # Errors
/// If a file cannot be computed, or there is no file.
pub(super) fn run(args: &VerifyArgs) -> anyhow::Result<ExitCode> {
    ensure!(
        !args.folder.is_file(),
        "{}: expected a folder of golden files (*.json), found a file",
        args.folder.display()
    );
    let report = verify_folder(&args.folder, &args.skip)?;
    let mut out = String::new();
    writeln!(out, "{}", table(&report))?;
    for (file, kind) in &report.skipped {
        writeln!(out, "skipped {file}: kind {kind}")?;
    }
    let tallies: Vec<_> = report
        .files
        .iter()
        .flat_map(|(file, tallies)| tallies.iter().map(move |tally| (file, tally)))
        .collect();
    let mut failed = 0;
    for (file, tally) in tallies.iter().filter(|(_, tally)| !tally.passed()) {
        writeln!(out, "FAIL {file}, {}: worst at {}", tally.quantity, tally.worst)?;
        failed += 1;
    }
    print(&out)?;
    if failed == 0 {
        return Ok(ExitCode::SUCCESS);
    }
    note(format_args!("{failed} of {} quantities are over their limits", tallies.len()));
    Ok(ExitCode::FAILURE)
}

fn table(report: &Report) -> Table {
    let header = [
        "file",
        "quantity",
        "cases",
        "largest error",
        "of its limit",
        "notices",
        "",
        "relative",
        "",
    ];
    let mut table = command::table(header, 2..=5);
    for (file, tallies) in &report.files {
        for tally in tallies {
            table.add_row(row(file, tally));
        }
    }
    table
}

fn row(file: &str, tally: &Tally) -> [String; 9] {
    let result = if tally.passed() { "ok" } else { "FAIL" };
    [
        file.to_owned(),
        tally.quantity.clone(),
        tally.cases.to_string(),
        format!("{:.1e}", tally.largest_error),
        format!("{:.2}", tally.share),
        format!("{:.1e}", tally.notices),
        tally.unit.to_owned(),
        format!("{:.1e}", tally.notices_relative),
        result.to_owned(),
    ]
}
