//! Correlation of all pairs of windows of a long motion.

/// Rows of a window: 10 s at 5 rows per second.
const WINDOW: usize = 50;

/// Returns the largest correlation of two windows that do not overlap, and the first rows of both. Windows begin at
/// every row: a blink takes as long as a row, so a wider grid would miss windows that are alike. Each column is scaled
/// to the same variance, and its mean in a window is subtracted. Only windows whose rows are all in `kept` count.
///
/// For each distance of two windows, the sum of products moves along by a row at a time: O(rows² · columns).
pub(crate) fn most_alike(rows: &[Vec<f64>], kept: &[bool]) -> (f64, [usize; 2]) {
    let columns = scaled(rows, kept);
    let count = rows.len();
    let width = columns.len();
    let values: Vec<f64> =
        (0..count).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
    let row_at = |row: usize| &values[row * width..(row + 1) * width];
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let starts = (count + 1).saturating_sub(WINDOW);
    let is_whole: Vec<bool> =
        (0..starts).map(|start| kept[start..start + WINDOW].iter().all(|kept| *kept)).collect();
    // Means of each window, and its length after they are subtracted.
    let (mut means, mut lengths) = (Vec::with_capacity(starts * width), Vec::with_capacity(starts));
    for start in 0..starts {
        let mut square = 0.0;
        for column in &columns {
            let part = &column[start..start + WINDOW];
            let mean = part.iter().sum::<f64>() / WINDOW as f64;
            square += part.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
            means.push(mean);
        }
        lengths.push(square.sqrt());
    }
    let mean_at = |start: usize| &means[start * width..(start + 1) * width];
    let mut most = (-1.0, [0, 0]);
    for apart in WINDOW..starts {
        let product = |row: usize| dot(row_at(row), row_at(row + apart));
        let mut sum: f64 = (0..WINDOW).map(product).sum();
        for start in 0..starts - apart {
            if start > 0 {
                sum += product(start + WINDOW - 1) - product(start - 1);
            }
            let later = start + apart;
            if is_whole[start] && is_whole[later] {
                let shared = sum - WINDOW as f64 * dot(mean_at(start), mean_at(later));
                let alike = shared / (lengths[start] * lengths[later]);
                if alike > most.0 {
                    most = (alike, [start, later]);
                }
            }
        }
    }
    most
}

/// Returns the columns that move, scaled to a variance of 1 in the kept rows.
fn scaled(rows: &[Vec<f64>], kept: &[bool]) -> Vec<Vec<f64>> {
    let width = rows.first().map_or(0, Vec::len);
    let column = |column: usize| {
        let values =
            || rows.iter().zip(kept).filter(|(_, kept)| **kept).map(|(row, _)| row[column]);
        let count = values().count() as f64;
        let mean = values().sum::<f64>() / count;
        let variance = values().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
        // Sums are over 20 ticks: 1e-3 rad of a sum is 0.003 deg.
        (variance.sqrt() > 1e-3)
            .then(|| rows.iter().map(|row| (row[column] - mean) / variance.sqrt()).collect())
    };
    (0..width).filter_map(column).collect()
}

#[test]
fn a_window_that_returns_is_found() {
    // Pseudo-random walks in three columns; 60 rows return, with a small change.
    let mut state = 1_u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(u32::MAX) - 0.25
    };
    let mut rows: Vec<Vec<f64>> = (0..600).map(|_| (0..3).map(|_| random()).collect()).collect();
    let all = vec![true; rows.len()];
    let (most, _) = most_alike(&rows, &all);
    assert!(most < 0.6, "{most}");
    for row in 0..60 {
        let again = rows[100 + row].iter().map(|x| 0.5 * x + 3.0).collect();
        rows[437 + row] = again;
    }
    let (most, [from, to]) = most_alike(&rows, &all);
    assert!(most > 0.99 && to - from == 337, "{most} {from} {to}");
    let mut kept = all;
    kept[450] = false;
    assert!(most_alike(&rows, &kept).0 < 0.6);
}
