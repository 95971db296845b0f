//! Rows of coordinates in one allocation, because a fit creates and drops many.

/// Rows of equal length, stored one after the other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rows {
    /// Length of a row.
    pub(super) width: usize,
    pub(super) count: usize,
    pub(super) numbers: Vec<f64>,
}

impl Rows {
    /// Copies rows of one length.
    pub(super) fn of(width: usize, rows: &[Vec<f64>]) -> Self {
        let mut numbers = Vec::with_capacity(width * rows.len());
        for row in rows {
            numbers.extend_from_slice(row);
        }
        Self { width, count: rows.len(), numbers }
    }

    pub(super) fn row(&self, row: usize) -> &[f64] {
        &self.numbers[row * self.width..][..self.width]
    }

    pub(super) fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.numbers[row * self.width..][..self.width]
    }

    /// Returns all rows in turn.
    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        // A rig without coordinates has nothing to change.
        self.numbers.chunks_exact_mut(self.width.max(1))
    }

    /// Returns one number of every row.
    pub(super) fn column(&self, number: usize) -> Vec<f64> {
        (0..self.count).map(|row| self.row(row)[number]).collect()
    }

    /// Returns the rows as lists.
    pub(super) fn lists(&self) -> Vec<Vec<f64>> {
        (0..self.count).map(|row| self.row(row).to_vec()).collect()
    }
}
