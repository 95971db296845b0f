//! Distances between all pairs of some items, each computed once.

use rayon::prelude::*;

/// A symmetric matrix of distances, zero on its diagonal: its lower triangle, row by row, in f32.
#[derive(Debug, Clone, PartialEq)]
pub struct Distances {
    count: usize,
    below: Vec<f32>,
}

impl Distances {
    /// Computes `distance` between all items `i > j`, rows in parallel. `done` is called for every row with its number
    /// of pairs. The result has the same bits for any number of threads. Memory: two bytes for each ordered pair.
    pub fn new<W>(
        count: usize,
        workspace: impl Fn() -> W + Sync,
        distance: impl Fn(&mut W, usize, usize) -> f32 + Sync,
        done: impl Fn(usize) + Sync,
    ) -> Self {
        let mut below = vec![0.0; count * count.saturating_sub(1) / 2];
        let mut rows = Vec::with_capacity(count);
        let mut rest = below.as_mut_slice();
        for row in 1..count {
            let (own, after) = rest.split_at_mut(row);
            rows.push(own);
            rest = after;
        }
        rows.into_par_iter().enumerate().for_each_init(&workspace, |workspace, (before, out)| {
            let row = before + 1;
            for (column, out) in out.iter_mut().enumerate() {
                *out = distance(workspace, row, column);
            }
            done(row);
        });
        Self { count, below }
    }

    /// Returns the number of items.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the distance of two items.
    pub fn get(&self, a: usize, b: usize) -> f64 {
        let (high, low) = (a.max(b), a.min(b));
        if high == low { 0.0 } else { f64::from(self.below[high * (high - 1) / 2 + low]) }
    }

    /// Returns the distances between some of the items, in the given order.
    #[must_use]
    pub fn of(&self, things: &[usize]) -> Self {
        let pairs = (1..things.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        #[expect(clippy::cast_possible_truncation, reason = "it was f32")]
        let below = pairs.map(|(i, j)| self.get(things[i], things[j]) as f32).collect();
        Self { count: things.len(), below }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_is_there_once() {
        let place = |thing: usize| (thing * thing) as f32;
        let calls = std::sync::atomic::AtomicUsize::new(0);
        let distances = Distances::new(
            6,
            || (),
            |(), a, b| place(a) - place(b),
            |pairs| {
                calls.fetch_add(pairs, std::sync::atomic::Ordering::Relaxed);
            },
        );
        assert_eq!(calls.into_inner(), 15);
        let of = |a, b| distances.get(a, b).to_bits();
        let is = f64::to_bits;
        assert_eq!([of(2, 5), of(5, 2), of(3, 3)], [is(21.0), is(21.0), is(0.0)]);
        let some = distances.of(&[5, 0, 2]);
        let of = |a, b| some.get(a, b).to_bits();
        assert_eq!([of(0, 1), of(2, 0), of(1, 2)], [is(25.0), is(21.0), is(4.0)]);
        assert_eq!(Distances::new(0, || (), |(), _, _| 1.0, |_| ()).count(), 0);
    }
}
