//! Least squares over the frames of a clip. The matrix has two bands on each side of its diagonal.

/// A symmetric matrix with two bands below its diagonal, and a right side: for sums of squares of values, first and
/// second differences.
#[derive(Debug, Clone)]
pub(crate) struct Banded {
    /// The diagonal, then the first and the second band below it.
    bands: [Vec<f64>; 3],
    right: Vec<f64>,
}

impl Banded {
    pub(crate) fn new(count: usize) -> Self {
        Self { bands: std::array::from_fn(|_| vec![0.0; count]), right: vec![0.0; count] }
    }

    /// Adds `weight · (Σ factors[k] · x[first + k] - value)²`.
    pub(crate) fn add<const N: usize>(
        &mut self,
        first: usize,
        factors: [f64; N],
        value: f64,
        weight: f64,
    ) {
        for (k, factor) in factors.iter().enumerate() {
            self.right[first + k] += weight * factor * value;
            for (j, other) in factors[..=k].iter().enumerate() {
                self.bands[k - j][first + k] += weight * factor * other;
            }
        }
    }

    /// Returns the least-squares solution, by the factors L D Lᵀ. O(n).
    pub(crate) fn solve(self) -> Vec<f64> {
        let Self { bands: [mut d, mut one, mut two], right: mut x } = self;
        let n = x.len();
        for i in 0..n {
            // In row i, the places below the diagonal are in columns i-1 and i-2.
            if i >= 2 {
                let l = two[i] / d[i - 2];
                one[i] -= l * one[i - 1] * d[i - 2];
                d[i] -= l * two[i];
                x[i] -= l * x[i - 2];
                two[i] = l;
            }
            if i >= 1 {
                let l = one[i] / d[i - 1];
                d[i] -= l * one[i];
                x[i] -= l * x[i - 1];
                one[i] = l;
            }
            d[i] = d[i].max(f64::MIN_POSITIVE);
        }
        for i in (0..n).rev() {
            x[i] /= d[i];
            if i + 1 < n {
                x[i] -= one[i + 1] * x[i + 1];
            }
            if i + 2 < n {
                x[i] -= two[i + 2] * x[i + 2];
            }
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_fulfils_the_normal_equations() {
        // Sums of squares with pseudo-random factors: the gradient at the solution is only rounding of sums of 40
        // terms.
        let n = 12;
        let mut banded = Banded::new(n);
        let mut dense = vec![vec![0.0; n]; n];
        let mut right = vec![0.0; n];
        let number = |k: usize| ((k * 7919 + 13) % 101) as f64 / 50.0 - 1.0;
        for k in 0..n {
            let factors: Vec<f64> = (0..3).map(|j| number(3 * k + j)).collect();
            let (value, weight) = (number(k + 77), 1.0 + number(k + 5).abs());
            if k + 2 < n {
                banded.add(k, [factors[0], factors[1], factors[2]], value, weight);
                for a in 0..3 {
                    right[k + a] += weight * factors[a] * value;
                    for b in 0..3 {
                        dense[k + a][k + b] += weight * factors[a] * factors[b];
                    }
                }
            }
            banded.add(k, [1.0], 0.5, 0.3);
            dense[k][k] += 0.3;
            right[k] += 0.15;
        }
        let x = banded.solve();
        for (row, right) in dense.iter().zip(right) {
            let left: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((left - right).abs() < 1e-12, "{left} {right}");
        }
    }
}
