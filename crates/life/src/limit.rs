//! Keeps a motion within a joint's speed and acceleration, in its own time.

/// Shares of the limits of speed and acceleration that a motion uses. A show's splines need the rest.
const SPEED_SHARE: f64 = 0.9;
const ACCELERATION_SHARE: f64 = 0.75;
/// The widest smoothing, s. Two means one after the other smooth over twice their width.
const SMOOTH_MAX_S: f64 = 0.12;

/// A motion within limits.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Limited {
    /// Values at the given rate, already made smaller.
    pub(crate) values: Vec<f64>,
    /// Width of the smoothing, s; 0: none.
    pub(crate) smoothed_s: f64,
    /// Largest speed, per s.
    pub(crate) fastest: f64,
    /// Share of the values that is left; 1: all.
    pub(crate) share: f64,
}

/// Smooths values until they keep the limits of speed and acceleration, over 120 ms at most, and then makes them
/// smaller. The smoothing is symmetric: nothing comes later. Limits hold for every `step`-th value.
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

/// Returns the mean of each value and of `half` values on both sides. Before the beginning and after the end the value
/// is that of the nearer end. O(n).
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

/// Returns the largest first and second derivative of every `step`-th value, as they are written.
fn peaks(values: &[f64], rate_hz: f64, step: usize) -> [f64; 2] {
    let rows: Vec<f64> = values.iter().step_by(step).copied().collect();
    let speed = rows.windows(2).map(|w| (w[1] - w[0]).abs() * rate_hz);
    let acceleration =
        rows.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs() * rate_hz * rate_hz);
    [speed.fold(0.0, f64::max), acceleration.fold(0.0, f64::max)]
}
