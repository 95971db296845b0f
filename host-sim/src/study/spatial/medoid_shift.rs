//! Medoid shift: clusters of things of which only distances are known (Sheikh, Khan & Kanade 2007).

use crate::spatial::Distances;

/// Which cluster each thing is in, numbered by their first members, with a Gaussian kernel of the given bandwidth. O(n³).
///
/// Every thing goes to the one that has the least sum of squared distances from all others, weighted by the kernel
/// around where it is; and on from there, until it stays.
pub fn clusters(distances: &Distances, bandwidth: f64) -> Vec<usize> {
    let count = distances.count();
    let scale = -0.5 / (bandwidth * bandwidth);
    let next: Vec<usize> = (0..count)
        .map(|at| {
            let kernel: Vec<f64> = (0..count)
                .map(|other| libm::exp(scale * distances.get(at, other).powi(2)))
                .collect();
            let cost = |to: usize| -> f64 {
                kernel
                    .iter()
                    .enumerate()
                    .map(|(other, k)| k * distances.get(to, other).powi(2))
                    .sum()
            };
            // It stays rather than go where it is no better.
            let stay = (cost(at), at);
            (0..count)
                .map(|to| (cost(to), to))
                .fold(stay, |best, other| if other.0 < best.0 { other } else { best })
                .1
        })
        .collect();
    let mode = |mut at: usize| {
        // Costs fall along the way, but each by its own kernel: a round trip ends at its smallest member.
        let mut seen = vec![at];
        while next[at] != at {
            at = next[at];
            if let Some(first) = seen.iter().position(|before| *before == at) {
                return *seen[first..].iter().min().expect("a round trip has members");
            }
            seen.push(at);
        }
        at
    };
    let mut modes = Vec::new();
    (0..count)
        .map(|thing| {
            let mode = mode(thing);
            modes.iter().position(|other| *other == mode).unwrap_or_else(|| {
                modes.push(mode);
                modes.len() - 1
            })
        })
        .collect()
}

/// The smallest of a hundred bandwidths, evenly spread on a logarithmic scale from a hundredth of the largest distance to
/// that itself, that makes `wanted` clusters of at least two things each, and those clusters; `None` if none does.
pub fn with_clusters(distances: &Distances, wanted: usize) -> Option<(f64, Vec<usize>)> {
    let count = distances.count();
    let pairs = (0..count).flat_map(|a| (0..a).map(move |b| (a, b)));
    let largest = pairs.map(|(a, b)| distances.get(a, b)).fold(0.0, f64::max);
    (0..=100).map(|step| largest * libm::pow(0.01, 1.0 - f64::from(step) / 100.0)).find_map(
        |bandwidth| {
            let of = clusters(distances, bandwidth);
            let found = of.iter().max().map_or(0, |last| last + 1);
            let members = |cluster: usize| of.iter().filter(|own| **own == cluster).count();
            (found == wanted && (0..found).all(|cluster| members(cluster) >= 2))
                .then_some((bandwidth, of))
        },
    )
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
        let (bandwidth, of) = with_clusters(&distances, 2).unwrap();
        assert!(bandwidth > 0.1 && bandwidth < 2.0, "{bandwidth}");
        assert!(of.iter().enumerate().all(|(thing, cluster)| *cluster == thing % 2), "{of:?}");
        assert_eq!(clusters(&distances, 100.0), vec![0; 20]);
        assert!(with_clusters(&distances, 50).is_none());
    }
}
