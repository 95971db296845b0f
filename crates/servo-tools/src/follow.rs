//! Whether a servo can be where it says that it is.

use std::time::Duration;

use sinew_servo_bus::table::Item;

use crate::quantity::Scale;

/// Beyond its speed a servo that slips, or a reading of before, makes no more than this from one look to the next, deg.
const SLACK_DEG: f64 = 4.0;

/// Positions of a servo, one after the other.
#[derive(Debug, Clone)]
pub(crate) struct Follow {
    scale: Scale,
    most_deg_s: f64,
    /// Counts of a turn, where the seam of an encoder is passed; else none.
    turn: Option<i32>,
    last: Option<(Duration, i32)>,
}

impl Follow {
    /// Follows the register of a position that changes by no more than so many deg/s.
    pub(crate) fn new(present: &Item, most_deg_s: f64) -> Self {
        Self { scale: Scale::of(present), most_deg_s, turn: None, last: None }
    }

    /// Takes the shorter way round, as over the seam of an encoder that counts to so many.
    pub(crate) fn over_seam(self, turn: i32) -> Self {
        Self { turn: Some(turn), ..self }
    }

    /// Takes a position, counts, at a time of the line. Says what is wrong where the servo cannot be there.
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
            "its position changed by {way} within {:.0} ms, which it cannot do: its encoder jumps, or it started anew",
            1e3 * passed_s
        ))
    }
}
