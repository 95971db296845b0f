//! Converts fault numbers and records to text.

use sinew_board_client::{Board, Line};
use sinew_firmware::supervisor::Fault;
use sinew_host_util::command::note;
use sinew_link::message::FaultRecord;

/// Returns the fault with this number; `None` if this program does not know the number.
fn known(number: u8) -> Option<Fault> {
    Fault::ALL.into_iter().find(|fault| fault.number() == number)
}

/// Returns the text of a fault, or its number if this program does not know it.
pub(in crate::cli) fn named(number: u8) -> String {
    known(number).map_or_else(|| format!("fault {number}"), |fault| fault.to_string())
}

/// Returns the condition of a fault, and its remedy; `None` if this program does not know the number.
pub(in crate::cli) fn remedy(number: u8) -> Option<String> {
    known(number).map(|fault| format!("{}; to do: {}", fault.when(), fault.remedy()))
}

/// Prints the faults that a controller has reported, with their remedies.
pub(in crate::cli) fn tell_faults<L: Line>(board: &Board<L>) {
    let mut numbers: Vec<u8> = board.log.faults.iter().map(|fault| fault.fault).collect();
    numbers.extend(board.log.summary.and_then(|summary| summary.fault));
    numbers.sort_unstable();
    numbers.dedup();
    for number in numbers {
        note(format_args!("{}: {}", named(number), remedy(number).unwrap_or_default()));
    }
    note(format_args!("`sinew board faults --clear` when its cause is removed"));
}

/// Describes a fault record: fault, servo, state, time and count.
pub(super) fn fault_text(record: &FaultRecord) -> String {
    let FaultRecord { fault, state, servo, start, time_us, times } = *record;
    let servo = servo.map_or_else(String::new, |servo| format!(", servo {servo}"));
    let again = if times > 1 { format!(", {times} times") } else { String::new() };
    let time_s = time_us as f64 * 1e-6;
    format!("{}{servo}: while {state}, {time_s:.1} s after start {start}{again}", named(fault))
}
