//! The rate of a rig's loop: what was asked for, if the lines have time for it, or what they have time for.

use sinew_core::tracker::MAX_DELAY_S;
use sinew_servo_bus::{Schedule, Timing, Traffic};
use thiserror::Error;

/// Rates that are tried in turn where servos take currents or voltages, Hz.
const OF_CURRENT: [u32; 5] = [500, 400, 333, 250, 200];
/// The same where all have positions: servos follow at 2 to 4 Hz by themselves.
const OF_POSITION: [u32; 4] = [100, 80, 60, 50];

/// What a line has to do in a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Load {
    pub(super) timing: Timing,
    pub(super) traffic: Traffic,
    /// Packets that switch torque, bytes.
    pub(super) switch_bytes: u32,
    /// Some of its servos take currents or voltages: their readings close the loop.
    pub(super) closes_loop: bool,
}

/// What the controller needs besides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Needs {
    pub(super) compute_us: u32,
    pub(super) stale_s: f32,
}

/// A rate is too high for the lines.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RateError {
    /// The asked one is.
    #[error("--rate-hz {asked_hz}: line {line:?} at {baud} bit/s has no time for it; {fits}")]
    Asked {
        /// What was asked for.
        asked_hz: u32,
        /// A line that is too slow.
        line: String,
        /// Its rate.
        baud: u32,
        /// What does fit.
        fits: String,
    },
    /// A board computes for too long.
    #[error(
        "by the estimate a board computes {ms:.1} ms a tick for {servos} servos by current, and has no time for line \
         {line:?} besides at {slowest_hz} Hz, the slowest; `--drive position` does with 50 to 100 Hz"
    )]
    Board {
        /// What it computes, ms.
        ms: f32,
        /// For how many servos.
        servos: u32,
        /// A line that there is no time for.
        line: String,
        /// The slowest rate at which currents close a loop, Hz.
        slowest_hz: u32,
    },
    /// All are.
    #[error(
        "line {line:?} at {baud} bit/s is too slow for its {servos} servos: choose a higher --baud"
    )]
    None {
        /// A line that is too slow.
        line: String,
        /// Its rate.
        baud: u32,
        /// How many servos it has.
        servos: u32,
    },
}

/// A schedule for each line, at the rate that was asked for or the first that fits.
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
            Some(hz) => format!("{hz} Hz does fit"),
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
