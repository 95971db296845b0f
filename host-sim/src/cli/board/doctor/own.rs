//! Checks of a board by its own reports.

use std::time::Duration;

use sinew_firmware::node::{RIG_SCHEMA, SETTINGS_SCHEMA, SHOW_SCHEMA};
use sinew_link::message::{
    Cycles, FaultRecord, Health, Item, Location, State, TelemetryParts, Version,
};
use sinew_performance::play::RigParts;

use super::findings::Findings;
use super::findings::Verdict::{Doubtful, Ok as Well, Wrong};
use crate::cli::board::text::fault_text;
use crate::cli::board::{PortBoard, cycles, named, remedy};

/// Time for which telemetry is collected.
const LISTEN: Duration = Duration::from_secs(2);
/// Largest jitter of the tick that is ok, as a share of the period.
const JITTER: f64 = 0.05;
/// Smallest free stack that is ok, bytes.
const STACK: u32 = 1024;
/// Largest difference between the supply and the rig's voltage that is ok, as a share of that voltage.
const SUPPLY: f32 = 0.1;

/// Checks the board. Returns whether packets may be passed on to its servos.
pub(super) fn look(
    board: &mut PortBoard,
    parts: Option<&RigParts>,
    findings: &mut Findings,
) -> anyhow::Result<bool> {
    let about = board.about();
    findings.add(Well, "firmware", &about.firmware.to_string(), "");
    let own = Version::CURRENT;
    findings.expect(
        about.protocol == own,
        Doubtful,
        "link",
        &format!("version {} on the board, {own} here", about.protocol),
        "`sinew board flash` installs the firmware of this release",
    );
    let has_rig = about.rig != 0;
    let rig = if has_rig { format!("{:08x}", about.rig) } else { "none".to_owned() };
    findings.expect(has_rig, Wrong, "rig", &rig, "`sinew board upload rig FILE` stores one");
    if let Some(parts) = parts {
        let is_same = crc(parts) == Some(about.rig);
        let found = if is_same { "is the file's" } else { "is not the file's" };
        findings.expect(
            is_same,
            Wrong,
            "rig",
            found,
            "`sinew board upload rig FILE` stores the file's",
        );
    }
    stored(board, findings)?;
    let mut is_limp = false;
    if has_rig {
        is_limp = state(board, findings)?;
        loop_and_link(board, findings);
        if board.needs(1).is_ok() {
            health(board, parts, findings)?;
        }
    }
    let (warnings, faults): (Vec<_>, Vec<_>) =
        board.fault_log()?.into_iter().partition(FaultRecord::is_warning);
    for warning in &warnings {
        let servo = warning.servo.and_then(|servo| parts?.servos.get(usize::from(servo)));
        let servo = servo.map_or_else(String::new, |servo| format!(" (`{}`)", servo.own.name));
        let found = format!("{}{servo}", fault_text(warning));
        findings.add(Doubtful, "log", &found, &remedy(warning.fault).unwrap_or_default());
    }
    let names: Vec<String> = faults.iter().map(|record| named(record.fault)).collect();
    let found = if names.is_empty() { "none are stored".to_owned() } else { names.join("; ") };
    findings.expect(
        names.is_empty(),
        Doubtful,
        "faults",
        &found,
        "`sinew board faults` says what to do",
    );
    Ok(is_limp && board.needs(1).is_ok())
}

/// Returns the CRC by which a board identifies a rig; `None` if the rig has no compact form.
fn crc(parts: &RigParts) -> Option<u32> {
    let bytes = parts.compact_rig().ok()?;
    bytes.last_chunk().map(|crc| u32::from_le_bytes(*crc))
}

fn stored(board: &mut PortBoard, findings: &mut Findings) -> anyhow::Result<()> {
    let slots = board.about().capacities.slots;
    let places = [
        ("stored rig", Location::Rig, RIG_SCHEMA),
        ("settings", Location::Settings, SETTINGS_SCHEMA),
    ];
    let shows = (0..slots).map(|slot| ("show", Location::Show { slot }, SHOW_SCHEMA));
    for (what, place, schema) in places.into_iter().chain(shows) {
        let Some(Item { schema: found, length, approver, .. }) = board.stored(place)? else {
            continue;
        };
        findings.expect(
            found == schema,
            Wrong,
            what,
            &format!("schema {found}, {length} bytes, by {approver}"),
            &format!("this firmware reads schema {schema}: upload it again"),
        );
    }
    Ok(())
}

fn state(board: &mut PortBoard, findings: &mut Findings) -> anyhow::Result<bool> {
    board.telemetry(10.0, TelemetryParts::ALL)?;
    board.run(LISTEN)?;
    let state = board.fresh_state(LISTEN)?;
    let (verdict, todo) = match state {
        State::Limp => (Well, String::new()),
        State::Off => (
            Doubtful,
            "not every servo has answered: is each powered and plugged, with its id and rate?"
                .to_owned(),
        ),
        State::Faulted => {
            let fault = board.log.summary.and_then(|summary| summary.fault);
            (Wrong, fault.and_then(remedy).unwrap_or_default())
        }
        _ => (Wrong, "the rig is to be limp: disarm it".to_owned()),
    };
    findings.add(verdict, "state", &state.to_string(), &todo);
    Ok(matches!(state, State::Limp | State::Off | State::Faulted))
}

fn loop_and_link(board: &mut PortBoard, findings: &mut Findings) {
    let Some(summary) = board.log.summary else { return };
    findings.expect(
        summary.overruns == 0,
        Doubtful,
        "ticks",
        &format!(
            "{} us on average, {} at most, {} too late",
            summary.tick_us, summary.tick_max_us, summary.overruns
        ),
        "a slower rate (`rate` of the rig's bus), or fewer servos on a line",
    );
    if summary.stack_free > 0 {
        findings.expect(
            summary.stack_free >= STACK,
            Doubtful,
            "stack",
            &format!("{} bytes were never used", summary.stack_free),
            "tell us: this rig nearly fills the board",
        );
    }
    let lost = board.log.lost;
    findings.expect(
        lost == 0 && summary.link_damaged == 0,
        Doubtful,
        "link's frames",
        &format!(
            "{} damaged on the way to the board, {lost} lost on the way back",
            summary.link_damaged
        ),
        "another cable, or no hub between",
    );
    let errors: Vec<String> = (board.log.servos.iter().enumerate())
        .filter(|(_, servo)| servo.bus_errors > 0)
        .map(|(index, servo)| format!("servo {index}: {}", servo.bus_errors))
        .collect();
    let found =
        if errors.is_empty() { "none since power-on".to_owned() } else { errors.join(", ") };
    findings.expect(
        errors.is_empty(),
        Doubtful,
        "bus errors",
        &found,
        "its cable and plug, the supply, the end of the bus",
    );
}

fn health(
    board: &mut PortBoard,
    parts: Option<&RigParts>,
    findings: &mut Findings,
) -> anyhow::Result<()> {
    // Discards the counts of the time before this check.
    cycles::read(board)?;
    board.run(LISTEN)?;
    let Some(health) = cycles::read(board)? else { return Ok(()) };
    let Health { cycles_hz, period, .. } = health;
    let us = |cycles: u32| f64::from(cycles) * 1e6 / f64::from(cycles_hz.max(1));
    if cycles_hz == 0 {
        findings.add(Doubtful, "cycles", "the board does not count cycles", "");
    }
    for (what, cycles) in [("tick", health.tick), ("bus", health.bus), ("link", health.link)] {
        let Cycles { most, count, .. } = cycles;
        if cycles_hz > 0 && count > 0 {
            let is_short = period.count == 0 || what == "link" || most < period.mean;
            findings.expect(
                is_short,
                Wrong,
                &format!("time of {what}"),
                &format!("{:.0} us at most", us(most)),
                "longer than the time between two ticks: a slower rate",
            );
        }
    }
    if cycles_hz > 0 && period.count > 0 {
        let jitter = period.most - period.least;
        findings.expect(
            f64::from(jitter) <= JITTER * f64::from(period.mean),
            Doubtful,
            "period of ticks",
            &format!("{:.1} us on average, jitter {:.1} us", us(period.mean), us(jitter)),
            "something interrupts the loop: tell us, with this file",
        );
    }
    if let Some(spreads) = cycles::spreads(&health) {
        findings.lines += &spreads;
    }
    supply(board, health.supply_least_v, parts, findings);
    Ok(())
}

fn supply(board: &PortBoard, least_v: f32, parts: Option<&RigParts>, findings: &mut Findings) {
    let at_rest = board.log.summary.map_or(0.0, |summary| summary.supply_v);
    let wanted = parts.and_then(RigParts::supply_v);
    let is_near = |v: f32| wanted.is_none_or(|wanted| (v - wanted).abs() <= SUPPLY * wanted);
    let of_rig = wanted.map_or_else(String::new, |v| format!(", the rig's file has {v:.1} V"));
    let todo = "measure it at the last servo; a stronger supply, or thicker and shorter cables";
    match at_rest {
        0.0 => findings.add(Doubtful, "supply at rest", "no servo reports it", "measure it"),
        v => {
            findings.expect(
                is_near(v),
                Wrong,
                "supply at rest",
                &format!("{v:.2} V{of_rig}"),
                todo,
            );
        }
    }
    match least_v {
        0.0 => findings.add(
            Doubtful,
            "supply under load",
            "torque was never on since power-on",
            "play a show, then look again",
        ),
        v => findings.expect(
            is_near(v),
            Doubtful,
            "supply under load",
            &format!("{v:.2} V at the least{of_rig}"),
            todo,
        ),
    }
}
