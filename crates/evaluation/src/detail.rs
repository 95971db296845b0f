//! Details of a run beyond its means: errors by body, by size and over time, in memory that does not grow with the
//! clip.

use super::metrics::ErrorTotals;
use super::pose_error::PoseError;

/// The errors of one run, by body, by size and over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Detail {
    /// Errors by body and by size. They may be merged over clips.
    pub spread: Spread,
    /// Errors over the time of the clip.
    pub trace: ErrorTrace,
}

/// Distribution of errors over the bodies and over sizes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spread {
    /// Totals of each body.
    pub bodies: Vec<ErrorTotals>,
    /// Angular errors of all bodies by size, in degrees.
    pub angular_deg: Histogram,
    /// Linear errors of all bodies by size, in centimetres.
    pub linear_cm: Histogram,
}

/// A histogram of positive values. Each bin is an eighth of a power of two wide, 6 to 12 % of its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    counts: Vec<u64>,
}

/// Errors over time: means and maxima over all bodies in equal stretches of the run.
///
/// As a run proceeds, neighbouring stretches are joined. There are never more than [`ErrorTrace::CAPACITY`]
/// stretches, and all except the last have equal length.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorTrace {
    steps_each: usize,
    stretches: Vec<ErrorTotals>,
    steps_in_last: usize,
}

impl Detail {
    /// Adds one step: the error of each body.
    pub fn add(&mut self, errors: &[PoseError]) {
        let mut step = ErrorTotals::default();
        self.spread.hold(errors.len());
        for (error, body) in errors.iter().zip(&mut self.spread.bodies) {
            body.add(error);
            step.add(error);
            self.spread.angular_deg.add(error.angular_rad.to_degrees());
            self.spread.linear_cm.add(error.linear_m * 100.0);
        }
        self.trace.add(&step);
    }
}

impl Spread {
    /// Extends the list to at least `bodies` bodies.
    fn hold(&mut self, bodies: usize) {
        if self.bodies.len() < bodies {
            self.bodies.resize(bodies, ErrorTotals::default());
        }
    }

    /// Adds the spread of another run. Float sums depend on the order: merge in the order of the clips for
    /// identical bits.
    pub fn merge(&mut self, other: &Self) {
        self.hold(other.bodies.len());
        for (body, other) in self.bodies.iter_mut().zip(&other.bodies) {
            body.merge(other);
        }
        self.angular_deg.merge(&other.angular_deg);
        self.linear_cm.merge(&other.linear_cm);
    }
}

impl Histogram {
    /// Shift from a value's bits to its bin. A bin contains the values with equal sign, exponent and first three
    /// bits of the mantissa: exact, and without a logarithm.
    const SHIFT: u32 = 52 - 3;
    /// Lower bound of the first bin, 2^-14. Smaller values count in the first bin.
    const FIRST: u64 = (1023 - 14) << 3;
    /// Number of bins. They end at 2^10; larger values count in the last bin.
    const BINS: usize = (14 + 10) << 3;

    #[inline]
    fn add(&mut self, value: f64) {
        let bin = (value.to_bits() >> Self::SHIFT).saturating_sub(Self::FIRST);
        let bin = usize::try_from(bin).map_or(Self::BINS - 1, |bin| bin.min(Self::BINS - 1));
        self.counts[bin] += 1;
    }

    fn merge(&mut self, other: &Self) {
        for (count, other) in self.counts.iter_mut().zip(&other.counts) {
            *count += other;
        }
    }

    /// Returns the number of values.
    pub fn n(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Returns the distribution function as pairs of a bin's upper bound and the share of values below it. The first
    /// pair has the lower bound of the first bin that is not empty, with the share 0; the last pair has the share 1.
    pub fn cumulative(&self) -> Vec<(f64, f64)> {
        let n = self.n() as f64;
        let mut below = 0;
        let mut points = Vec::new();
        for (bin, count) in self.counts.iter().enumerate() {
            if below == 0 && *count > 0 {
                points.push((Self::bound(bin), 0.0));
            }
            below += count;
            if below > 0 {
                points.push((Self::bound(bin + 1), below as f64 / n));
            }
            if below == self.n() {
                break;
            }
        }
        points
    }

    /// Returns the lower bound of a bin.
    fn bound(bin: usize) -> f64 {
        f64::from_bits((Self::FIRST + bin as u64) << Self::SHIFT)
    }
}

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: vec![0; Self::BINS] }
    }
}

impl ErrorTrace {
    /// Maximum number of stretches.
    pub const CAPACITY: usize = 600;

    fn add(&mut self, step: &ErrorTotals) {
        if self.stretches.is_empty() || self.steps_in_last == self.steps_each {
            if self.stretches.len() == Self::CAPACITY {
                self.join_pairs();
            }
            self.stretches.push(ErrorTotals::default());
            self.steps_in_last = 0;
        }
        self.steps_in_last += 1;
        let last = self.stretches.last_mut().expect("there is one now");
        last.merge(step);
    }

    /// Joins pairs of stretches. The capacity is even: no stretch remains single.
    fn join_pairs(&mut self) {
        let joined = self.stretches.chunks(2).map(|pair| {
            let mut sum = pair[0];
            sum.merge(&pair[1]);
            sum
        });
        self.stretches = joined.collect();
        self.steps_each *= 2;
    }

    /// Returns the number of steps of a stretch. The last stretch may have fewer.
    pub fn steps_each(&self) -> usize {
        self.steps_each
    }

    /// Returns the stretches in the order of time.
    pub fn stretches(&self) -> &[ErrorTotals] {
        &self.stretches
    }
}

impl Default for ErrorTrace {
    fn default() -> Self {
        Self { steps_each: 1, stretches: Vec::new(), steps_in_last: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_figure::BODY_COUNT;

    /// Returns a detail of `steps` steps. In step `s` only body 7 has an error: `s` mm and `s` mrad.
    fn drifting(steps: u32) -> Detail {
        let mut detail = Detail::default();
        for step in 0..steps {
            let mut off = [PoseError { angular_rad: 0.0, linear_m: 0.0 }; BODY_COUNT];
            let grown = f64::from(step) * 1e-3;
            off[7] = PoseError { angular_rad: grown, linear_m: grown };
            detail.add(&off);
        }
        detail
    }

    #[test]
    fn errors_are_those_of_the_body_that_has_them() {
        let detail = drifting(11);
        for (body, totals) in detail.spread.bodies.iter().enumerate() {
            let (mean_cm, max_deg) =
                if body == 7 { (0.5, 0.01f64.to_degrees()) } else { (0.0, 0.0) };
            assert_eq!(totals.n, 11);
            assert!((totals.linear_mean_cm() - mean_cm).abs() < 1e-12);
            assert!((totals.angular_max_deg() - max_deg).abs() < 1e-9);
        }
    }

    #[test]
    fn stretches_are_joined_and_lose_nothing() {
        for steps in [1, 599, 600, 601, 1200, 1201, 5000] {
            let trace = drifting(steps).trace;
            let each = trace.steps_each();
            assert!(trace.stretches().len() <= ErrorTrace::CAPACITY);
            assert!(each == 1 || trace.stretches().len() > ErrorTrace::CAPACITY / 2);
            let (last, full) = trace.stretches().split_last().unwrap();
            let mut counted = 0;
            for (index, stretch) in trace.stretches().iter().enumerate() {
                counted += stretch.n;
                // The largest error of a stretch is that of its last step.
                let until = ((index + 1) * each).min(steps as usize);
                assert!((stretch.linear_max_cm() - 0.1 * (until - 1) as f64).abs() < 1e-9);
            }
            assert!(full.iter().all(|stretch| stretch.n == (each * BODY_COUNT) as u64));
            assert!(last.n <= (each * BODY_COUNT) as u64);
            assert_eq!(counted, u64::from(steps) * BODY_COUNT as u64);
        }
    }

    #[test]
    fn the_distribution_is_that_of_the_values() {
        let mut histogram = Histogram::default();
        for value in [0.0, 1e-9, 0.5, 1.5, 1.5, 20.0, 1e9, f64::INFINITY] {
            histogram.add(value);
        }
        let points = histogram.cumulative();
        let below =
            |x: f64| points.iter().rfind(|(bound, _)| *bound <= x).map_or(0.0, |point| point.1);
        assert_eq!(histogram.n(), 8);
        for (x, expected) in [(0.1, 2.0), (1.0, 3.0), (10.0, 5.0), (100.0, 6.0), (1024.0, 8.0)] {
            assert!((below(x) - expected / 8.0).abs() < 1e-12, "{x}: {}", below(x));
        }
        assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 <= pair[1].1));
        assert!(Histogram::default().cumulative().is_empty());
    }

    #[test]
    fn merged_spreads_are_that_of_all_steps() {
        let mut merged = drifting(40).spread;
        merged.merge(&Detail::default().spread);
        assert_eq!(merged, drifting(40).spread);
        merged.merge(&drifting(40).spread);
        assert_eq!(merged.angular_deg.n(), 2 * 40 * BODY_COUNT as u64);
        assert_eq!(merged.bodies[7].n, 80);
        assert!((merged.bodies[7].linear_mean_cm() - 1.95).abs() < 1e-12);
    }
}
