//! Isomap: distances along a graph of near neighbours, for [`super::mds`].

use sinew_pose_metrics::spatial::Distances;

/// Returns distances along the graph that connects each item with its `neighbours` nearest ones (Tenenbaum, de Silva
/// & Langford 2000), between the items of the largest connected part, whose indices are returned first. O(n³).
pub fn along_neighbours(distances: &Distances, neighbours: usize) -> (Vec<usize>, Distances) {
    let count = distances.count();
    let nearest = |a: usize| {
        let mut others: Vec<usize> = (0..count).filter(|b| *b != a).collect();
        others.sort_by(|b, c| distances.get(a, *b).total_cmp(&distances.get(a, *c)).then(b.cmp(c)));
        others.into_iter().take(neighbours).map(move |b| (a, b))
    };
    let mut along = vec![vec![f64::INFINITY; count]; count];
    for (a, row) in along.iter_mut().enumerate() {
        row[a] = 0.0;
    }
    for (a, b) in (0..count).flat_map(nearest) {
        let distance = distances.get(a, b);
        (along[a][b], along[b][a]) = (distance, distance);
    }
    // Floyd-Warshall.
    for via in 0..count {
        let through = along[via].clone();
        for row in &mut along {
            let to_via = row[via];
            if to_via.is_finite() {
                for (way, rest) in row.iter_mut().zip(&through) {
                    *way = way.min(to_via + rest);
                }
            }
        }
    }
    let reached = |a: usize| along[a].iter().filter(|way| way.is_finite()).count();
    let center = (0..count).rev().max_by_key(|a| reached(*a));
    let together: Vec<usize> = center.map_or(Vec::new(), |center| {
        (0..count).filter(|b| along[center][*b].is_finite()).collect()
    });
    #[expect(clippy::cast_possible_truncation, reason = "distances are kept in f32")]
    let distance = |(): &mut (), a: usize, b: usize| along[together[a]][together[b]] as f32;
    let joined = Distances::new(together.len(), || (), distance, |_| ());
    (together, joined)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_goes_along_the_arc() {
        // Points on three quarters of a circle, and four far away.
        let angle = |thing: usize| 0.05 * thing as f32;
        let place = |thing: usize| match thing {
            0..95 => [angle(thing).cos(), angle(thing).sin()],
            _ => [50.0, 0.1 * thing as f32],
        };
        let apart = |(): &mut (), a, b| {
            let (a, b) = (place(a), place(b));
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        let (together, _) = along_neighbours(&Distances::new(99, || (), apart, |_| ()), 1);
        assert!(together.len() < 95, "with one neighbour it falls apart");
        let (together, along) = along_neighbours(&Distances::new(99, || (), apart, |_| ()), 2);
        assert_eq!(together, (0..95).collect::<Vec<_>>());
        assert!((along.get(0, 94) - 0.05 * 94.0).abs() < 0.01);
    }
}
