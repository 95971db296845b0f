//! Symmetric positive definite matrices: `A = L Lᵀ` (Cholesky). They are implemented in this crate because the order of
//! its sums must be fixed, which gives the same bits on every machine.

/// A square matrix, of which only the lower triangle is used.
#[derive(Debug, Clone, Default)]
pub(super) struct Symmetric {
    size: usize,
    numbers: Vec<f64>,
}

impl Symmetric {
    pub(super) fn zeros(size: usize) -> Self {
        Self { size, numbers: vec![0.0; size * size] }
    }

    /// Copies the numbers of another matrix, which must have the same size.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.numbers.copy_from_slice(&other.numbers);
    }

    pub(super) fn fill(&mut self, value: f64) {
        self.numbers.fill(value);
    }

    /// Adds to an element. Only elements at or below the diagonal are used.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        self.numbers[row * self.size + column] += value;
    }

    /// Adds `factor · r rᵀ`.
    pub(super) fn add_square(&mut self, r: &[f64], factor: f64) {
        for row in 0..self.size {
            for column in 0..=row {
                self.add(row, column, factor * r[row] * r[column]);
            }
        }
    }

    /// Replaces the matrix by L. A pivot below `least` becomes `least`: such directions have almost no effect.
    pub(super) fn factor(&mut self, least: f64) {
        let size = self.size;
        for row in 0..size {
            for column in 0..=row {
                let (above, below) = (row * size, column * size);
                let products: f64 =
                    (0..column).map(|k| self.numbers[above + k] * self.numbers[below + k]).sum();
                let rest = self.numbers[above + column] - products;
                self.numbers[above + column] = if row == column {
                    libm::sqrt(rest.max(least))
                } else {
                    rest / self.numbers[below + column]
                };
            }
        }
    }

    /// Solves `A x = b` in place. The matrix must be L, from [`Self::factor`].
    pub(super) fn solve(&self, x: &mut [f64]) {
        let size = self.size;
        for row in 0..size {
            let products: f64 = (0..row).map(|k| self.numbers[row * size + k] * x[k]).sum();
            x[row] = (x[row] - products) / self.numbers[row * size + row];
        }
        for row in (0..size).rev() {
            let products: f64 = (row + 1..size).map(|k| self.numbers[k * size + row] * x[k]).sum();
            x[row] = (x[row] - products) / self.numbers[row * size + row];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_solves() {
        // A Hilbert matrix of size 4, whose inverse contains whole numbers: its first column is 16, -120, 240, -140.
        let mut matrix = Symmetric::zeros(4);
        for row in 0..4_u8 {
            for column in 0..=row {
                matrix.add(row.into(), column.into(), 1.0 / f64::from(1 + row + column));
            }
        }
        matrix.factor(0.0);
        let mut x = [1.0, 0.0, 0.0, 0.0];
        matrix.solve(&mut x);
        for (x, exact) in x.iter().zip([16.0, -120.0, 240.0, -140.0]) {
            // The condition number of the matrix is 15,500.
            assert!((x - exact).abs() < 1e-9, "{x} {exact}");
        }
    }
}
