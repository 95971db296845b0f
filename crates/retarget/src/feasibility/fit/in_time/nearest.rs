//! Finds the curve nearest to given numbers that keeps limits of speed and acceleration, which may differ from row to
//! row.
//!
//! The unknowns are the control points `c` of a uniform cubic B-spline. The spline's value at row `i` is `(c[i-1] + 4
//! c[i] + c[i+1]) / 6`. Its acceleration at this row is exactly the second difference of the control points, in units
//! of rows; between rows the acceleration is linear. Speeds are weighted means of first differences, and positions are
//! weighted means of control points. Limits on differences and points therefore apply at all times, not only at rows.
//!
//! A barrier method (Boyd & Vandenberghe, Convex Optimization, 2004, section 11.3) minimizes the squared distance. All
//! points of the search are strictly within all limits. The matrices have two bands, so a step is O(rows).

use crate::solve::Banded;

/// Weight of the squared distance relative to the barrier, at the beginning and at the end, and its growth factor. The
/// final mean distance from the optimum is at most the root of 12 / weight: 0.1 mrad.
const WEIGHTS: [f64; 2] = [1e2, 1.2e9];
const GROWTH: f64 = 30.0;
/// Maximum number of Newton steps for each weight.
const STEPS: usize = 40;
/// Squared Newton decrement below which the steps for a weight end.
const NEAR: f64 = 0.05;
/// Largest share of the way to the nearest limit that a step uses.
const MOST_OF_WAY: f64 = 0.99;
/// Smallest step, as a share of Newton's step.
const LEAST_OF_STEP: f64 = 1e-8;
/// Minimum number of rows; with fewer rows, the result is constant.
const ROWS: usize = 4;

/// Limits of a curve, with times counted in rows. Infinite values mean no limit.
pub(super) struct CurveLimits {
    /// Smallest and largest value.
    pub(super) range: [f64; 2],
    /// Largest absolute change from each row to the next.
    pub(super) speed: Vec<f64>,
    /// Largest absolute second difference at each row.
    pub(super) acceleration: Vec<f64>,
}

/// Returns the numbers nearest to `values`, in the mean square, whose spline keeps all limits. O(rows) for each of
/// about 60 steps.
pub(super) fn nearest(values: &[f64], limits: &CurveLimits) -> Vec<f64> {
    let [low, high] = limits.range;
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let inset = if (high - low).is_finite() { 1e-3 * (high - low) } else { 1e-6 };
    // A constant curve within the range keeps all limits.
    let begin = mean.max(low + inset).min(high - inset);
    if values.len() < ROWS || high - low < 1e-9 {
        return vec![begin; values.len()];
    }
    let mut search =
        Search { values, limits: each(values.len(), limits), controls: vec![begin; values.len()] };
    let mut weight = WEIGHTS[0];
    loop {
        for _ in 0..STEPS {
            if !search.step(weight) {
                break;
            }
        }
        if weight >= WEIGHTS[1] {
            break;
        }
        weight = (weight * GROWTH).min(WEIGHTS[1]);
    }
    (0..values.len()).map(|row| at_row(&search.controls, row)).collect()
}

/// A limit on a control point, or on a difference of control points.
struct Difference {
    /// Index of the first control point.
    first: usize,
    /// Order of the difference: 0, 1 or 2.
    order: u8,
    low: f64,
    high: f64,
}

impl Difference {
    fn of(&self, controls: &[f64]) -> f64 {
        match (self.order, &controls[self.first..]) {
            (1, [a, b, ..]) => b - a,
            (2, [a, b, c, ..]) => a - 2.0 * b + c,
            (_, rest) => rest[0],
        }
    }

    fn add_to(&self, banded: &mut Banded, value: f64, weight: f64) {
        match self.order {
            1 => banded.add(self.first, [-1.0, 1.0], value, weight),
            2 => banded.add(self.first, [1.0, -2.0, 1.0], value, weight),
            _ => banded.add(self.first, [1.0], value, weight),
        }
    }

    /// Returns the distances to the lower and to the upper limit.
    fn room(&self, controls: &[f64]) -> [f64; 2] {
        let value = self.of(controls);
        [value - self.low, self.high - value]
    }
}

/// Lists all finite limits on control points and differences.
fn each(rows: usize, limits: &CurveLimits) -> Vec<Difference> {
    let [low, high] = limits.range;
    let mut all = Vec::new();
    for first in 0..rows {
        if low.is_finite() || high.is_finite() {
            all.push(Difference { first, order: 0, low, high });
        }
        let both = |order, most: f64| Difference { first, order, low: -most, high: most };
        if first + 1 < rows && limits.speed[first].is_finite() {
            all.push(both(1, limits.speed[first]));
        }
        if first + 2 < rows && limits.acceleration[first + 1].is_finite() {
            all.push(both(2, limits.acceleration[first + 1]));
        }
    }
    all
}

/// Returns the first control point, and the factors of three control points, for the spline's value at a row. The first
/// and the last piece of the spline are parabolas, as in the curve of a motion.
fn factors(rows: usize, row: usize) -> (usize, [f64; 3]) {
    const SIXTH: f64 = 1.0 / 6.0;
    if row == 0 {
        (0, [7.0 * SIXTH, -2.0 * SIXTH, SIXTH])
    } else if row + 1 == rows {
        (rows - 3, [SIXTH, -2.0 * SIXTH, 7.0 * SIXTH])
    } else {
        (row - 1, [SIXTH, 4.0 * SIXTH, SIXTH])
    }
}

/// Returns the value of the spline at a row.
fn at_row(controls: &[f64], row: usize) -> f64 {
    let (first, factors) = factors(controls.len(), row);
    controls[first..].iter().zip(factors).map(|(control, factor)| control * factor).sum()
}

/// State of a search for the nearest curve.
struct Search<'a> {
    values: &'a [f64],
    limits: Vec<Difference>,
    controls: Vec<f64>,
}

impl Search<'_> {
    /// Performs a Newton step. Returns whether another step is useful.
    fn step(&mut self, weight: f64) -> bool {
        let rows = self.values.len();
        let mut banded = Banded::new(rows);
        for (row, value) in self.values.iter().enumerate() {
            let (first, factors) = factors(rows, row);
            banded.add(first, factors, value - at_row(&self.controls, row), weight);
        }
        for limit in &self.limits {
            let [below, above] = limit.room(&self.controls).map(f64::recip);
            let bend = below * below + above * above;
            limit.add_to(&mut banded, (below - above) / bend, bend);
        }
        let way = banded.solve();
        let mut decrement: f64 = (0..rows).map(|row| weight * at_row(&way, row).powi(2)).sum();
        let mut share: f64 = 1.0;
        for limit in &self.limits {
            let [below, above] = limit.room(&self.controls);
            let change = limit.of(&way);
            decrement += (change / below).powi(2) + (change / above).powi(2);
            let room = if change < 0.0 { below } else { above };
            share = share.min(MOST_OF_WAY * room / change.abs());
        }
        // NaN also ends the steps.
        if !(NEAR..f64::INFINITY).contains(&decrement) {
            return false;
        }
        let before = self.cost(&self.controls, weight);
        while share > LEAST_OF_STEP {
            let tried: Vec<f64> =
                self.controls.iter().zip(&way).map(|(c, way)| c + share * way).collect();
            if self.cost(&tried, weight) <= before - 0.1 * share * decrement {
                self.controls = tried;
                return true;
            }
            share *= 0.5;
        }
        false
    }

    /// Returns half of the weighted squared distance, plus the barrier. Beyond a limit the result is NaN.
    fn cost(&self, controls: &[f64], weight: f64) -> f64 {
        let off = |(row, value): (usize, &f64)| (at_row(controls, row) - value).powi(2);
        let distance: f64 = self.values.iter().enumerate().map(off).sum();
        let barrier = |limit: &Difference| -> f64 {
            let finite = |room: &f64| room.is_finite();
            limit.room(controls).into_iter().filter(finite).map(libm::log).sum()
        };
        0.5 * weight * distance - self.limits.iter().map(barrier).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS_S: f64 = 100.0;

    fn limits(rows: usize, range: [f64; 2], speed: f64, acceleration: f64) -> CurveLimits {
        CurveLimits {
            range,
            speed: vec![speed / ROWS_S; rows],
            acceleration: vec![acceleration / ROWS_S / ROWS_S; rows],
        }
    }

    fn sine(rows: u32, size: f64, hz: f64) -> Vec<f64> {
        let at = |row: u32| size * libm::sin(std::f64::consts::TAU * hz * f64::from(row) / ROWS_S);
        (0..rows).map(at).collect()
    }

    fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn numbers_within_all_limits_stay() {
        let given = sine(400, 0.3, 0.5);
        let near = nearest(&given, &limits(400, [-1.0, 1.0], 4.0, 60.0));
        let off = largest_difference(&given, &near);
        assert!(off < 1e-4, "{off}");
    }

    #[test]
    fn a_fast_swing_becomes_smaller_and_keeps_its_time() {
        // The given numbers are 0.5 sin(2 pi 2 t): up to 6.3 rad/s and 79 rad/s2.
        let given = sine(600, 0.5, 2.0);
        let near = nearest(&given, &limits(600, [-1.0, 1.0], 4.0, 30.0));
        let bend = near.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).fold(0.0, f64::max);
        assert!(bend <= 30.0 / ROWS_S / ROWS_S * 1.0001, "{}", bend * ROWS_S * ROWS_S);
        let mid = &near[200..400];
        let most = mid.iter().copied().fold(0.0, f64::max);
        // A motion that alternates between both accelerations reaches 30 (T/4)²/2 = 0.234; the nearest sine reaches
        // 0.19.
        assert!((0.19..0.24).contains(&most), "{most}");
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let alike = dot(mid, &given[200..400])
            / libm::sqrt(dot(mid, mid) * dot(&given[200..400], &given[200..400]));
        assert!(alike > 0.99, "{alike}");
    }

    #[test]
    fn only_the_time_around_a_limit_changes() {
        let mut given = sine(1000, 0.2, 0.3);
        // Adds a bump of 0.3 within 0.2 s, in the middle.
        for (row, value) in given.iter_mut().enumerate() {
            let x = (row as f64 - 500.0) / 5.0;
            *value += 0.3 * libm::exp(-x * x);
        }
        let near = nearest(&given, &limits(1000, [-1.0, 1.0], 4.0, 30.0));
        assert!(largest_difference(&given[450..550], &near[450..550]) > 0.05);
        let far = largest_difference(&given[..400], &near[..400]);
        assert!(far < 2e-3, "{far}");
    }

    #[test]
    fn a_limit_of_one_time_holds_there_only() {
        let given = sine(600, 0.5, 1.0);
        let mut own = limits(600, [-1.0, 1.0], 40.0, 400.0);
        own.acceleration[280..320].fill(5.0 / ROWS_S / ROWS_S);
        let near = nearest(&given, &own);
        let bend = |row: usize| (near[row - 1] - 2.0 * near[row] + near[row + 1]) * ROWS_S * ROWS_S;
        assert!((285..315).all(|row| bend(row).abs() < 5.01));
        assert!(largest_difference(&given[..150], &near[..150]) < 1e-2);
    }

    #[test]
    fn few_rows_and_a_range_without_width_give_a_constant() {
        assert_eq!(nearest(&[0.0, 1.0], &limits(2, [-1.0, 1.0], 1.0, 1.0)), [0.5, 0.5]);
        assert_eq!(nearest(&[0.0; 9], &limits(9, [0.2, 0.2], 1.0, 1.0)), [0.2; 9]);
    }
}
