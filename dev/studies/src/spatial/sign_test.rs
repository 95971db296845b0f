//! The sign test: whether one item is better than another more often than by chance.

/// Returns the exact probability of a split at least this uneven, of either sign, by chance, if better and worse are
/// equally likely. Ties must be left out before. Returns 1 if there are no cases.
pub(super) fn p(better: usize, worse: usize) -> f64 {
    let count = better + worse;
    let log_half = -(count as f64) * std::f64::consts::LN_2;
    // Binomial coefficients, each computed from the previous one.
    let (mut log_choose, mut tail) = (0.0, 0.0);
    for k in 0..=better.min(worse) {
        tail += libm::exp(log_choose + log_half);
        log_choose += libm::log((count - k) as f64 / (k + 1) as f64);
    }
    (2.0 * tail).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_computed_elsewhere() {
        // scipy.stats.binomtest(k, n).pvalue
        for (better, worse, expected) in [
            (8, 1, 0.039_062_5),
            (1, 8, 0.039_062_5),
            (30, 12, 0.007_915_897_334_896_727),
            (5, 5, 1.0),
            (0, 0, 1.0),
        ] {
            assert!((p(better, worse) - expected).abs() < 1e-12, "{}", p(better, worse));
        }
        assert!((p(2000, 0) / 2.0).abs() < 1e-300, "no overflow");
    }
}
