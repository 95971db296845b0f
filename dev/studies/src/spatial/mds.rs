//! Classical multidimensional scaling: places in few dimensions whose distances approximate given ones.

use nalgebra::{DMatrix, SymmetricEigen};

use sinew_pose_metrics::spatial::Distances;

/// Places of items, along the directions of largest spread.
#[derive(Debug, Clone, PartialEq)]
pub struct Embedding {
    /// Places by item, then by component, in the distances' unit; every component's largest entry is positive.
    pub places: Vec<Vec<f64>>,
    /// Shares of all components.
    pub spectrum: Spectrum,
}

/// Share of the items' spread in every component.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Share of every component in the sum of all positive eigenvalues, largest first; empty if all items are at one
    /// place.
    pub shares: Vec<f64>,
    /// The sum of all negative eigenvalues relative to that of the positive ones: the deviation of the distances from
    /// those of points in a Euclidean space.
    pub negative_share: f64,
}

/// Returns places in at most `components` dimensions (Torgerson 1952). O(n³).
pub fn classical(distances: &Distances, components: usize) -> Embedding {
    let count = distances.count();
    let eigen = SymmetricEigen::new(products(distances));
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let values: Vec<f64> = order.iter().map(|index| eigen.eigenvalues[*index]).collect();
    let mut places = vec![Vec::new(); count];
    for (index, value) in order.iter().zip(&values).take(components) {
        let vector = eigen.eigenvectors.column(*index);
        let sign = vector[vector.icamax()].signum();
        for (place, entry) in places.iter_mut().zip(vector.iter()) {
            place.push(sign * entry * libm::sqrt(value.max(0.0)));
        }
    }
    Embedding { places, spectrum: Spectrum::new(&values) }
}

/// Returns the shares of all components without the places: a few times faster. O(n³).
pub fn spectrum(distances: &Distances) -> Spectrum {
    let mut values = products(distances).symmetric_eigenvalues().as_slice().to_vec();
    values.sort_by(|a, b| b.total_cmp(a));
    Spectrum::new(&values)
}

/// Returns the scalar products of the places relative to their centre: `-½ J D² J`.
fn products(distances: &Distances) -> DMatrix<f64> {
    let count = distances.count();
    let squared = DMatrix::from_fn(count, count, |i, j| distances.get(i, j).powi(2));
    let by_row: Vec<f64> = (0..count).map(|row| squared.row(row).sum() / count as f64).collect();
    let all = by_row.iter().sum::<f64>() / count as f64;
    DMatrix::from_fn(count, count, |i, j| -0.5 * (squared[(i, j)] - by_row[i] - by_row[j] + all))
}

impl Spectrum {
    /// Creates a spectrum from eigenvalues, the largest first.
    fn new(values: &[f64]) -> Self {
        let positive: f64 = values.iter().filter(|value| **value > 0.0).sum();
        let negative: f64 = values.iter().filter(|value| **value < 0.0).sum();
        let shares = values.iter().filter(|value| **value > 0.0).map(|value| value / positive);
        Self {
            shares: shares.collect(),
            negative_share: if positive > 0.0 { -negative / positive } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_have_the_distances_they_were_made_of() {
        let corners = [[0.0f32, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0], [1.5, 0.5]];
        let distances = Distances::new(
            5,
            || (),
            |(), a, b| (corners[a][0] - corners[b][0]).hypot(corners[a][1] - corners[b][1]),
            |_| (),
        );
        let embedding = classical(&distances, 2);
        for a in 0..5 {
            for b in 0..5 {
                let apart: f64 = (0..2)
                    .map(|axis| (embedding.places[a][axis] - embedding.places[b][axis]).powi(2))
                    .sum();
                assert!((apart.sqrt() - distances.get(a, b)).abs() < 1e-6);
            }
        }
        // The rectangle has sides of 3 and 1: nine tenths of the spread is along the longer side.
        let Spectrum { shares, negative_share } = &embedding.spectrum;
        assert!((shares[0] - 0.9).abs() < 1e-6, "{shares:?}");
        assert!(*negative_share < 1e-6);
        let alone = spectrum(&distances);
        assert!((alone.shares[0] - shares[0]).abs() < 1e-12, "{alone:?}");
    }
}
