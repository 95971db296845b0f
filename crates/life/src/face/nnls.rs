//! Non-negative least squares with few unknowns.

/// Maximum number of rounds over all unknowns, and the largest change in a round that ends the search.
const ROUNDS: usize = 400;
const SMALL: f64 = 1e-7;
/// Weight of the distance from the wanted weights, relative to a shape's own offsets. If several solutions are equally
/// good, this term selects one.
const HOLD: f64 = 1e-3;

/// Returns the non-negative weights for which the weighted sum of `columns` is nearest to `target`. Among nearly equal
/// solutions, the nearest to `wanted` is preferred. Coordinate descent: O(rounds · columns · rows).
pub(super) fn nnls(columns: &[Vec<f64>], target: &[f64], wanted: &[f64]) -> Vec<f64> {
    // First scales all weights together: coordinate descent alone is slow to reduce overlapping shapes equally.
    let sum = |weights: &[f64], row: usize| -> f64 {
        columns.iter().zip(weights).map(|(column, weight)| weight * column[row]).sum()
    };
    let [mut product, mut square] = [0.0; 2];
    for (row, target) in target.iter().enumerate() {
        let sum = sum(wanted, row);
        product += sum * target;
        square += sum * sum;
    }
    let share = if square > 0.0 { f64::max(product / square, 0.0) } else { 1.0 };
    let mut weights: Vec<f64> = wanted.iter().map(|weight| share * weight).collect();
    let mut rest: Vec<f64> = target.to_vec();
    let subtract = |rest: &mut [f64], column: &[f64], change: f64| {
        for (rest, value) in rest.iter_mut().zip(column) {
            *rest -= change * value;
        }
    };
    for (column, weight) in columns.iter().zip(&weights) {
        subtract(&mut rest, column, *weight);
    }
    for _ in 0..ROUNDS {
        let mut largest = 0.0_f64;
        for (index, column) in columns.iter().enumerate() {
            let square: f64 = column.iter().map(|value| value * value).sum();
            if square <= 0.0 {
                continue;
            }
            let slope: f64 = column.iter().zip(&rest).map(|(value, rest)| value * rest).sum();
            let pull = HOLD * square * (wanted[index] - weights[index]);
            let change = ((slope + pull) / (square * (1.0 + HOLD))).max(-weights[index]);
            weights[index] += change;
            subtract(&mut rest, column, change);
            largest = largest.max(change.abs());
        }
        if largest < SMALL {
            break;
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_the_nearest_that_are_not_negative() {
        // Shapes that move different joints keep their weights.
        let apart = [vec![2.0, 0.0], vec![0.0, 1.0]];
        let found = nnls(&apart, &[1.0, 0.5], &[0.5, 0.5]);
        assert!((found[0] - 0.5).abs() < 1e-6 && (found[1] - 0.5).abs() < 1e-6, "{found:?}");
        // Two shapes that move the same joint share the reachable 1.5 of 2.
        let both = [vec![1.0], vec![1.0]];
        let found = nnls(&both, &[1.5], &[1.0, 1.0]);
        assert!((found[0] - 0.75).abs() < 1e-3 && (found[1] - 0.75).abs() < 1e-3, "{found:?}");
        // A target of the opposite sign cannot be reached.
        let found = nnls(&[vec![1.0]], &[-1.0], &[0.0]);
        assert!(found[0].abs() < 1e-12, "{found:?}");
        // The exact solution of a problem with an active bound: min (x + y - 1)² + (x - y - 2)².
        let found = nnls(&[vec![1.0, 1.0], vec![1.0, -1.0]], &[1.0, 2.0], &[0.0, 0.0]);
        assert!((found[0] - 1.5).abs() < 5e-3 && found[1].abs() < 1e-9, "{found:?}");
    }
}
