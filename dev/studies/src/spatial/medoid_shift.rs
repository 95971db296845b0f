//! Medoid shift: clusters of items of which only distances are known (Sheikh, Khan & Kanade 2007).

use sinew_pose_metrics::spatial::Distances;

/// Cutoff of the Gaussian kernel, in bandwidths: beyond it the weights are too small for f64 beside the nearest ones.
const REACH: f64 = 9.0;

/// Returns the cluster of each item, with a Gaussian kernel of the given bandwidth. Clusters are numbered in the order
/// of their first members. O(n³).
///
/// Every item moves to the item with the smallest sum of squared distances from all others, weighted by the kernel
/// around its present place. It moves again until it stays in place.
pub fn clusters(distances: &Distances, bandwidth: f64) -> Vec<usize> {
    Squares::of(distances).clusters(bandwidth, usize::MAX).unwrap_or_default()
}

/// Returns the clusters of every bandwidth that makes `wanted` clusters of at least two items each, starting with the
/// smallest. The 101 bandwidths are evenly spaced on a logarithmic scale from a hundredth of the largest distance to
/// the largest distance.
pub fn with_clusters(
    distances: &Distances,
    wanted: usize,
) -> impl Iterator<Item = (f64, Vec<usize>)> {
    let squares = Squares::of(distances);
    let largest = libm::sqrt(squares.squared.iter().copied().fold(0.0, f64::max));
    (0..=100).map(move |step| largest * libm::pow(0.01, 1.0 - f64::from(step) / 100.0)).filter_map(
        move |bandwidth| {
            let of = squares.clusters(bandwidth, wanted)?;
            let found = of.iter().max().map_or(0, |last| last + 1);
            let members = |cluster: usize| of.iter().filter(|own| **own == cluster).count();
            (found == wanted && (0..found).all(|cluster| members(cluster) >= 2))
                .then_some((bandwidth, of))
        },
    )
}

/// The squares of all distances, row by row.
struct Squares {
    count: usize,
    squared: Vec<f64>,
}

impl Squares {
    fn of(distances: &Distances) -> Self {
        let count = distances.count();
        let pairs = (0..count).flat_map(|a| (0..count).map(move |b| (a, b)));
        Self { count, squared: pairs.map(|(a, b)| distances.get(a, b).powi(2)).collect() }
    }

    fn row(&self, thing: usize) -> &[f64] {
        &self.squared[thing * self.count..(thing + 1) * self.count]
    }

    /// Returns the clusters, if there are at most `at_most`.
    fn clusters(&self, bandwidth: f64, at_most: usize) -> Option<Vec<usize>> {
        let mut next = Vec::with_capacity(self.count);
        let mut staying = 0;
        for thing in 0..self.count {
            let to = self.next(thing, bandwidth);
            // Every item that stays is the mode of a cluster.
            staying += usize::from(to == thing);
            if staying > at_most {
                return None;
            }
            next.push(to);
        }
        let mut modes = Vec::new();
        let number = |thing| {
            let mode = end(&next, thing);
            modes.iter().position(|other| *other == mode).unwrap_or_else(|| {
                modes.push(mode);
                modes.len() - 1
            })
        };
        Some((0..self.count).map(number).collect())
    }

    /// Returns the item to which an item moves.
    fn next(&self, at: usize, bandwidth: f64) -> usize {
        let scale = -0.5 / (bandwidth * bandwidth);
        let farthest = (REACH * bandwidth).powi(2);
        let mut costs = vec![0.0; self.count];
        for (other, squared) in self.row(at).iter().enumerate() {
            if *squared <= farthest {
                let kernel = libm::exp(scale * squared);
                for (cost, squared) in costs.iter_mut().zip(self.row(other)) {
                    *cost += kernel * squared;
                }
            }
        }
        // The item stays if no other item's place is better.
        let stay = (costs[at], at);
        let better = |best: (f64, usize), (to, cost): (usize, f64)| {
            if cost < best.0 { (cost, to) } else { best }
        };
        costs.into_iter().enumerate().fold(stay, better).1
    }
}

/// Returns the end of an item's path. Every step lowers the cost, but each item has its own kernel, so a path can end
/// in a cycle. Then the cycle's smallest index is returned.
fn end(next: &[usize], mut at: usize) -> usize {
    let mut seen = vec![at];
    while next[at] != at {
        at = next[at];
        if let Some(first) = seen.iter().position(|before| *before == at) {
            return *seen[first..].iter().min().expect("a round trip has members");
        }
        seen.push(at);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_heaps_are_two_clusters() {
        let place = |thing: usize| {
            let spread = 0.3 * libm::sinf(5.0 * thing as f32);
            if thing.is_multiple_of(2) { spread } else { 4.0 + spread }
        };
        let distances = Distances::new(20, || (), |(), a, b| (place(a) - place(b)).abs(), |_| ());
        let (bandwidth, of) = with_clusters(&distances, 2).next().unwrap();
        assert!(bandwidth > 0.1 && bandwidth < 2.0, "{bandwidth}");
        assert!(of.iter().enumerate().all(|(thing, cluster)| *cluster == thing % 2), "{of:?}");
        assert_eq!(clusters(&distances, 100.0), vec![0; 20]);
        assert_eq!(with_clusters(&distances, 50).next(), None);
    }
}
