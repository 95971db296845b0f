//! Pace of a motion: the share of its given speed at each row, and the time that results from it.

use crate::feasibility::low_pass::lower_envelope;

/// Time before and after an instant over which the motion is slowed too, s, so that the accelerations from braking
/// stay small.
const BRAKING_S: f64 = 0.25;

/// Pace of a motion at its rows.
pub(super) struct LimitTrace {
    dt_s: f64,
    /// Share of the given speed at each row.
    pub(super) pace: Vec<f64>,
}

impl LimitTrace {
    pub(super) fn new(dt_s: f64, rows: usize) -> Self {
        Self { dt_s, pace: vec![1.0; rows] }
    }

    /// Returns whether the motion is nowhere slower than given.
    pub(super) fn is_as_given(&self) -> bool {
        self.pace.iter().all(|pace| *pace >= 1.0)
    }

    /// Multiplies the pace of rows from `first` on by these shares, with a smooth transition.
    pub(super) fn slow_down(&mut self, first: usize, shares: &[f64]) {
        lessen(&mut self.pace, first, shares, BRAKING_S / self.dt_s);
    }

    /// Returns the pace at a place after a row, given as part of the step to the next row, and its change in time,
    /// 1/s.
    pub(super) fn pace_at(&self, row: usize, part: f64) -> [f64; 2] {
        let last = self.pace.len() - 1;
        // 1 / pace is linear from row to row.
        let slow = |row: usize| self.pace[row.min(last)].recip();
        let steep = |row: usize| {
            let (before, behind) = (row.saturating_sub(1), (row + 1).min(last));
            (slow(behind) - slow(before)) / ((behind - before) as f64 * self.dt_s)
        };
        let between =
            |of: &dyn Fn(usize) -> f64| of(row) + part * (of((row + 1).min(last)) - of(row));
        let pace = between(&slow).recip();
        [pace, -pace * pace * pace * between(&steep)]
    }

    /// Returns, for each row of the new motion, its time in the given motion, s. The rows of both motions have about
    /// the same spacing. `None` if the pace is unchanged.
    pub(super) fn given_s(&self) -> Option<Vec<f64>> {
        if self.is_as_given() {
            return None;
        }
        // New time at each given row: the integral of 1 / pace, by the trapezoid rule.
        let mut new_s = vec![0.0];
        for pair in self.pace.windows(2) {
            let step = 0.5 * self.dt_s * (pair[0].recip() + pair[1].recip());
            new_s.push(new_s[new_s.len() - 1] + step);
        }
        let end_s = new_s[new_s.len() - 1];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let count = (end_s / self.dt_s).ceil() as usize;
        let last = self.pace.len() - 2;
        let mut row = 0;
        // The rows fill the time exactly, because it is extended by less than one row.
        let given_s = (0..=count).map(|index| {
            let time_s = index as f64 / count as f64 * end_s;
            while row < last && new_s[row + 1] <= time_s {
                row += 1;
            }
            (row as f64 + self.part(row, time_s - new_s[row])) * self.dt_s
        });
        Some(given_s.collect())
    }

    /// Returns the part of the step from a row to the next that is done at a new time after the row. The derivative
    /// of new time, 1 / pace, is linear within the step.
    fn part(&self, row: usize, since_s: f64) -> f64 {
        let [slope, slope_to] = [row, row + 1].map(|row| self.pace[row].recip());
        let rows = since_s / self.dt_s;
        // The root of slope u + (slope_to - slope) u² / 2 = rows, in the form without subtraction.
        let root = libm::sqrt((slope * slope + 2.0 * (slope_to - slope) * rows).max(0.0));
        (2.0 * rows / (slope + root)).clamp(0.0, 1.0)
    }
}

/// Additional reduction in each round, so that few rounds are needed.
const ZEAL: f64 = 0.985;

/// Multiplies values from row `first` on by those shares that are below 1. Over `reach` rows on each side, the
/// factor returns to 1 smoothly.
pub(super) fn lessen(values: &mut [f64], first: usize, shares: &[f64], reach: f64) {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
    let reach = reach.ceil().max(1.0) as usize;
    let end = first + shares.len();
    let is_less = |row: &usize| shares[*row - first] < 1.0;
    let wanted = |row: usize| match shares.get(row.wrapping_sub(first)) {
        Some(share) if *share < 1.0 => share * ZEAL,
        _ => 1.0,
    };
    let beside = 2 * reach + 1;
    let mut from = first;
    // Rows with overlapping envelopes are reduced together.
    while let Some(begin) = (from..end).find(is_less) {
        let mut last = begin;
        while let Some(next) = (last + 1..end.min(last + 1 + beside)).find(is_less) {
            last = next;
        }
        let rows = begin.saturating_sub(beside)..(last + 1 + beside).min(values.len());
        let wanted: Vec<f64> = rows.clone().map(wanted).collect();
        for (value, less) in values[rows].iter_mut().zip(lower_envelope(&wanted, reach)) {
            *value *= less;
        }
        from = last + 1;
    }
}
