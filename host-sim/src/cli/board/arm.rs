//! Shared by commands that move a rig: checks that the board holds this rig, then arms it.

use std::time::Duration;

use anyhow::{Context as _, bail, ensure};
use sinew_board_client::{Board, ClientError, Line};
use sinew_firmware::supervisor::Fault;
use sinew_host_util::command::note;
use sinew_link::message::{Command, FaultRecord, Refusal, State};
use sinew_performance::play::RigParts;

/// Longest wait for a rig to become ready to be armed.
pub(in crate::cli) const READY: Duration = Duration::from_secs(10);
/// Time between two attempts to arm.
const AGAIN: Duration = Duration::from_millis(100);

/// Checks that the board holds the rig of the file.
pub(in crate::cli) fn check_rig<L: Line>(board: &Board<L>, parts: &RigParts) -> anyhow::Result<()> {
    const HELP: &str = "`sinew board upload rig FILE --port PORT` uploads it";
    let bytes = parts.compact_rig().map_err(anyhow::Error::msg)?;
    let own = bytes.last_chunk().map(|crc| u32::from_le_bytes(*crc)).context("a rig has a CRC")?;
    let here = board.about().rig;
    ensure!(here != 0, "the board has no rig: {HELP}");
    ensure!(here == own, "the board has rig {here:08x}, the file's is {own:08x}: {HELP}");
    Ok(())
}

/// Ends a state in which an ended program may have left the rig: led by hand with torque off. The rig can then be
/// armed.
pub(in crate::cli) fn end_by_hand<L: Line>(
    board: &mut Board<L>,
    state: State,
) -> anyhow::Result<()> {
    note(format_args!("the rig was still {state}, for a program that was ended"));
    board.ask(Command::Stop)?;
    Ok(())
}

/// Clears the faults of a late and a lost link that an ended program has left, if there is no other fault since.
/// Returns whether it did. Warnings do not count.
pub(in crate::cli) fn clear_lost_link<L: Line>(board: &mut Board<L>) -> anyhow::Result<bool> {
    let log = board.fault_log()?;
    let Some(first) = log.first() else { return Ok(false) };
    let is_since = |record: &&FaultRecord| {
        record.start == first.start && record.time_us >= first.time_us && !record.is_warning()
    };
    let of_link = [Fault::LinkLate, Fault::LinkLost].map(Fault::number);
    if !log.iter().filter(is_since).all(|record| of_link.contains(&record.fault)) {
        return Ok(false);
    }
    board.ask(Command::ClearFaults)?;
    note(format_args!(
        "the program before was ended while it drove the rig, and the board lowered the rig: that fault is cleared"
    ));
    Ok(true)
}

/// Asks the board to arm its rig, and returns whether it did. With `waits`, returns `false` if the board refuses for a
/// reason that may pass by itself; every other refusal is an error.
pub(in crate::cli) fn arm<L: Line>(board: &mut Board<L>, waits: bool) -> anyhow::Result<bool> {
    match board.ask(Command::Arm) {
        Err(ClientError::Refused(
            Refusal::Moving { .. }
            | Refusal::RegistersUnread
            | Refusal::NotMeasured
            | Refusal::StopUntested
            | Refusal::Busy,
        )) if waits => {
            board.run(AGAIN)?;
            Ok(false)
        }
        Err(ClientError::Refused(why)) => bail!("the controller refused to arm: {why}"),
        armed => {
            armed?;
            Ok(true)
        }
    }
}
