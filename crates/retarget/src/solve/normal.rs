//! The normal equations of one step, and their solution within bounds.

use glam::DVec3;

/// The equations `H x = -g` over the unknown dofs, with bounds on `x`. The constructor allocates all memory.
#[derive(Debug, Clone)]
pub(super) struct Normal {
    count: usize,
    /// Index of each dof among the unknowns.
    places: Vec<Option<usize>>,
    /// Lower triangle, in rows of length `count`.
    h: Vec<f64>,
    g: Vec<f64>,
    /// Columns of the term that is added next: index of the unknown, and its derivative.
    columns: Vec<(usize, DVec3)>,
    pub(super) least: Vec<f64>,
    pub(super) most: Vec<f64>,
    /// State of each unknown: -1 at the lower bound, 1 at the upper bound, 0 free.
    bound: Vec<i8>,
    x: Vec<f64>,
    free: Vec<usize>,
    factor: Vec<f64>,
    /// Number of zeros at the beginning of each row of the factor, rounded down to a multiple of four. The rows of
    /// limbs that share no joint have many zeros.
    zeros: Vec<usize>,
    solution: Vec<f64>,
}

/// Maximum number of changes of the active set in one step. Beyond it, the step is within bounds but may not be
/// optimal.
const CHANGES: usize = 12;

impl Normal {
    pub(super) fn new(dofs: usize, unknown: &[usize]) -> Self {
        let count = unknown.len();
        let mut places = vec![None; dofs];
        for (place, dof) in unknown.iter().enumerate() {
            places[*dof] = Some(place);
        }
        Self {
            count,
            places,
            h: vec![0.0; count * count],
            g: vec![0.0; count],
            columns: Vec::with_capacity(count),
            least: vec![f64::NEG_INFINITY; count],
            most: vec![f64::INFINITY; count],
            bound: vec![0; count],
            x: vec![0.0; count],
            free: Vec::with_capacity(count),
            factor: vec![0.0; count * count],
            zeros: vec![0; count],
            solution: vec![0.0; count],
        }
    }

    pub(super) fn clear(&mut self) {
        self.h.fill(0.0);
        self.g.fill(0.0);
    }

    /// Adds to the derivative of the next term with respect to a dof. Dofs usually rise.
    pub(super) fn column(&mut self, dof: usize, moved: DVec3) {
        let Some(place) = self.places[dof] else { return };
        let at = self.columns.partition_point(|(other, _)| *other < place);
        match self.columns.get_mut(at) {
            Some((other, sum)) if *other == place => *sum += moved,
            _ => self.columns.insert(at, (place, moved)),
        }
    }

    /// Adds `error` with its columns, whose indices rise; `weights` are those of the components.
    pub(super) fn add(&mut self, error: DVec3, weights: DVec3) {
        let weighted_error = error * weights;
        for (k, (place, moved)) in self.columns.iter().enumerate() {
            let weighted = *moved * weights;
            self.g[*place] += moved.dot(weighted_error);
            let row = &mut self.h[place * self.count..][..self.count];
            for (other, also) in &self.columns[..=k] {
                row[*other] += weighted.dot(*also);
            }
        }
        self.columns.clear();
    }

    /// Adds `weight · (x + away)²` for one unknown.
    pub(super) fn add_single(&mut self, place: usize, away: f64, weight: f64) {
        self.h[place * self.count + place] += weight;
        self.g[place] += weight * away;
    }

    /// Returns the optimal step within the bounds, by an active set: unknowns that would leave their bounds are
    /// held there and the others are solved again; an unknown that would return is released. It begins with the set
    /// of the last step, because few change from step to step. O(unknowns³) for each change.
    pub(super) fn solve(&mut self) -> &[f64] {
        for place in 0..self.count {
            let [least, most] = [self.least[place], self.most[place]];
            self.x[place] = match self.bound[place] {
                -1 if least.is_finite() => least,
                1 if most.is_finite() => most,
                _ => {
                    self.bound[place] = 0;
                    0.0f64.clamp(least, most)
                }
            };
        }
        for change in 0..CHANGES {
            self.solve_free();
            let mut left = false;
            for (k, place) in self.free.iter().enumerate() {
                let x = self.solution[k];
                if x < self.least[*place] {
                    (self.bound[*place], self.x[*place], left) = (-1, self.least[*place], true);
                } else if x > self.most[*place] {
                    (self.bound[*place], self.x[*place], left) = (1, self.most[*place], true);
                } else {
                    self.x[*place] = x;
                }
            }
            if left {
                continue;
            }
            // All unknowns are within bounds. If some are held although their gradient points inwards, the strongest is
            // released.
            let mut strongest: Option<(usize, f64)> = None;
            for place in (0..self.count).filter(|place| self.bound[*place] != 0) {
                let pull = -f64::from(self.bound[place]) * self.gradient(place);
                if pull < -1e-9 && strongest.is_none_or(|(_, most)| pull < most) {
                    strongest = Some((place, pull));
                }
            }
            match strongest {
                // The last change must leave all unknowns within bounds.
                Some((place, _)) if change + 2 < CHANGES => self.bound[place] = 0,
                _ => break,
            }
        }
        &self.x
    }

    /// Returns -1 if the last step held an unknown at its lower bound, 1 if at its upper bound, 0 if it was free.
    pub(super) fn held(&self, place: usize) -> i8 {
        self.bound[place]
    }

    fn element(&self, row: usize, column: usize) -> f64 {
        let (row, column) = if row >= column { (row, column) } else { (column, row) };
        self.h[row * self.count + column]
    }

    fn gradient(&self, place: usize) -> f64 {
        (0..self.count).map(|other| self.element(place, other) * self.x[other]).sum::<f64>()
            + self.g[place]
    }

    /// Solves for the unknowns that are not held (Cholesky).
    fn solve_free(&mut self) {
        self.free.clear();
        self.free.extend((0..self.count).filter(|place| self.bound[*place] == 0));
        let n = self.free.len();
        let is_all = n == self.count;
        for (i, place) in self.free.iter().enumerate() {
            let row = &self.h[place * self.count..][..self.count];
            let to = &mut self.factor[i * self.count..][..=i];
            if is_all {
                to.copy_from_slice(&row[..=i]);
            } else {
                for (to, other) in to.iter_mut().zip(&self.free) {
                    *to = row[*other];
                }
            }
            let zeros = to.iter().position(|x| *x != 0.0).unwrap_or(0);
            self.zeros[i] = zeros - zeros % 4;
        }
        for i in 0..n {
            let place = self.free[i];
            let mut right = -self.g[place];
            if !is_all {
                for other in 0..self.count {
                    if self.bound[other] != 0 {
                        right -= self.element(place, other) * self.x[other];
                    }
                }
            }
            self.solution[i] = right;
        }
        let stride = self.count;
        for i in 0..n {
            let (above, row) = self.factor.split_at_mut(i * stride);
            let zeros = self.zeros[i];
            for j in zeros..i {
                let other = &above[j * stride..][..=j];
                // A row that begins with zeros has the same zeros in its factor.
                let from = zeros.max(self.zeros[j]).min(j);
                row[j] = (row[j] - dot(&row[from..j], &other[from..j])) / other[j];
            }
            // Regularization keeps this above zero; rounding alone cannot remove it.
            row[i] = (row[i] - dot(&row[zeros..i], &row[zeros..i])).max(1e-12).sqrt();
            let known = dot(&row[zeros..i], &self.solution[zeros..i]);
            self.solution[i] = (self.solution[i] - known) / row[i];
        }
        for i in (0..n).rev() {
            let (row, zeros) = (&self.factor[i * stride..][..=i], self.zeros[i]);
            let x = self.solution[i] / row[i];
            self.solution[i] = x;
            for (below, factor) in self.solution[zeros..i].iter_mut().zip(&row[zeros..]) {
                *below -= factor * x;
            }
        }
    }
}

/// Returns the dot product by four sums side by side, which a processor computes at once in an order that is equal
/// everywhere.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a_chunks, b_chunks) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_chunks.zip(b_chunks) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
