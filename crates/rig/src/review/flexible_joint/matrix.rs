//! Small square matrices: product, exponential, spectral radius.

/// Number of squarings. After them, the norm of the power is almost the power of the largest eigenvalue: the norm
/// also contains a condition number, but of this factor only the 2^30th root enters the result.
const SQUARINGS: i32 = 30;

/// Number of terms of the exponential's series, for a norm of at most 1/2: the next term is below 1e-19.
const TERMS: u32 = 16;

/// A square matrix.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Matrix {
    size: usize,
    /// Elements, row after row.
    items: Vec<f64>,
}

impl Matrix {
    pub(super) fn zero(size: usize) -> Self {
        Self { size, items: vec![0.0; size * size] }
    }

    pub(super) fn identity(size: usize) -> Self {
        let mut identity = Self::zero(size);
        identity.items.iter_mut().step_by(size + 1).for_each(|item| *item = 1.0);
        identity
    }

    /// Creates the matrix of a linear map, by applying the map to each unit vector.
    pub(super) fn of_map(size: usize, map: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let mut matrix = Self::zero(size);
        let mut unit = vec![0.0; size];
        for column in 0..size {
            unit[column] = 1.0;
            for (row, item) in map(&unit).into_iter().enumerate() {
                matrix.items[row * size + column] = item;
            }
            unit[column] = 0.0;
        }
        matrix
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.items.chunks_exact(self.size)
    }

    /// Returns the product with a vector.
    pub(super) fn apply(&self, vector: &[f64]) -> Vec<f64> {
        self.rows().map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum()).collect()
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut product = Self::zero(self.size);
        for (out, row) in product.items.chunks_exact_mut(self.size).zip(self.rows()) {
            for (a, along) in row.iter().zip(other.rows()) {
                for (out, b) in out.iter_mut().zip(along) {
                    *out += a * b;
                }
            }
        }
        product
    }

    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self { size: self.size, items: self.items.iter().map(|item| item * factor).collect() }
    }

    /// Returns the largest row sum of absolute values.
    fn norm(&self) -> f64 {
        self.rows().map(|row| row.iter().map(|item| item.abs()).sum()).fold(0.0, f64::max)
    }

    /// Returns the exponential, by scaling and squaring.
    pub(super) fn exponential(&self) -> Self {
        let mut halvings = 0;
        let mut small = self.clone();
        while small.norm() > 0.5 {
            small = small.scaled(0.5);
            halvings += 1;
        }
        let mut sum = Self::identity(self.size);
        let mut term = Self::identity(self.size);
        for n in 1..=TERMS {
            term = term.times(&small).scaled(1.0 / f64::from(n));
            sum.items.iter_mut().zip(&term.items).for_each(|(sum, item)| *sum += item);
        }
        for _ in 0..halvings {
            sum = sum.times(&sum);
        }
        sum
    }

    /// Returns the absolute value of the largest eigenvalue (Gelfand's formula, by squaring).
    pub(super) fn spectral_radius(&self) -> f64 {
        let mut power = self.clone();
        let mut logarithm = 0.0;
        for squaring in 0..SQUARINGS {
            let norm = power.norm();
            if norm <= 0.0 {
                return 0.0;
            }
            logarithm += libm::ldexp(libm::log(norm), -squaring);
            let unit = power.scaled(1.0 / norm);
            power = unit.times(&unit);
        }
        libm::exp(logarithm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(rows: [[f64; 2]; 2]) -> Matrix {
        Matrix { size: 2, items: rows.concat() }
    }

    #[test]
    fn the_exponential_of_a_turn_is_a_rotation() {
        let turn = of([[0.0, -20.0], [20.0, 0.0]]).exponential();
        let (sin, cos) = 20.0_f64.sin_cos();
        for (found, expected) in turn.items.iter().zip([cos, -sin, sin, cos]) {
            assert!((found - expected).abs() < 1e-12, "{turn:?}");
        }
    }

    #[test]
    fn the_radius_is_that_of_the_largest_eigenvalue() {
        // A pair 0.9 e^(±i) in very oblique axes; a defective matrix; a nilpotent matrix.
        let (sin, cos) = 1.0_f64.sin_cos();
        let oblique = of([
            [0.9 * (cos + 1e3 * sin), -0.9 * (1e6 + 1.0) * sin],
            [0.9 * sin, 0.9 * (cos - 1e3 * sin)],
        ]);
        for (matrix, radius) in [
            (oblique, 0.9),
            (of([[0.7, 100.0], [0.0, 0.7]]), 0.7),
            (of([[0.0, 1.0], [0.0, 0.0]]), 0.0),
            (of([[-1.5, 0.0], [0.0, 1.4]]), 1.5),
        ] {
            assert!((matrix.spectral_radius() - radius).abs() < 1e-6, "{matrix:?}");
        }
    }
}
