//! Checks of a board's servos, through the board.

use std::time::Duration;

use sinew_board_client::{BoardServos, SerialBoard};
use sinew_performance::play::{Line, RigParts};
use sinew_servo_sim::rig::RigServo;
use sinew_servo_tools::{Client, Protocol, ServiceError, Settings};

use super::findings::Findings;
use super::findings::Verdict::{Doubtful, Ok as Well, Wrong};
use crate::cli::board::PortBoard;

/// Number of test questions to each servo at its own rate.
const QUESTIONS: u32 = 20;
/// Settings for a single question whose answer must arrive within this time.
const ONCE: Settings = Settings { patience: Duration::from_millis(3), tries: 1 };
/// Longest answer time that is ok. A later answer makes ticks long. A Dynamixel's factory setting delays answers by 0.5
/// ms.
const LATE: Duration = Duration::from_micros(1500);

/// Checks all servos on all bus lines.
pub(super) fn look(
    mut board: PortBoard,
    parts: &RigParts,
    findings: &mut Findings,
) -> anyhow::Result<()> {
    for (index, line) in (0..).zip(&parts.lines) {
        if line.is_of_pulses() {
            let what = format!("bus {:?}", line.name);
            let count = line.servos.len();
            findings.add(
                Well,
                &what,
                &format!("{count} servos driven by pulses: they report nothing"),
                "",
            );
            continue;
        }
        let mut servos = BoardServos::new(board, index)?;
        of_line(&mut servos, parts, line, findings)?;
        board = servos.into_board();
    }
    Ok(())
}

fn of_line(
    servos: &mut BoardServos<SerialBoard>,
    parts: &RigParts,
    line: &Line,
    findings: &mut Findings,
) -> anyhow::Result<()> {
    let protocol = if line.is_dynamixel() { Protocol::Dynamixel } else { Protocol::Feetech };
    let mut client = match Client::new(servos, protocol, line.baud, ONCE) {
        Ok(client) => client,
        Err(error) => {
            findings.add(Wrong, &format!("bus {:?}", line.name), &error.to_string(), "");
            return Ok(());
        }
    };
    let own = || line.servos.iter().map(|servo| &parts.servos[*servo].own);
    let mut missed = 0;
    for servo in own() {
        let id = servo.id().unwrap_or_default();
        let (mut times, mut misses) = (Vec::new(), 0);
        for _ in 0..QUESTIONS {
            match client.read_bytes(id, 0, 2) {
                Ok(_) => times.push(client.line_mut().took()),
                Err(ServiceError::Passing(why)) => return Err(why.into()),
                Err(_) => misses += 1,
            }
            // A silent servo is not asked 20 times.
            if misses > 2 && times.is_empty() {
                break;
            }
        }
        missed += misses;
        let what = format!("servo `{}` (id {id})", servo.name);
        let Some(most) = times.iter().max() else {
            findings.add(
                Wrong,
                &what,
                &format!("does not answer at {} baud", line.baud),
                "is it powered and plugged? `sinew servo scan --board` searches all rates and ids",
            );
            continue;
        };
        let mean = times.iter().sum::<Duration>() / u32::try_from(times.len()).unwrap_or(1);
        findings.expect(
            *most <= LATE && misses == 0,
            Doubtful,
            &what,
            &format!("answers in {mean:.0?}, {most:.0?} at most; {misses} of {QUESTIONS} missed"),
            "`sinew servo apply` sets the return delay; else cable, plug and supply",
        );
    }
    let asked = QUESTIONS * u32::try_from(line.servos.len()).unwrap_or(0);
    findings.expect(
        missed == 0,
        Doubtful,
        &format!("bus {:?} at {} baud", line.name, line.baud),
        &format!("{missed} of {asked} questions missed"),
        "cable, plug and supply; a slower rate",
    );
    for baud in protocol.bauds().into_iter().filter(|baud| *baud != line.baud) {
        let what = format!("bus {:?} at {baud} baud", line.name);
        if client.set_baud(baud).is_err() {
            findings.add(Well, &what, "the board does not support this rate", "");
            continue;
        }
        let ids: Vec<String> = own()
            .filter_map(RigServo::id)
            .filter(|id| client.read_bytes(*id, 0, 2).is_ok())
            .map(|id| id.to_string())
            .collect();
        let found = if ids.is_empty() {
            "silent".to_owned()
        } else {
            format!("id {} answers", ids.join(", "))
        };
        findings.expect(
            ids.is_empty(),
            Wrong,
            &what,
            &found,
            &format!("`sinew servo set-baud ID {}` sets it to the line's rate", line.baud),
        );
    }
    client.into_line().own_rate();
    Ok(())
}
