//! Statistics of a sample of numbers.

/// A sample of finite numbers, sorted.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample(Vec<f64>);

impl Sample {
    /// Creates a sample without the numbers that are not finite.
    pub fn new(numbers: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> =
            numbers.into_iter().filter(|number| number.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        Self(sorted)
    }

    /// Returns the numbers, the smallest first.
    pub fn sorted(&self) -> &[f64] {
        &self.0
    }

    /// Returns the mean; `None` if the sample is empty.
    pub fn mean(&self) -> Option<f64> {
        (!self.0.is_empty()).then(|| self.0.iter().sum::<f64>() / self.0.len() as f64)
    }

    /// Returns the quantile of a share, interpolated linearly; `None` if the sample is empty.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let at = share.clamp(0.0, 1.0) * self.0.len().checked_sub(1)? as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to the last index"
        )]
        let below = at as usize;
        let above = (below + 1).min(self.0.len() - 1);
        Some(self.0[below] + (at - below as f64) * (self.0[above] - self.0[below]))
    }

    /// Returns the mode, to a two-hundredth of the range: the maximum of a density with a Gaussian kernel and
    /// Silverman's (1986) bandwidth; `None` if the sample is empty.
    pub fn mode(&self) -> Option<f64> {
        const PLACES: u32 = 200;
        let (low, high) = (self.quantile(0.0)?, self.quantile(1.0)?);
        let mean = self.mean()?;
        let count = self.0.len() as f64;
        let squares = self.0.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
        let quartiles = (self.quantile(0.75)? - self.quantile(0.25)?) / 1.34;
        let spread = libm::sqrt(squares / count);
        let spread = if quartiles > 0.0 { spread.min(quartiles) } else { spread };
        let bandwidth = 0.9 * spread * libm::pow(count, -0.2);
        if bandwidth <= 0.0 {
            return self.quantile(0.5);
        }
        let density = |at: f64| -> f64 {
            let bumps = self.0.iter().map(|x| (x - at) / bandwidth);
            bumps.map(|away| libm::exp(-0.5 * away * away)).sum()
        };
        let places = (0..=PLACES).map(|k| low + (high - low) * f64::from(k) / f64::from(PLACES));
        places
            .map(|at| (density(at), at))
            .fold(None, |top: Option<(f64, f64)>, one| match top {
                Some(top) if one.0 <= top.0 => Some(top),
                _ => Some(one),
            })
            .map(|(_, at)| at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_the_numbers() {
        let sample = Sample::new([4.0, 1.0, f64::NAN, 2.0, 3.0]);
        assert_eq!(sample.sorted(), [1.0, 2.0, 3.0, 4.0]);
        assert_eq!(sample.mean(), Some(2.5));
        assert_eq!(sample.quantile(0.0), Some(1.0));
        assert_eq!(sample.quantile(0.5), Some(2.5));
        assert_eq!(sample.quantile(1.0), Some(4.0));
        assert_eq!(Sample::new([]).quantile(0.5), None);
        assert_eq!(Sample::new([]).mode(), None);
    }

    #[test]
    fn the_mode_is_where_most_are() {
        let heaps = (0..300).map(|k| {
            let spread = 0.05 * libm::sin(f64::from(7 * k));
            if k % 3 == 0 { 0.2 + spread } else { 0.8 + spread }
        });
        let mode = Sample::new(heaps).mode().unwrap();
        assert!((mode - 0.8).abs() < 0.05, "{mode}");
        assert_eq!(Sample::new([5.0, 5.0]).mode(), Some(5.0));
    }
}
