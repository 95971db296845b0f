//! Reduces a motion until it keeps a joint's limits of speed and acceleration, without changing its time.

/// Shares of the limits of speed and acceleration that a motion may use. The rest is for the errors of a show's
/// splines.
const SPEED_SHARE: f64 = 0.9;
const ACCELERATION_SHARE: f64 = 0.75;
/// Maximum width of the smoothing, s. Two moving means in succession have twice the width of one.
const SMOOTH_MAX_S: f64 = 0.12;

/// A motion within its limits.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Limited {
    /// Values at the given rate, after smoothing and reducing.
    pub(crate) values: Vec<f64>,
    /// Width of the smoothing, s; 0 without smoothing.
    pub(crate) smoothed_s: f64,
    /// Largest speed, in units of the values per s.
    pub(crate) fastest: f64,
    /// Factor by which the values were reduced; 1 if they were not.
    pub(crate) share: f64,
}

/// Reduces a motion until it keeps the limits of speed and acceleration: first smooths it, over 120 ms at most, then
/// multiplies it by a factor. The smoothing is symmetric and causes no delay. Only every `step`-th value must keep the
/// limits.
pub(crate) fn within(
    values: &[f64],
    rate_hz: f64,
    step: usize,
    [speed, acceleration]: [f64; 2],
) -> Limited {
    let limits = [SPEED_SHARE * speed, ACCELERATION_SHARE * acceleration];
    let mut half = 0;
    loop {
        let mut smooth = mean_around(&mean_around(values, half), half);
        let needed = peaks(&smooth, rate_hz / step as f64, step);
        let share = needed
            .iter()
            .zip(limits)
            .map(|(needed, limit)| if *needed > limit { limit / needed } else { 1.0 })
            .fold(1.0, f64::min);
        if share < 1.0 && (4 * (half + 1)) as f64 <= SMOOTH_MAX_S * rate_hz + 1e-9 {
            half += 1;
            continue;
        }
        for value in &mut smooth {
            *value *= share;
        }
        let smoothed_s = (4 * half) as f64 / rate_hz;
        return Limited { values: smooth, smoothed_s, fastest: share * needed[0], share };
    }
}

/// Returns the mean of each value and its `half` neighbours on each side. Beyond the ends, the first or the last value
/// is repeated. O(n).
fn mean_around(values: &[f64], half: usize) -> Vec<f64> {
    let Some(last) = values.len().checked_sub(1).filter(|_| half > 0) else {
        return values.to_vec();
    };
    let value = |at: usize| values[at.saturating_sub(half).min(last)];
    let mut sum: f64 = (0..=2 * half).map(value).sum();
    (0..=last)
        .map(|at| {
            let mean = sum / (2 * half + 1) as f64;
            sum += value(at + 2 * half + 1) - value(at);
            mean
        })
        .collect()
}

/// Returns the largest absolute first and second derivative of every `step`-th value; `rate_hz` is the rate of these
/// values.
fn peaks(values: &[f64], rate_hz: f64, step: usize) -> [f64; 2] {
    let rows: Vec<f64> = values.iter().step_by(step).copied().collect();
    let speed = rows.windows(2).map(|w| (w[1] - w[0]).abs() * rate_hz);
    let acceleration =
        rows.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs() * rate_hz * rate_hz);
    [speed.fold(0.0, f64::max), acceleration.fold(0.0, f64::max)]
}
