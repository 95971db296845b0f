//! `sinew board monitor`: prints the state of a controller's rig.

use std::process::ExitCode;
use std::time::Duration;

use anyhow::ensure;
use sinew_host_util::command::{note, print};
use sinew_link::message::{Summary, TelemetryParts};

use super::{BoardPort, cycles, named};
use crate::cli::stop::Stop;

/// Print the state of a board's rig: state, fault, supply, duration of a tick, bus errors, temperature.
///
/// Nothing moves. It prints a line at each change of the state and one in every interval, until Ctrl-C. At the end it
/// prints a table of durations: of ticks, of exchanges with the servos, of the host link, and from one tick to the
/// next.
#[derive(Debug, clap::Args)]
pub(super) struct MonitorArgs {
    #[command(flatten)]
    board: BoardPort,

    /// Time between two lines, in ms.
    #[arg(long, value_name = "MS", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(50..=3_600_000))]
    interval_ms: u64,

    /// End after N lines. Default: at Ctrl-C.
    #[arg(long, value_name = "N")]
    samples: Option<u32>,
}

/// Prints until Ctrl-C or the last sample.
pub(super) fn run(args: &MonitorArgs) -> anyhow::Result<ExitCode> {
    let mut board = args.board.open()?;
    let stop = Stop::new()?;
    let about = board.about();
    note(format_args!("firmware {}, rig {:08x}", about.firmware, about.rig));
    ensure!(
        about.rig != 0,
        "the board has no rig, so it has nothing to report: `sinew board upload rig` uploads one"
    );
    board.telemetry(10.0, TelemetryParts::SUMMARY.and(TelemetryParts::SERVOS))?;
    // Discards the counts of the time before this command.
    let counts = board.needs(1).is_ok() && cycles::read(&mut board)?.is_some();
    let (mut due, mut state, mut lines, mut faults) = (board.now(), None, 0, 0);
    while stop.times() == 0 && args.samples.is_none_or(|most| lines < most) {
        board.step(Duration::from_millis(50))?;
        for fault in board.log.faults.iter().skip(faults) {
            print(&format!("{}\n", super::text::fault_text(fault)))?;
        }
        faults = board.log.faults.len();
        let Some(summary) = board.log.summary else { continue };
        if state.replace(summary.state) == Some(summary.state) && board.now() < due {
            continue;
        }
        due = board.now() + Duration::from_millis(args.interval_ms);
        lines += 1;
        print(&line(&summary, &board.log.servos))?;
    }
    if counts && let Some(spreads) = cycles::read(&mut board)?.as_ref().and_then(cycles::spreads) {
        print(&spreads)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Formats a summary as a line.
fn line(summary: &Summary, servos: &[sinew_link::message::Servo]) -> String {
    let errors: u32 = servos.iter().map(|servo| u32::from(servo.bus_errors)).sum();
    let hottest = servos.iter().filter_map(|servo| servo.temperature_c).max();
    let hottest = hottest.map_or_else(String::new, |c| format!(", hottest {c} C"));
    let fault = summary.fault.map_or_else(String::new, |fault| format!(", {}", named(fault)));
    let supply = match summary.supply_v {
        0.0 => String::new(),
        v => format!(", supply {v:.2} V"),
    };
    let following = summary.errors.map_or_else(String::new, |errors| {
        format!(", error {:.2} deg at most", errors.largest_deg)
    });
    format!(
        "{}{fault}{supply}{hottest}, tick {} us ({} at most, {} late), {errors} bus errors{following}\n",
        summary.state, summary.tick_us, summary.tick_max_us, summary.overruns
    )
}
