//! The normal equations of one step, and their least solution between bounds.

use glam::DVec3;

/// `H x = -g` over the unknown dofs, and bounds on `x`. All memory is taken by the constructor.
#[derive(Debug, Clone)]
pub(super) struct Normal {
    count: usize,
    /// By dof: its place among the unknowns.
    places: Vec<Option<usize>>,
    /// Lower triangle by rows of `count`.
    h: Vec<f64>,
    g: Vec<f64>,
    /// Columns of the term that is added: place, and how it moves.
    columns: Vec<(usize, DVec3)>,
    pub(super) least: Vec<f64>,
    pub(super) most: Vec<f64>,
    /// At a bound: -1, 1; free: 0.
    bound: Vec<i8>,
    x: Vec<f64>,
    free: Vec<usize>,
    factor: Vec<f64>,
    /// By row of the factor: its zeros at the beginning, in whole fours. Limbs that share no joint have many.
    zeros: Vec<usize>,
    solution: Vec<f64>,
}

/// Most changes of the set of bounds in one step: beyond it the step is within bounds, but may not be the least one.
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

    /// How a dof moves what is added next.
    pub(super) fn column(&mut self, dof: usize, moved: DVec3) {
        if let Some(place) = self.places[dof] {
            self.columns.push((place, moved));
        }
    }

    /// Adds `error` with its columns, whose places grow; `weights` by component.
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

    /// Adds `weight · (x + away)²` of one unknown.
    pub(super) fn add_single(&mut self, place: usize, away: f64, weight: f64) {
        self.h[place * self.count + place] += weight;
        self.g[place] += weight * away;
    }

    /// The least step within the bounds, by an active set: unknowns that would leave their bounds are held there and
    /// the rest is solved anew; one that would come back is let go. It begins with those that the last step held: few
    /// change from step to step. O(unknowns³) for each change.
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
            // All within bounds: is one held that pulls inwards? The strongest is let go.
            let mut strongest: Option<(usize, f64)> = None;
            for place in (0..self.count).filter(|place| self.bound[*place] != 0) {
                let pull = -f64::from(self.bound[place]) * self.gradient(place);
                if pull < -1e-9 && strongest.is_none_or(|(_, most)| pull < most) {
                    strongest = Some((place, pull));
                }
            }
            match strongest {
                // The last change must leave all within bounds.
                Some((place, _)) if change + 2 < CHANGES => self.bound[place] = 0,
                _ => break,
            }
        }
        &self.x
    }

    /// Whether the last step held an unknown at its lower (-1) or upper bound (1).
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
                // What begins with zeros has them in its factor too.
                let from = zeros.max(self.zeros[j]).min(j);
                row[j] = (row[j] - dot(&row[from..j], &other[from..j])) / other[j];
            }
            // Regularisation keeps this above zero; rounding alone cannot take it away.
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

/// Four sums side by side: the machine adds them at once, and the order is the same everywhere.
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
