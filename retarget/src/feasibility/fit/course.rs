//! How fast a motion goes: the share of its given speed at each of its rows, and the time that makes of it.

use crate::feasibility::low_pass::lower_envelope;

/// How long before and after an instant the course is slower too, s: what comes of braking itself stays small.
const BRAKING_S: f64 = 0.25;

/// How fast a motion goes.
pub(super) struct Course {
    dt_s: f64,
    /// Share of the given speed at each row.
    pub(super) pace: Vec<f64>,
}

impl Course {
    pub(super) fn new(dt_s: f64, rows: usize) -> Self {
        Self { dt_s, pace: vec![1.0; rows] }
    }

    /// Goes at these shares of its present speed, and smoothly in between.
    pub(super) fn slow_down(&mut self, shares: &[f64]) {
        self.pace = smoothly_less(&self.pace, shares, BRAKING_S / self.dt_s);
    }

    /// The given time of each row of the new motion, whose rows are as far apart; `None` if it goes as given.
    pub(super) fn given_s(&self) -> Option<Vec<f64>> {
        if self.pace.iter().all(|pace| *pace >= 1.0) {
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
        // The rows fill the time: it is longer by less than one of them.
        let at = |row: usize| self.given_at(&new_s, row as f64 / count as f64 * end_s);
        Some((0..=count).map(at).collect())
    }

    /// The given time of a new one: between two rows the new time is a cubic with the slopes 1 / pace.
    fn given_at(&self, new_s: &[f64], time_s: f64) -> f64 {
        let last = new_s.len() - 2;
        let row = new_s.partition_point(|new| *new <= time_s).saturating_sub(1).min(last);
        let [from, to] = [new_s[row], new_s[row + 1]];
        let [slope, slope_to] = [row, row + 1].map(|row| self.dt_s / self.pace[row]);
        let at = |u: f64| {
            let v = 1.0 - u;
            from * v * v * (1.0 + 2.0 * u)
                + to * u * u * (1.0 + 2.0 * v)
                + u * v * (slope * v - slope_to * u)
        };
        let (mut low, mut high) = (0.0, 1.0);
        // To the last bits of the share.
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if at(middle) < time_s { low = middle } else { high = middle }
        }
        (row as f64 + 0.5 * (low + high)) * self.dt_s
    }
}

/// By how much more than asked each round goes down, so that there are few.
const ZEAL: f64 = 0.985;

/// Values times shares, where those are below 1, under an envelope that is smooth over `reach` rows.
pub(super) fn smoothly_less(values: &[f64], shares: &[f64], reach: f64) -> Vec<f64> {
    if shares.iter().all(|share| *share >= 1.0) {
        return values.to_vec();
    }
    let wanted: Vec<f64> = values
        .iter()
        .zip(shares)
        .map(|(value, share)| if *share < 1.0 { value * share * ZEAL } else { *value })
        .collect();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
    let reach = reach.ceil().max(1.0) as usize;
    let envelope = lower_envelope(&wanted, reach);
    values.iter().zip(envelope).map(|(value, envelope)| value.min(envelope)).collect()
}
