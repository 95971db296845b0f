//! Limits of a joint's speed and acceleration at each row, where an effort or another joint needs less than its own.

/// Time around an instant in which a joint becomes calmer together, s.
const AROUND_S: f64 = 0.1;
/// Time around a row whose accelerations are the first limit there, s: without a limit, a joint that becomes calmer at
/// one time would accelerate more beside it.
const FIRST_S: f64 = 0.25;
/// Additional reduction, so that few rounds are needed.
const ZEAL: f64 = 0.97;
/// Smallest speed and acceleration that are asked for, rad/s and rad/s² or m: a search needs some room.
const LEAST: f64 = 1e-4;

/// Speed and acceleration of one joint at the rows of a motion: the largest of its dofs.
pub(super) struct RowSpeeds {
    pub(super) speed: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
}

/// Limits of one joint at each row; empty if the joint has only its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in super::super) struct Caps {
    pub(super) speed: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
}

impl Caps {
    pub(super) fn is_empty(&self) -> bool {
        self.speed.is_empty()
    }

    /// Makes the joint calmer around the rows whose shares are below 1: `shares` of its acceleration, and if
    /// `slower`, the root of these shares of its speed.
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
        // Beside these rows, accelerations may not become larger than they were.
        assert!(near(caps.acceleration[70], 10.0));
    }
}
