//! Symmetric positive definite matrices: `A = L Lᵀ` (Cholesky). They are implemented in this crate because the order of
//! its sums must be fixed, which gives the same bits on every machine.

/// A square matrix, of which only the lower triangle is used. Zeros at the start of rows and at the end of columns,
/// which the matrices of trees with many branches have, are skipped; the result has the same bits as with them.
#[derive(Debug, Clone, Default)]
pub(super) struct Symmetric {
    size: usize,
    numbers: Vec<f64>,
    /// For each row of L, the first column that is not zero; for each column, the row after the last that is not zero.
    begins: Vec<usize>,
    ends: Vec<usize>,
}

impl Symmetric {
    pub(super) fn zeros(size: usize) -> Self {
        let (begins, ends) = (vec![0; size], vec![size; size]);
        Self { size, numbers: vec![0.0; size * size], begins, ends }
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
        let is_zero = |number: &f64| number.abs() <= 0.0;
        let first = r.iter().position(|number| !is_zero(number)).unwrap_or(r.len());
        for row in (first..self.size).filter(|row| !is_zero(&r[*row])) {
            for column in first..=row {
                self.add(row, column, factor * r[row] * r[column]);
            }
        }
    }

    /// Finds the zeros at the start of each row. Nothing fills them when the matrix is factored.
    fn find_zeros(&mut self) {
        for row in 0..self.size {
            let numbers = &self.numbers[row * self.size..][..row];
            let begin = numbers.iter().position(|number| number.abs() > 0.0);
            self.begins[row] = begin.unwrap_or(row);
        }
        for column in 0..self.size {
            let last = (column + 1..self.size).rev().find(|row| self.begins[*row] <= column);
            self.ends[column] = last.unwrap_or(column) + 1;
        }
    }

    /// Replaces the matrix by L. A pivot below `least` becomes `least`: such directions have almost no effect.
    pub(super) fn factor(&mut self, least: f64) {
        self.find_zeros();
        let size = self.size;
        for row in 0..size {
            for column in self.begins[row]..=row {
                let (above, below) = (row * size, column * size);
                let from = self.begins[row].max(self.begins[column]);
                let products: f64 =
                    (from..column).map(|k| self.numbers[above + k] * self.numbers[below + k]).sum();
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
        // Rows before the first number of b stay zero.
        let first = x.iter().position(|x| x.abs() > 0.0).unwrap_or(size);
        for row in first..size {
            let from = self.begins[row].max(first);
            let products: f64 = (from..row).map(|k| self.numbers[row * size + k] * x[k]).sum();
            x[row] = (x[row] - products) / self.numbers[row * size + row];
        }
        for row in (0..size).rev() {
            let to = self.ends[row];
            let products: f64 = (row + 1..to).map(|k| self.numbers[k * size + row] * x[k]).sum();
            x[row] = (x[row] - products) / self.numbers[row * size + row];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_are_skipped_where_they_are() {
        // Two chains, of 2 and of 3 joints, at a common base in the middle.
        let coupled = [(0, 0), (1, 1), (2, 2), (3, 3), (4, 4), (1, 0), (3, 2), (4, 2), (4, 3)];
        let mut matrix = Symmetric::zeros(5);
        for (row, column) in coupled {
            matrix.add(row, column, if row == column { 4.0 } else { 1.0 });
        }
        matrix.add_square(&[0.0, 0.5, 0.0, -0.25, 0.0], 2.0);
        let whole = matrix.numbers.clone();
        matrix.factor(0.0);
        let b = [0.0, 0.0, 1.0, 0.0, 2.0];
        let mut x = b;
        matrix.solve(&mut x);
        for (row, expected) in b.iter().enumerate() {
            let element = |column: usize| whole[row.max(column) * 5 + row.min(column)];
            let sum: f64 = (0..5).map(|column| element(column) * x[column]).sum();
            assert!((sum - expected).abs() < 1e-12, "{row}: {sum}");
        }
        assert!(x[0].abs() > 1e-3, "the square couples the chains");
    }

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
