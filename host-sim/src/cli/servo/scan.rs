//! `sinew servo scan` and `ping`: finds servos that answer.

use std::process::ExitCode;

use sinew_host_util::command::{note, print, table};
use sinew_servo_tools::{Found, ScanEvent, ScanSettings, scan};

use super::format::Format;
use super::line::LineArgs;

/// Search for servos at all rates of both protocols, or at those that --protocol and --baud name.
///
/// Exit code 1 if no servo is found.
#[derive(Debug, clap::Args)]
pub(super) struct ScanArgs {
    /// Largest id to search for.
    #[arg(long, value_name = "ID", default_value_t = 252, value_parser = clap::value_parser!(u8).range(0..=252))]
    max_id: u8,

    /// Ask every id at every rate, even where no servo answers a broadcast ping. It takes some minutes.
    #[arg(long)]
    thorough: bool,

    /// Format of the output: a table, or JSON, schema `sinew-servo-scan/1`.
    #[arg(long, value_enum, default_value_t = Format::Words)]
    format: Format,
}

/// Scans; progress goes to standard error.
pub(super) fn run(line: &LineArgs, args: &ScanArgs) -> anyhow::Result<ExitCode> {
    let mut client = line.client()?;
    let settings = ScanSettings {
        protocols: line.protocols(),
        bauds: line.bauds(),
        ids: 0..=args.max_id,
        thorough: args.thorough,
    };
    let found = scan(&mut client, &settings, &mut tell)?;
    print(&match args.format {
        Format::Words => words(&found),
        Format::Json => json(&found)?,
    })?;
    Ok(if found.is_empty() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn tell(event: ScanEvent<'_>) {
    match event {
        ScanEvent::Rate(protocol, baud) => {
            note(format_args!("{} at {baud} baud ..", protocol.name()));
        }
        ScanEvent::NoRate(_, why) => note(format_args!("  left out: {why}")),
        ScanEvent::Found(Found { id, model, model_number, .. }) => match model {
            Some(model) => note(format_args!("  id {id}: {model}")),
            None => note(format_args!("  id {id}: model {model_number}, which is not in the list")),
        },
        ScanEvent::Left(id, left) => note(format_args!("  id {id}: {}", left.what)),
        ScanEvent::Collision(_, _, id) => note(format_args!(
            "  id {id}: the answer is not a valid packet. Do two servos have this id? Connect them one at a time, and \
             use set-id"
        )),
        ScanEvent::Noise(..) => note(format_args!(
            "  bytes arrived that are not a valid packet: another rate or protocol, or a bad cable"
        )),
    }
}

fn words(found: &[Found]) -> String {
    if found.is_empty() {
        return "No servo answers. Is the supply on, and the cable in the right way round? With an adapter that needs \
                it: is its direction set?\n"
            .to_owned();
    }
    let mut table = table(["id", "model", "firmware", "protocol", "baud"], [0, 4]);
    for servo in found {
        let model =
            servo.model.map_or_else(|| format!("? ({})", servo.model_number), str::to_owned);
        table.add_row([
            servo.id.to_string(),
            model,
            servo.firmware.clone(),
            servo.protocol.name().to_owned(),
            servo.baud.to_string(),
        ]);
    }
    format!("{table}\n")
}

fn json(found: &[Found]) -> anyhow::Result<String> {
    #[derive(serde::Serialize)]
    struct Object<'a> {
        schema: &'static str,
        servos: &'a [Found],
    }
    let object = Object { schema: "sinew-servo-scan/1", servos: found };
    Ok(serde_json::to_string_pretty(&object)? + "\n")
}

/// Check whether a servo answers at an id, and print its model.
#[derive(Debug, clap::Args)]
pub(super) struct PingArgs {
    /// Id of the servo.
    #[arg(value_name = "ID", value_parser = clap::value_parser!(u8).range(0..=252))]
    id: u8,
}

/// Asks the servo, and prints its model.
pub(super) fn ping(line: &LineArgs, args: &PingArgs) -> anyhow::Result<ExitCode> {
    let (client, servo) = line.servo(args.id)?;
    print(&format!(
        "servo {}: {}, firmware {}, at {} baud\n",
        servo.id,
        servo.table.model(),
        servo.firmware,
        client.baud()
    ))?;
    Ok(ExitCode::SUCCESS)
}
