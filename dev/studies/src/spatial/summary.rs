//! Summarizes many values in a few numbers.

use serde::Serialize;

/// Mean, spread and quantiles of some values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Summary {
    /// Mean of the values.
    pub mean: f64,
    /// The sample's standard deviation; 0 for one value.
    pub deviation: f64,
    /// Quantiles of 5, 25, 50, 75 and 95 %.
    pub quantiles: [f64; 5],
}

impl Summary {
    /// Summarizes values; `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let last = values.len().checked_sub(1)?;
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let deviation = libm::sqrt(squares / last.max(1) as f64);
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        // Linear between the two nearest values.
        let quantile = |share: f64| {
            let place = share * last as f64;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "from 0 to the last index"
            )]
            let below = (libm::floor(place) as usize).min(last);
            let above = (below + 1).min(last);
            sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
        };
        Some(Self { mean, deviation, quantiles: [0.05, 0.25, 0.5, 0.75, 0.95].map(quantile) })
    }

    /// Formats mean and deviation, in percent.
    pub fn percent(&self) -> String {
        format!("{:.1} ± {:.1}", 100.0 * self.mean, 100.0 * self.deviation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_computed_elsewhere() {
        // numpy: mean, std(ddof=1), quantile.
        let summary = Summary::of(&[0.5, 0.1, 0.4, 0.2]).unwrap();
        assert_eq!(summary.percent(), "30.0 ± 18.3");
        let expected = [0.115, 0.175, 0.3, 0.425, 0.485];
        for (quantile, expected) in summary.quantiles.iter().zip(expected) {
            assert!((quantile - expected).abs() < 1e-12, "{summary:?}");
        }
        assert_eq!(Summary::of(&[0.25]).unwrap().percent(), "25.0 ± 0.0");
        assert_eq!(Summary::of(&[]), None);
    }
}
