//! Low-passes and envelopes of evenly spaced numbers.

/// Applies a Gaussian low-pass of `sigma` rows; the first and last values continue beyond the ends.
///
/// Every result is a weighted mean with weights that are not negative, therefore it is within the range of the
/// values.
pub(super) fn low_pass(values: &[f64], sigma: f64) -> Vec<f64> {
    let weights = gaussian(sigma);
    let (reach, last) = (weights.len() - 1, values.len() - 1);
    let of_row = |row: usize| {
        let mut sum = weights[0] * values[row];
        for (away, weight) in weights.iter().enumerate().skip(1) {
            sum += weight * (values[row.saturating_sub(away)] + values[(row + away).min(last)]);
        }
        sum
    };
    if reach == 0 { values.to_vec() } else { (0..=last).map(of_row).collect() }
}

/// Returns a smooth curve that is nowhere above the values: the minimum within `reach` rows on each side, then a
/// low-pass with that reach.
pub(super) fn lower_envelope(values: &[f64], reach: usize) -> Vec<f64> {
    let last = values.len() - 1;
    let least: Vec<f64> = (0..=last)
        .map(|row| {
            let near = &values[row.saturating_sub(reach)..=(row + reach).min(last)];
            near.iter().copied().fold(f64::INFINITY, f64::min)
        })
        .collect();
    // The weights end at three sigma.
    low_pass(&least, reach as f64 / 3.0)
}

/// Returns the weights of the middle and of one side, up to three sigma. With both sides, their sum is 1.
fn gaussian(sigma: f64) -> Vec<f64> {
    if sigma <= 0.0 {
        return vec![1.0];
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "above zero")]
    let reach = (3.0 * sigma).floor() as usize;
    let mut weights: Vec<f64> = (0..=reach)
        .map(|away| {
            let x = away as f64 / sigma;
            libm::exp(-0.5 * x * x)
        })
        .collect();
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    for weight in &mut weights {
        *weight /= sum;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_is_smooth_and_nowhere_above() {
        let values: Vec<f64> =
            (0..200).map(|k| if (90..95).contains(&k) { 0.3 } else { 1.0 }).collect();
        let envelope = lower_envelope(&values, 20);
        assert!(envelope.iter().zip(&values).all(|(low, value)| *low <= value + 1e-12));
        let steepest = envelope.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        assert!(steepest < 0.06, "{steepest}");
        assert!((envelope[0] - 1.0).abs() < 1e-12 && (envelope[92] - 0.3).abs() < 1e-12);
    }
}
