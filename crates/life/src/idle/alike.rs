//! The similarity of windows of a loop.

/// Rate of the samples that are compared, Hz.
const RATE_HZ: f64 = 5.0;
/// Number of samples of a window: 10 s.
const WINDOW: usize = 50;
/// Largest number of windows. All pairs of them are compared.
const WINDOWS_MAX: usize = 1200;

/// Returns the largest correlation between two windows of 10 s that do not overlap. Each coordinate is scaled to the
/// same variance over the loop, and its mean in a window is subtracted. `at` returns the coordinates at a time within
/// the loop, s.
pub(super) fn most_alike(loop_s: f64, at: impl Fn(f64) -> Vec<f64>) -> f64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
    let count = (loop_s * RATE_HZ).floor() as usize;
    let rows: Vec<Vec<f64>> = (0..count).map(|row| at(row as f64 / RATE_HZ)).collect();
    let width = rows.first().map_or(0, Vec::len);
    let column = |column: usize| {
        let mut column: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        centre(&mut column);
        let square = column.iter().map(|x| x * x).sum::<f64>() / count as f64;
        let scale = if square > 0.0 { square.sqrt().recip() } else { 0.0 };
        for x in &mut column {
            *x *= scale;
        }
        column
    };
    let columns: Vec<Vec<f64>> = (0..width).map(column).collect();
    let step = count.div_ceil(WINDOWS_MAX).max(1);
    let window = |start: usize| {
        let mut window = Vec::with_capacity(width * WINDOW);
        for column in &columns {
            let mut part: Vec<f64> = (0..WINDOW).map(|k| column[(start + k) % count]).collect();
            centre(&mut part);
            window.extend(part);
        }
        let length = window.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        for x in &mut window {
            *x /= length;
        }
        (start, window)
    };
    let windows: Vec<(usize, Vec<f64>)> = (0..count).step_by(step).map(window).collect();
    let mut most = -1.0;
    for (index, (start, one)) in windows.iter().enumerate() {
        for (later, other) in &windows[index + 1..] {
            let apart = later - start;
            if apart >= WINDOW && count - apart >= WINDOW {
                let product: f64 = one.iter().zip(other).map(|(a, b)| a * b).sum();
                most = f64::max(most, product);
            }
        }
    }
    most
}

/// Subtracts the mean from values.
fn centre(values: &mut [f64]) {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    for x in values {
        *x -= mean;
    }
}
