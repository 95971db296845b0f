//! `sinew servo watch`: measurements of servos, repeated.

use std::fmt::Write as _;
use std::io::{self, IsTerminal as _};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::bail;
use sinew_host_util::command::{note, print, print_raw, table};
use sinew_servo_tools::rig_servo::of_bus;
use sinew_servo_tools::watch::{State, look};
use sinew_servo_tools::{ScanSettings, ServiceError, Servo, scan};

use super::line::{LineArgs, PortClient, open_rig_servo};
use super::rig::find_rate;
use crate::cli::rig::read;

/// Print measurements of servos repeatedly: position, speed, current or load, supply, temperature, errors.
///
/// On a terminal it prints a table; otherwise it prints a line for each servo. Ctrl-C ends it.
#[derive(Debug, clap::Args)]
pub(super) struct WatchArgs {
    /// Ids of the servos. Default: the servos of the rig; without a rig, the servos that a scan finds with the
    /// protocol and rate of the first one.
    #[arg(value_name = "ID", value_parser = clap::value_parser!(u8).range(0..=252))]
    ids: Vec<u8>,

    /// Rig whose servos are watched, by name.
    #[arg(long, value_name = "RIG", conflicts_with = "ids")]
    rig: Option<PathBuf>,

    /// Name of the rig's bus that is connected to the port. Default: the rig's only bus.
    #[arg(long, value_name = "NAME", requires = "rig")]
    rig_bus: Option<String>,

    /// End after N samples of each servo. Default: at Ctrl-C.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    samples: Option<u64>,

    /// Time between two samples, in ms.
    #[arg(long, value_name = "MS", default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=60_000))]
    interval_ms: u64,
}

/// Prints samples of the servos until the last one or Ctrl-C.
pub(super) fn run(line: &LineArgs, args: &WatchArgs) -> anyhow::Result<ExitCode> {
    let (mut client, servos) = servos(line, args)?;
    let is_terminal = io::stdout().is_terminal();
    let (start, mut lines_above) = (Instant::now(), 0);
    for count in 1.. {
        let begin = Instant::now();
        let states: Vec<_> =
            servos.iter().map(|(name, servo)| (name, servo, look(&mut client, servo))).collect();
        if states.iter().any(|(.., state)| matches!(state, Err(ServiceError::Stopped))) {
            break;
        }
        if is_terminal {
            let text = page(&states);
            // Moves back to the first line and clears the old table.
            let back =
                if lines_above > 0 { format!("\x1b[{lines_above}A\x1b[J") } else { String::new() };
            lines_above = text.lines().count();
            print_raw(&format!("{back}{text}"))?;
        } else {
            print(&lines(start.elapsed(), &states))?;
        }
        // A lost port does not return.
        if let Some((.., Err(ServiceError::Line(error)))) =
            states.into_iter().find(|(.., state)| matches!(state, Err(ServiceError::Line(_))))
        {
            return Err(ServiceError::Line(error).into());
        }
        if args.samples.is_some_and(|most| count >= most) {
            break;
        }
        std::thread::sleep(Duration::from_millis(args.interval_ms).saturating_sub(begin.elapsed()));
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns the servos to watch, with their names.
fn servos(line: &LineArgs, args: &WatchArgs) -> anyhow::Result<(PortClient, Vec<(String, Servo)>)> {
    let of_rig = args.rig.as_deref().map(|path| -> anyhow::Result<_> {
        Ok(of_bus(&read(path)?.description, args.rig_bus.as_deref())?)
    });
    let of_rig = of_rig.transpose()?;
    let mut client = line.client()?;
    let mut servos = Vec::new();
    if let Some(of_rig) = of_rig {
        find_rate(line, &mut client, &of_rig)?;
        for servo in of_rig {
            match open_rig_servo(&mut client, &servo) {
                Ok(found) => servos.push((servo.name, found)),
                Err(error) => note(format_args!("{}: {error}", servo.name)),
            }
        }
    } else if args.ids.is_empty() {
        let settings = ScanSettings {
            protocols: line.protocols(),
            bauds: line.bauds(),
            ..ScanSettings::default()
        };
        note(format_args!("looking for servos; ids on the command line are faster .."));
        let found = scan(&mut client, &settings, &mut |_| {})?;
        let Some(first) = found.first() else { bail!("no servo answers; see `sinew servo scan`") };
        line.find(&mut client, first.id, &[first.protocol])?;
        let place = (client.protocol(), client.baud());
        for other in found.iter().filter(|other| (other.protocol, other.baud) == place) {
            match client.open(other.id, None) {
                Ok(servo) => servos.push((String::new(), servo)),
                Err(error) => note(format_args!("{error}")),
            }
        }
        let left_out = found.len() - servos.len();
        if left_out > 0 {
            note(format_args!("{left_out} servos at other rates are left out"));
        }
    } else {
        for (index, id) in args.ids.iter().enumerate() {
            let found = if index == 0 {
                line.find(&mut client, *id, &line.protocols())?
            } else {
                client.open(*id, None)?
            };
            servos.push((String::new(), found));
        }
    }
    Ok((client, servos))
}

type Look<'a> = (&'a String, &'a Servo, Result<State, ServiceError>);

fn page(states: &[Look<'_>]) -> String {
    let header = ["servo", "id", "position", "speed", "effort", "supply", "heat", ""];
    let mut table = table(header, [1, 2, 3, 4, 5, 6]);
    for (name, servo, state) in states {
        table.add_row(cells(name, servo, state));
    }
    format!("{table}\n")
}

fn lines(elapsed: Duration, states: &[Look<'_>]) -> String {
    let mut out = String::new();
    for (name, servo, state) in states {
        let cells = cells(name, servo, state);
        let cells = cells.iter().filter(|cell| !cell.is_empty());
        let cells: Vec<&str> = cells.map(String::as_str).collect();
        writeln!(out, "{:.3} s  {}", elapsed.as_secs_f64(), cells.join("  "))
            .expect("a string takes everything");
    }
    out
}

fn cells(name: &str, servo: &Servo, state: &Result<State, ServiceError>) -> [String; 8] {
    let (name, id) = (name.to_owned(), servo.id.to_string());
    match state {
        Ok(state) => [
            name,
            id,
            state.position.to_string(),
            state.velocity.to_string(),
            state.effort.to_string(),
            state.voltage.to_string(),
            state.temperature.to_string(),
            state.errors.join(", "),
        ],
        Err(error) => {
            let why = if matches!(error, ServiceError::Silent { .. }) {
                "silent".to_owned()
            } else {
                error.to_string()
            };
            let none = String::new;
            [name, id, none(), none(), none(), none(), none(), why]
        }
    }
}
