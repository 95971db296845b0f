//! Limits of a joint's speed and acceleration at each row. They are lower than the joint's own limits where an effort
//! or another joint requires it.

/// Time before and after an instant in which a joint is reduced together, s.
const AROUND_S: f64 = 0.1;
/// Time before and after a row, s. The largest present acceleration within it is the first limit at the row. Without
/// this limit, a joint that is reduced at one time would accelerate more shortly before or after.
const FIRST_S: f64 = 0.25;
/// Additional reduction in each round, so that few rounds are needed.
const ZEAL: f64 = 0.97;
/// Smallest limit of speed and acceleration, in rad or m per s and per s²: a search needs some room.
const LEAST: f64 = 1e-4;

/// Speed and acceleration of one joint at each row: the largest of its dofs.
pub(super) struct RowSpeeds {
    pub(super) speed: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
}

/// Limits of one joint at each row; empty if only the joint's own limits apply.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in super::super) struct Caps {
    pub(super) speed: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
}

impl Caps {
    pub(super) fn is_empty(&self) -> bool {
        self.speed.is_empty()
    }

    /// Lowers the limits around the rows whose shares are below 1. The acceleration may be `shares` of the present
    /// acceleration; if `slower`, the speed may be the root of these shares of the present speed.
    pub(super) fn calm(&mut self, now: &RowSpeeds, shares: &[f64], slower: bool, dt_s: f64) {
        let count = shares.len();
        let reach = |seconds: f64| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
            let rows = (seconds / dt_s).ceil() as usize;
            rows
        };
        if self.is_empty() {
            let acceleration = largest(&now.acceleration, reach(FIRST_S));
            let acceleration = acceleration.into_iter().map(|most| most.max(LEAST)).collect();
            *self = Self { speed: vec![f64::INFINITY; count], acceleration };
        }
        let around = reach(AROUND_S);
        for (row, share) in shares.iter().enumerate().filter(|(_, share)| **share < 1.0) {
            let rows = row.saturating_sub(around)..(row + around + 1).min(count);
            let lower = |caps: &mut [f64], now: &[f64], share: f64| {
                let most = now[rows.clone()].iter().copied().fold(0.0, f64::max);
                let wanted = (most * share * ZEAL).max(LEAST);
                caps[rows.clone()].iter_mut().for_each(|cap| *cap = cap.min(wanted));
            };
            lower(&mut self.acceleration, &now.acceleration, *share);
            if slower {
                lower(&mut self.speed, &now.speed, libm::sqrt(*share));
            }
        }
    }
}

/// Returns the largest value within `reach` rows on each side of each row.
fn largest(values: &[f64], reach: usize) -> Vec<f64> {
    let of_row = |row: usize| {
        let near = &values[row.saturating_sub(reach)..(row + reach + 1).min(values.len())];
        near.iter().copied().fold(0.0, f64::max)
    };
    (0..values.len()).map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_becomes_calmer_around_a_row_only() {
        let now = RowSpeeds { speed: vec![2.0; 101], acceleration: vec![10.0; 101] };
        let mut shares = vec![1.0; 101];
        shares[50] = 0.25;
        let mut caps = Caps::default();
        caps.calm(&now, &shares, true, 0.01);
        let near = |value: f64, wanted: f64| (value - wanted).abs() < 1e-9;
        assert!(near(caps.acceleration[50], 10.0 * 0.25 * ZEAL));
        assert!(near(caps.speed[60], 2.0 * 0.5 * ZEAL) && caps.speed[61].is_infinite());
        // Around these rows, accelerations must not become larger than before.
        assert!(near(caps.acceleration[70], 10.0));
    }
}
