//! Exchanges the packets of a tick on all lines, in parallel in simulated time, as on a board with a serial port for
//! each line.

use sinew_servo_bus::{EncodeError, ServoBus};
use sinew_servo_sim::bench::Branch;
use sinew_servo_sim::line::{Line, LineDevice as _, run_all};
use sinew_servo_sim::load::Plant;

use super::wires::Wires;

/// Room for the packets of a tick on one line, bytes.
const OUT_LEN: usize = 2048;
/// Room for bytes that are received at once.
const IN_LEN: usize = 1024;

/// Sends packets and receives replies on each line, until its bus needs nothing more or the tick ends at `end_ns`.
///
/// # Errors
/// [`EncodeError`] if there is no room for a packet: this packet and the following ones were not sent.
pub(super) fn exchange<P: Plant>(
    buses: &mut [Box<dyn ServoBus>],
    lines: &mut [Line<Branch<'_, P>>],
    end_ns: u64,
    wires: &mut Wires,
) -> Result<(), EncodeError> {
    let mut out = [0; OUT_LEN];
    // Time until which each line waits for its answers; `None` for a line that needs nothing more.
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

/// Sends packets, and returns the time until which to wait for answers. As a master does, it first discards old
/// input.
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

/// Gives the received bytes to the bus. Returns whether all requested answers are complete.
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
