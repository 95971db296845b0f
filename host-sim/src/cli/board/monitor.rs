//! `sinew board monitor`: prints the state of a controller's rig, even while another command drives the rig.

use std::process::ExitCode;
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context as _, ensure};
use sinew_board_client::ClientError;
use sinew_console::local::{Role, Watching, consoles, name_of_port, roles, watch};
use sinew_console::{Hosted, Owner, Scene};
use sinew_host_util::command::{note, print};
use sinew_link::message::{FaultRecord, Servo, State, Summary, TelemetryParts};

use super::text::fault_text;
use super::{BoardPort, cycles, named};
use crate::cli::stop::Stop;

/// Longest wait for a message of the board.
const LOOK: Duration = Duration::from_millis(50);
/// Longest wait until a command that has asked for the port opens it, and interval between two looks.
const OPENS: Duration = Duration::from_secs(4);
const AGAIN: Duration = Duration::from_millis(100);

/// Print the state of a board's rig: state, fault, supply, tick, bus errors, temperature.
///
/// Nothing moves. The command prints a line at each change of the state and in every interval, until Ctrl-C. It also
/// watches a rig while `sinew play`, `record` or `console` of this user drives it. At the end it prints a table of
/// durations, unless another command then uses the board: of ticks, of exchanges with the servos, of the host link, and
/// from one tick to the next.
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
    let stop = Stop::new()?;
    let mut monitor = Monitor { args, stop: &stop, state: None, due: Instant::now(), lines: 0 };
    // Time when this command lost the port. For `OPENS`, the port belongs to the command that has asked for it.
    let mut given_up: Option<Instant> = None;
    while !monitor.is_over() {
        let hub = args.hub();
        let waits = given_up.is_some_and(|at| at.elapsed() < OPENS);
        if let Some(name) = &hub {
            if let Ok(watching) = watch(name) {
                monitor.watch(name, watching)?;
                given_up = Some(Instant::now());
            }
            if args.board.path().is_none() {
                break;
            }
        } else if waits {
            sleep(AGAIN);
        } else {
            match monitor.own() {
                Ok(true) => given_up = Some(Instant::now()),
                Ok(false) => break,
                // Another program has the port for a moment.
                Err(error) if given_up.is_some() && is_of_port(&error) => sleep(AGAIN),
                Err(error) => return Err(error),
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn is_of_port(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(ClientError::Port(_)))
}

impl MonitorArgs {
    /// Returns the name of the hub that uses the board. Without a port, returns the name of the only hub of a board, if
    /// there is exactly one.
    fn hub(&self) -> Option<String> {
        let mut names = consoles();
        if let Some(port) = self.board.path() {
            return Some(name_of_port(port)).filter(|name| names.contains(name));
        }
        let mut roles = roles(&names).into_iter();
        names.retain(|_| roles.next().flatten() != Some(Role::Simulates));
        names.pop().filter(|_| names.is_empty())
    }
}

/// State of the output: the state that was printed last, the time of the next line, and the number of lines.
struct Monitor<'a> {
    args: &'a MonitorArgs,
    stop: &'a Stop,
    state: Option<State>,
    due: Instant,
    lines: u32,
}

impl Monitor<'_> {
    fn is_over(&self) -> bool {
        self.stop.times() > 0 || self.args.samples.is_some_and(|most| self.lines >= most)
    }

    /// Prints the rig's state, which the hub sends, until the hub ends.
    fn watch(&mut self, name: &str, mut watching: Watching) -> anyhow::Result<()> {
        note(format_args!("another command has the board: watching {name}"));
        while !self.is_over() {
            match watching.next(LOOK) {
                Ok(Some(view)) => self.tell(&view.summary, &view.servos, &view.faults)?,
                Ok(None) => {}
                Err(_) => {
                    note(format_args!("the command that had the board has ended"));
                    break;
                }
            }
        }
        Ok(())
    }

    /// Opens a free port and prints the rig's state. Returns whether another command has asked for the port.
    fn own(&mut self) -> anyhow::Result<bool> {
        let (mut board, name) = self.args.board.open_named()?;
        let about = board.about();
        note(format_args!("firmware {}, rig {:08x}", about.firmware, about.rig));
        ensure!(
            about.rig != 0,
            "the board has no rig, so it has nothing to report: `sinew board upload rig` uploads one"
        );
        let scene = Scene::empty();
        let mut hosted = Hosted::open(&mut board, &scene, Owner::Watches, Some(&name))
            .context("the socket for other commands")?;
        hosted.board_mut().telemetry(10.0, TelemetryParts::SUMMARY.and(TelemetryParts::SERVOS))?;
        // Discards the counts of the time before this command.
        let board = hosted.board_mut();
        let counts = board.needs(1).is_ok() && cycles::read(board)?.is_some();
        let mut faults = 0;
        while !self.is_over() && !hosted.yields() {
            hosted.step(LOOK)?;
            let log = &hosted.board().log;
            if let Some(summary) = &log.summary {
                self.tell(summary, &log.servos, log.faults.get(faults..).unwrap_or_default())?;
                faults = log.faults.len();
            }
        }
        if hosted.yields() {
            return Ok(true);
        }
        if counts
            && let Some(spreads) =
                cycles::read(hosted.board_mut())?.as_ref().and_then(cycles::spreads)
        {
            print(&spreads)?;
        }
        Ok(false)
    }

    /// Prints new faults, and a line if it is due.
    fn tell(
        &mut self,
        summary: &Summary,
        servos: &[Servo],
        faults: &[FaultRecord],
    ) -> anyhow::Result<()> {
        for fault in faults {
            print(&format!("{}\n", fault_text(fault)))?;
        }
        let is_new = self.state.replace(summary.state) != Some(summary.state);
        if is_new || Instant::now() >= self.due {
            self.due = Instant::now() + Duration::from_millis(self.args.interval_ms);
            self.lines += 1;
            print(&line(summary, servos))?;
        }
        Ok(())
    }
}

/// Formats a summary as a line.
fn line(summary: &Summary, servos: &[Servo]) -> String {
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
