//! The Pareto front of two errors: the points where neither error can decrease without an increase of the other.

/// Returns, for each point, whether it is on the Pareto front of two errors, smaller being better: no other point
/// is equal or better in both errors and better in one. Equal points are on it together; a point with a NaN is
/// not.
///
/// ```
/// use sinew_evaluation::pareto::on_front;
/// // Angle and distance; the last one is worse than the first in both.
/// assert_eq!(on_front(&[[1.0, 5.0], [4.0, 2.0], [3.0, 6.0]]), [true, true, false]);
/// ```
pub fn on_front(points: &[[f64; 2]]) -> Vec<bool> {
    let is_number = |point: &[f64; 2]| !point.iter().any(|error| error.is_nan());
    let mut order: Vec<usize> = (0..points.len()).filter(|at| is_number(&points[*at])).collect();
    // +0 and -0 are one value.
    let compare = |a: usize, b: usize, error: usize| {
        (points[a][error] + 0.0).total_cmp(&(points[b][error] + 0.0))
    };
    order.sort_by(|a, b| compare(*a, *b, 0).then(compare(*a, *b, 1)));
    let mut on_front = vec![false; points.len()];
    // Among points with an equal first error, the best in the second error is first.
    let mut best: Option<usize> = None;
    for at in order {
        let same = |best| compare(at, best, 0).is_eq() && compare(at, best, 1).is_eq();
        if best.is_none_or(|best| compare(at, best, 1).is_lt() || same(best)) {
            on_front[at] = true;
            best = Some(at);
        }
    }
    on_front
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_host_util::random::{Random, Subject};

    #[test]
    fn what_no_other_point_betters_is_on_the_front() {
        let mut random = Random::new(1, Subject::Noise);
        for count in 0..60 {
            // Coarse values: many points are equal in one error or in both.
            let coarse: Vec<[usize; 2]> =
                (0..count).map(|_| [random.below(8), random.below(8)]).collect();
            let betters = |a: &[usize; 2], b: &[usize; 2]| a[0] <= b[0] && a[1] <= b[1] && a != b;
            let expected: Vec<bool> = coarse
                .iter()
                .map(|point| !coarse.iter().any(|other| betters(other, point)))
                .collect();
            let points: Vec<[f64; 2]> =
                coarse.iter().map(|point| point.map(|error| error as f64)).collect();
            assert_eq!(on_front(&points), expected, "{points:?}");
        }
    }

    #[test]
    fn what_is_no_number_neither_is_on_the_front_nor_keeps_others_off() {
        let nan = f64::NAN;
        let points = [[nan, 0.0], [0.0, nan], [1.0, 1.0], [f64::INFINITY, 0.0]];
        assert_eq!(on_front(&points), [false, false, true, true]);
    }
}
