//! Chooses the tick rate of a rig's loop: the requested rate, if the lines have time for it, else the highest
//! possible.

use sinew_core::tracker::MAX_DELAY_S;
use sinew_servo_bus::{Schedule, Timing, Traffic};
use thiserror::Error;

/// Rates that are tried in turn if servos are driven by current or voltage, Hz.
const OF_CURRENT: [u32; 5] = [500, 400, 333, 250, 200];
/// Rates that are tried in turn if all servos are driven by position, Hz. The position loop in such a servo has a
/// bandwidth of 2 to 4 Hz.
const OF_POSITION: [u32; 4] = [100, 80, 60, 50];

/// Traffic of a line in a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Load {
    pub(super) timing: Timing,
    pub(super) traffic: Traffic,
    /// Length of the packets that switch torque, bytes.
    pub(super) switch_bytes: u32,
    /// Whether servos of the line are driven by current or voltage: their readings close the loop.
    pub(super) closes_loop: bool,
}

/// Other needs of the controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct Needs {
    pub(super) compute_us: u32,
    pub(super) stale_s: f32,
}

/// Error of a rate that is too high for the lines.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RateError {
    /// The requested rate is too high.
    #[error(
        "--rate-hz {asked_hz}: line {line:?} at {baud} bit/s is too slow for this rate; {fits}"
    )]
    Asked {
        /// The requested rate, Hz.
        asked_hz: u32,
        /// Name of a line that is too slow.
        line: String,
        /// Rate of that line, bit/s.
        baud: u32,
        /// Description of a rate that fits.
        fits: String,
    },
    /// A board needs too much time for computing.
    #[error(
        "by estimate, a board computes {ms:.1} ms per tick for {servos} servos driven by current, and the rest of the \
         tick is too short for line {line:?} even at {slowest_hz} Hz, the lowest rate; `--drive position` needs only \
         50 to 100 Hz"
    )]
    Board {
        /// Computing time per tick, ms.
        ms: f32,
        /// Number of servos.
        servos: u32,
        /// Name of a line for which no time remains.
        line: String,
        /// The slowest rate at which currents close a loop, Hz.
        slowest_hz: u32,
    },
    /// All rates are too high.
    #[error(
        "line {line:?} at {baud} bit/s is too slow for its {servos} servos: choose a higher --baud"
    )]
    None {
        /// Name of a line that is too slow.
        line: String,
        /// Rate of that line, bit/s.
        baud: u32,
        /// Number of servos on the line.
        servos: u32,
    },
}

/// Returns a schedule for each line, at the requested rate or the first rate that fits.
pub(super) fn choose(
    lines: &[(&str, Load)],
    asked_hz: Option<u32>,
    needs: Needs,
) -> Result<(u32, Vec<Schedule>), RateError> {
    let of_current = lines.iter().any(|(_, load)| load.closes_loop);
    let tried: &[u32] = if of_current { &OF_CURRENT } else { &OF_POSITION };
    let fits = |rate_hz: u32| -> Result<Vec<Schedule>, usize> {
        let each = lines.iter().enumerate();
        each.map(|(index, (_, load))| load.fits(rate_hz, needs).ok_or(index)).collect()
    };
    let Some(asked_hz) = asked_hz else {
        let mut slow = 0;
        for rate_hz in tried {
            match fits(*rate_hz) {
                Ok(schedules) => return Ok((*rate_hz, schedules)),
                Err(line) => slow = line,
            }
        }
        let (line, load) = lines[slow];
        let (baud, servos) = (load.timing.baud, load.traffic.servos);
        let slowest_hz = OF_CURRENT[OF_CURRENT.len() - 1];
        if of_current && load.fits(slowest_hz, Needs { compute_us: 0, ..needs }).is_some() {
            let (ms, line) = (needs.compute_us as f32 * 1e-3, line.to_owned());
            return Err(RateError::Board { ms, servos, line, slowest_hz });
        }
        return Err(RateError::None { line: line.to_owned(), baud, servos });
    };
    fits(asked_hz).map(|schedules| (asked_hz, schedules)).map_err(|slow| {
        let (line, load) = lines[slow];
        let fitting = tried.iter().filter(|hz| **hz < asked_hz).find(|hz| fits(**hz).is_ok());
        let fits = match fitting {
            Some(hz) => format!("{hz} Hz is possible"),
            None => "choose a higher --baud".to_owned(),
        };
        RateError::Asked { asked_hz, line: line.to_owned(), baud: load.timing.baud, fits }
    })
}

impl Load {
    fn fits(&self, rate_hz: u32, needs: Needs) -> Option<Schedule> {
        let schedule = Schedule::new(self.timing, &self.traffic, rate_hz).ok()?;
        let busy_us = schedule.busy_us() + self.timing.bytes_us(self.switch_bytes);
        let has_time = busy_us + needs.compute_us <= schedule.tick_us();
        let is_fresh = needs.stale_s * schedule.read_hz() >= 1.0;
        let late_s = (schedule.groups() + 1) as f32 * 1e-6 * schedule.tick_us() as f32;
        let is_in_time = !self.closes_loop || late_s <= MAX_DELAY_S;
        (has_time && is_fresh && is_in_time).then_some(schedule)
    }
}
