//! Least squares: the control values of a cubic spline with given knots.

/// Weight of the spans' jerks, relative to 1 for a sample: it only matters where no sample determines the curve.
const SMOOTHING: f64 = 1e-10;
/// Number of spans at each end with a larger weight, and that weight. At the ends there are three control values more
/// than samples, and if spans are short and samples noisy, a curve could swing out between the samples.
const AT_ENDS: (usize, f64) = (3, 1e-4);

/// Between knots 2 and 3 of six, the curve is a cubic of the distance from knot 2. For each of its powers, 0 to 3: the
/// weights of control values 1 to 4 in the coefficient.
struct Weights([[f64; 4]; 4]);

impl Weights {
    /// Returns the weights of position, velocity, half the acceleration and a sixth of the jerk at knot 2, as the
    /// decoder's `Cubic` computes them from control values.
    fn new(knots: [i32; 6]) -> Self {
        let [t0, t1, t2, t3, t4, t5] = knots.map(f64::from);
        let slopes = [3.0 / (t3 - t0), 3.0 / (t4 - t1), 3.0 / (t5 - t2)];
        let bends = [1.0 / (t3 - t1), 1.0 / (t4 - t2)];
        let (before, here) = (t2 - t1, t3 - t2);
        // Slopes of the control polygon's slopes, at both ends.
        let second = |bend: f64, from: f64, to: f64| [bend * from, -bend * (from + to), bend * to];
        let [a, b, c] = second(bends[0], slopes[0], slopes[1]);
        let [p, q, r] = second(bends[1], slopes[1], slopes[2]);
        let third = 1.0 / (3.0 * here);
        let [from, to] = [slopes[0] * here * bends[0], slopes[1] * before * bends[0]];
        let velocity = [-from, from - to, to, 0.0];
        let half = [a, b, c, 0.0];
        let (back, bent) = ((here - before) / 3.0, before * here / 3.0);
        let mut position: [f64; 4] = std::array::from_fn(|k| half[k] * bent - velocity[k] * back);
        position[1] += 1.0;
        Self([position, velocity, half, [-a, p - b, q - c, r].map(|change| change * third)])
    }
}

/// Returns the sums of the powers 0 to 6 of the integers from 0 to `count` - 1 (Faulhaber).
fn power_sums(count: i32) -> [f64; 7] {
    let n = f64::from(count);
    let p = n * (n - 1.0);
    let (squares, cubes) = (p * (2.0 * n - 1.0) / 6.0, p * p / 4.0);
    [
        n,
        p / 2.0,
        squares,
        cubes,
        squares * (3.0 * p - 1.0) / 5.0,
        cubes * (2.0 * p - 1.0) / 3.0,
        squares * (3.0 * p * (p - 1.0) + 1.0) / 7.0,
    ]
}

/// Returns the control values, one for each knot, whose spline is nearest to the samples. `values`: the samples from
/// `knots[2]` (included) to the last knot but two (excluded). The first and the last control value have no effect, and
/// repeat their neighbours.
///
/// Sums of products of weights reduce to sums of powers, which have closed forms, and to sums of powers times values.
/// The cost is O(1) for each sample, and O(1) for each span.
pub(super) fn fit(knots: &[i32], values: &[f64]) -> Vec<f64> {
    let unknowns = knots.len() - 2;
    // Rows of the normal equations: the diagonal and three elements after it, for the knots from the second on.
    let mut rows = vec![[0.0; 4]; unknowns];
    let mut right = vec![0.0; unknowns];
    let mut rest = values;
    for (first, window) in knots.windows(6).enumerate() {
        let window: [i32; 6] = window.try_into().expect("windows of six");
        let length = window[3] - window[2];
        let weights = Weights::new(window);
        let (of_span, behind) = rest.split_at(length.unsigned_abs() as usize);
        rest = behind;
        let mut powers = power_sums(length);
        // The jerk times the cube of the span: a third difference, if spans are equal.
        let is_at_end = first.min(unknowns - 4 - first) < AT_ENDS.0;
        let smoothing = if is_at_end { AT_ENDS.1 } else { SMOOTHING };
        let cubed = 6.0 * powers[0] * powers[0] * powers[0];
        powers[6] += smoothing * cubed * cubed;
        for (weights, sum) in weights.0.iter().zip(powers_times(of_span)) {
            for (right, weight) in right[first..first + 4].iter_mut().zip(weights) {
                *right += weight * sum;
            }
        }
        let mut products = [[0.0; 4]; 4];
        for (power, weights_of_power) in weights.0.iter().enumerate() {
            let mut sums = [0.0; 4];
            for (weights, sum_of_powers) in weights.0.iter().zip(&powers[power..]) {
                for (sum, weight) in sums.iter_mut().zip(weights) {
                    *sum += weight * sum_of_powers;
                }
            }
            for (products, sum) in products.iter_mut().zip(sums) {
                for (product, weight) in products.iter_mut().zip(weights_of_power) {
                    *product += sum * weight;
                }
            }
        }
        for (k, products) in products.iter().enumerate() {
            for (slot, product) in rows[first + k].iter_mut().zip(&products[k..]) {
                *slot += product;
            }
        }
    }
    solve(&mut rows, &mut right);
    let (first, last) = (right[0], right[unknowns - 1]);
    [first].into_iter().chain(right).chain([last]).collect()
}

/// Returns the sums over a span's samples of their values times the powers 0 to 3 of their positions in it.
fn powers_times(values: &[f64]) -> [f64; 4] {
    let mut sums = [0.0; 4];
    let mut place = 0.0;
    for value in values {
        let mut product = *value;
        for sum in &mut sums {
            *sum += product;
            product *= place;
        }
        place += 1.0;
    }
    sums
}

/// Solves a banded system with three off-diagonals by Cholesky's factors, in place: `right` becomes the solution.
fn solve(rows: &mut [[f64; 4]], right: &mut [f64]) {
    let count = rows.len();
    for row in 0..count {
        let pivot = rows[row][0];
        for k in 1..4.min(count - row) {
            let factor = rows[row][k] / pivot;
            for place in k..4 {
                rows[row + k][place - k] -= factor * rows[row][place];
            }
            right[row + k] -= factor * right[row];
        }
    }
    for row in (0..count).rev() {
        let mut sum = right[row];
        for k in 1..4.min(count - row) {
            sum -= rows[row][k] * right[row + k];
        }
        right[row] = sum / rows[row][0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::span::Cubic;
    use crate::span_lengths::span;

    /// Returns the weights of control values 1 to 4 of six knots, at a position between knots 2 and 3.
    fn weights(knots: [i32; 6], at: f64) -> [f64; 4] {
        let u = at - f64::from(knots[2]);
        let [a, b, c, d] = Weights::new(knots).0;
        std::array::from_fn(|k| a[k] + u * (b[k] + u * (c[k] + u * d[k])))
    }

    #[test]
    fn jerks_are_third_differences_where_spans_are_equal_and_none_of_a_parabola() {
        let jerk = |knots: [i32; 6]| {
            let length = f64::from(knots[3] - knots[2]);
            Weights::new(knots).0[3].map(|cubic| 6.0 * cubic * (length * length * length))
        };
        let mut pairs = jerk([0, 3, 6, 9, 12, 15]).into_iter().zip([-1.0, 3.0, -3.0, 1.0]);
        assert!(pairs.all(|(weight, third)| (weight - third).abs() < 1e-12));
        // The control value of x² at a knot: the mean product of two of the three knots around it (blossom).
        let knots = [-9, -2, 0, 1, 8, 9];
        let control = |k: usize| {
            let [a, b, c] = [knots[k - 1], knots[k], knots[k + 1]].map(f64::from);
            (a * b + b * c + c * a) / 3.0
        };
        let sum: f64 = jerk(knots).iter().zip(1..).map(|(weight, k)| weight * control(k)).sum();
        assert!(sum.abs() < 1e-12, "{sum}");
    }

    #[test]
    fn weights_sum_to_one_and_a_parabola_is_met_exactly() {
        let knots = [-7, -3, 0, 2, 8, 9, 12, 20, 21, 24, 30, 31];
        for window in knots.windows(6) {
            let window: [i32; 6] = window.try_into().expect("six knots");
            for at in [0.0, 0.3, 0.9] {
                let at = f64::from(window[2]) + at * f64::from(window[3] - window[2]);
                assert!((weights(window, at).iter().sum::<f64>() - 1.0).abs() < 1e-14);
            }
        }
        let parabola = |x: f64| 1.0 + x * (0.5 - x * 0.03);
        let values: Vec<f64> = (0..24).map(|sample| parabola(f64::from(sample))).collect();
        let controls = fit(&knots, &values);
        for (first, window) in knots.windows(6).enumerate() {
            let window: [i32; 6] = window.try_into().expect("six knots");
            let at = f64::from(window[2] + window[3]) / 2.0;
            let sum: f64 =
                weights(window, at).iter().zip(&controls[first + 1..]).map(|(w, c)| w * c).sum();
            assert!((sum - parabola(at)).abs() < 1e-9, "{sum} {}", parabola(at));
        }
    }

    #[test]
    #[expect(
        clippy::indexing_slicing,
        clippy::cast_possible_truncation,
        reason = "a test, of numbers that are near"
    )]
    fn the_curve_and_its_derivatives_are_the_spline_s() {
        let mut random = 5u32;
        let mut next = |below: i32| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            i32::try_from(random >> 8).unwrap_or(0) % below
        };
        for _ in 0..2000 {
            let mut knots = [next(1000) - 500; 6];
            for k in 1..6 {
                knots[k] = knots[k - 1] + span(u8::try_from(next(12)).unwrap_or(0));
            }
            let control = [0; 4].map(|_| next(4000) - 2000);
            let step = 1e-3;
            let cubic = Cubic::new(&knots, control, step);
            let len = f64::from(knots[3] - knots[2]);
            let exact = |u: f64| -> f64 {
                let weights = weights(knots, f64::from(knots[2]) + u);
                weights.iter().zip(control).map(|(w, c)| w * f64::from(c)).sum::<f64>()
                    * f64::from(step)
            };
            // Differences of a cubic over this step are exact, except for rounding and the third derivative's part in
            // speed.
            let h = len * 1e-3;
            let shortest = knots.windows(2).map(|w| f64::from(w[1] - w[0])).fold(len, f64::min);
            for share in [0.0f32, 0.1, 0.5, 0.9, 1.0] {
                let (u, u_f32) = (len * f64::from(share), len as f32 * share);
                let middle = u.clamp(h, len - h);
                let (a, b, c) = (exact(middle - h), exact(middle), exact(middle + h));
                let acceleration = (a - 2.0 * b + c) / (h * h);
                let speed = (c - a) / (2.0 * h);
                let at_middle = cubic.at(middle as f32).map(f64::from);
                // Tolerance: f32 rounding, for control values up to 2 over the shortest span.
                let size = 2.0 * 8.0 * f64::from(f32::EPSILON);
                assert!((f64::from(cubic.at(u_f32)[0]) - exact(u)).abs() < size);
                assert!(
                    (at_middle[1] - speed).abs()
                        < size / shortest
                            + 1e-4 * speed.abs() * 1e-2
                            + 6.0 * 4.0 / shortest.powi(3) * h * h / 6.0
                );
                assert!(
                    (at_middle[2] - acceleration).abs()
                        < 6.0 * size / shortest.powi(2)
                            + 1e-7 * acceleration.abs()
                            + 1e-15 / (h * h)
                );
            }
        }
    }
}
