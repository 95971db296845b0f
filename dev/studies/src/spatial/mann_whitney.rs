//! The rank test of Mann and Whitney: whether one sample's values tend to be larger than another's.

/// Result of the test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MannWhitney {
    /// Number of pairs in which the first sample's value is larger; ties count half.
    pub u: f64,
    /// Standard score of `u`, corrected for ties and for continuity.
    pub z: f64,
    /// Probability that a difference at least this large, of either sign, occurs by chance, from the normal
    /// distribution.
    pub p: f64,
}

/// Tests two samples of finite numbers; `None` if one is empty or all numbers are equal.
pub fn test(first: &[f64], second: &[f64]) -> Option<MannWhitney> {
    let (n, m) = (first.len() as f64, second.len() as f64);
    let mut all: Vec<(f64, bool)> = first.iter().map(|x| (*x, true)).collect();
    all.extend(second.iter().map(|x| (*x, false)));
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut ranks, mut ties, mut from) = (0.0, 0.0, 0);
    while from < all.len() {
        let value = all[from].0;
        let count = all[from..].iter().take_while(|(x, _)| x.total_cmp(&value).is_eq()).count();
        // Ranks from 1; ties share their mean.
        let rank = (from + 1 + from + count) as f64 / 2.0;
        let of_first = all[from..from + count].iter().filter(|(_, is_first)| *is_first).count();
        ranks += rank * of_first as f64;
        ties += (count as f64).powi(3) - count as f64;
        from += count;
    }
    let u = ranks - n * (n + 1.0) / 2.0;
    let total = n + m;
    let variance = n * m / 12.0 * (total + 1.0 - ties / (total * (total - 1.0)));
    // The variance of empty samples is NaN.
    if variance.is_nan() || variance <= 0.0 {
        return None;
    }
    let off = u - n * m / 2.0;
    let z = off.signum() * (off.abs() - 0.5).max(0.0) / libm::sqrt(variance);
    let p = libm::erfc(z.abs() / std::f64::consts::SQRT_2);
    Some(MannWhitney { u, z, p })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_computed_elsewhere() {
        // scipy.stats.mannwhitneyu(.., method="asymptotic"), two-sided with continuity correction.
        let first = [19.0, 22.0, 16.0, 29.0, 24.0];
        let second = [20.0, 11.0, 17.0, 12.0];
        let result = test(&first, &second).unwrap();
        assert!((result.u - 17.0).abs() < 1e-12);
        assert!((result.p - 0.111_346_886_533_140_41).abs() < 1e-12, "{result:?}");
        let tied = test(&[1.0, 2.0, 2.0, 3.0], &[2.0, 3.0, 3.0, 4.0, 5.0]).unwrap();
        assert!((tied.u - 3.0).abs() < 1e-12);
        assert!((tied.p - 0.099_342_247_853_465_28).abs() < 1e-12, "{tied:?}");
        assert_eq!(test(&[], &[1.0]), None);
        assert_eq!(test(&[1.0], &[1.0]), None);
    }
}
