//! The likeness of two windows of a loop.

/// Samples per s of the comparison.
const RATE_HZ: f64 = 5.0;
/// Samples of a window: 10 s.
const WINDOW: usize = 50;
/// Largest number of windows that are compared with each other.
const WINDOWS_MAX: usize = 1200;

/// Returns the largest correlation between two windows of 10 s that do not overlap. Each coordinate counts alike, and
/// its mean in a window is taken out. `at` returns the coordinates at a time, s, within the loop.
pub(super) fn most_alike(loop_s: f64, at: impl Fn(f64) -> Vec<f64>) -> f64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
    let count = (loop_s * RATE_HZ).floor() as usize;
    let mut rows: Vec<Vec<f64>> = (0..count).map(|row| at(row as f64 / RATE_HZ)).collect();
    let width = rows.first().map_or(0, Vec::len);
    for column in 0..width {
        let values = || rows.iter().map(|row| row[column]);
        let mean = values().sum::<f64>() / count as f64;
        let square = values().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count as f64;
        let scale = if square > 0.0 { square.sqrt().recip() } else { 0.0 };
        rows.iter_mut().for_each(|row| row[column] = (row[column] - mean) * scale);
    }
    let step = count.div_ceil(WINDOWS_MAX).max(1);
    let window = |start: usize| {
        let mut window = Vec::with_capacity(width * WINDOW);
        for column in 0..width {
            let values = || (0..WINDOW).map(|k| rows[(start + k) % count][column]);
            let mean = values().sum::<f64>() / WINDOW as f64;
            window.extend(values().map(|x| x - mean));
        }
        let length = window.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        window.iter_mut().for_each(|x| *x /= length);
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
