//! What goes over all lines in a tick, side by side in simulated time: as on a board with a serial port for each.

use sinew_servo_bus::{EncodeError, ServoBus};
use sinew_servo_sim::bench::Branch;
use sinew_servo_sim::line::{Line, LineDevice as _, run_all};
use sinew_servo_sim::load::Plant;

use super::wires::Wires;

/// Room for the packets of a tick of one line.
const OUT_LEN: usize = 2048;
/// Room for what comes at once.
const IN_LEN: usize = 1024;

/// Packets out and replies in, on each line as long as its bus wants more and the tick, until `end_ns`, has time.
///
/// # Errors
/// [`EncodeError`] if there is no room for a packet: it did not go out, and none behind it.
pub(super) fn exchange<P: Plant>(
    buses: &mut [Box<dyn ServoBus>],
    lines: &mut [Line<Branch<'_, P>>],
    end_ns: u64,
    wires: &mut Wires,
) -> Result<(), EncodeError> {
    let mut out = [0; OUT_LEN];
    // Until when each line waits for its answers; none of a line that wants nothing more.
    let mut waits = Vec::new();
    for (bus, line) in buses.iter_mut().zip(&mut *lines) {
        let asked = bus.plan(&mut out)?;
        waits.push(Some(ask(line, &out[..asked.len], asked.time_us, wires)));
    }
    loop {
        let of_line = |(wait, line): (&Option<u64>, &Line<_>)| {
            wait.map(|until_ns: u64| line.next_ns().map_or(until_ns, |next| next.min(until_ns)))
        };
        let Some(next_ns) = waits.iter().zip(&*lines).filter_map(of_line).min() else { break };
        run_all(lines, next_ns);
        for ((bus, line), wait) in buses.iter_mut().zip(&mut *lines).zip(&mut waits) {
            let Some(until_ns) = *wait else { continue };
            let now_ns = line.servos.now_ns();
            if !has_all(&mut **bus, line, wires) && now_ns < until_ns {
                continue;
            }
            let left_us = u32::try_from(end_ns.saturating_sub(now_ns) / 1000).unwrap_or(u32::MAX);
            let asked = bus.plan_more(left_us, &mut out)?;
            *wait = asked.map(|asked| ask(line, &out[..asked.len], asked.time_us, wires));
        }
    }
    Ok(())
}

/// Sends, and says until when answers are waited for. A master empties its input before.
fn ask<P: Plant>(
    line: &mut Line<Branch<'_, P>>,
    bytes: &[u8],
    time_us: u32,
    wires: &mut Wires,
) -> u64 {
    let mut old = [0; IN_LEN];
    while line.take(&mut old) > 0 {}
    wires.sent(bytes);
    line.write(bytes);
    line.servos.now_ns() + u64::from(time_us) * 1000
}

/// Gives the bus what has come. Whether that is all that it asked for.
fn has_all<P: Plant>(
    bus: &mut dyn ServoBus,
    line: &mut Line<Branch<'_, P>>,
    wires: &mut Wires,
) -> bool {
    if line.is_sending() {
        return false;
    }
    let mut said = [0; IN_LEN];
    loop {
        let len = line.take(&mut said);
        wires.answered(&said[..len]);
        let is_complete = bus.reply(&said[..len]);
        if is_complete || len < IN_LEN {
            return is_complete;
        }
    }
}
