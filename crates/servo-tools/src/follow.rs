//! Checks whether the reported positions of a servo are possible.

use std::time::Duration;

use sinew_servo_bus::table::Item;

use crate::quantity::Scale;

/// Tolerance for the change between two readings beyond the servo's speed, deg: for a servo that slips, or an old
/// reading.
const SLACK_DEG: f64 = 4.0;

/// The check of a servo's successive positions.
#[derive(Debug, Clone)]
pub(crate) struct Follow {
    scale: Scale,
    most_deg_s: f64,
    /// Counts of a turn, if the seam of the encoder may be passed.
    turn: Option<i32>,
    last: Option<(Duration, i32)>,
}

impl Follow {
    /// Creates a check for a position register that changes by at most `most_deg_s`, deg/s.
    pub(crate) fn new(present: &Item, most_deg_s: f64) -> Self {
        Self { scale: Scale::of(present), most_deg_s, turn: None, last: None }
    }

    /// Allows the seam of an encoder to be passed: counts the shorter way round, for a turn of `turn` counts.
    pub(crate) fn over_seam(self, turn: i32) -> Self {
        Self { turn: Some(turn), ..self }
    }

    /// Checks a position, in counts, at a time of the line. Returns an explanation if the servo cannot be there.
    pub(crate) fn take(&mut self, now: Duration, counts: i32) -> Result<(), String> {
        let Some((time, before)) = self.last.replace((now, counts)) else { return Ok(()) };
        let passed_s = now.saturating_sub(time).as_secs_f64();
        let way = counts - before;
        let way = self.turn.map_or(way, |turn| (way + turn / 2).rem_euclid(turn) - turn / 2);
        let way = self.scale.quantity(way);
        if way.value.abs() <= self.most_deg_s * passed_s + SLACK_DEG {
            return Ok(());
        }
        Err(format!(
            "its position changed by {way} within {:.0} ms, which is impossible: its encoder jumps, or it restarted",
            1e3 * passed_s
        ))
    }
}
