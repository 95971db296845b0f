//! Measures how far a joint oscillates.

use std::f64::consts::{SQRT_2, TAU};

/// Corner of the high-pass filter, Hz: a slower motion is not a swing. The board's detector has a steeper filter,
/// since it must find no swing in any show.
const CORNER_HZ: f64 = 8.0;
/// Time constant of the mean square, s.
const WINDOW_S: f64 = 0.5;

/// Measures oscillation of a joint's error above about 8 Hz: the largest mean square over about 0.5 s, after two
/// high-pass filters of one pole each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SwingMeter {
    corner: f64,
    window: f64,
    slow: [f64; 2],
    mean_square: f64,
    most: f64,
}

impl SwingMeter {
    /// Creates a meter for `rate_hz` errors per second.
    pub fn new(rate_hz: f64) -> Self {
        let part = |time_s: f64| 1.0 / rate_hz.mul_add(time_s, 1.0);
        let (corner, window) = (part(1.0 / (TAU * CORNER_HZ)), part(WINDOW_S));
        Self { corner, window, slow: [0.0; 2], mean_square: 0.0, most: 0.0 }
    }

    /// Adds the next error, rad or m. An unknown error resets the filter.
    pub fn note(&mut self, error: f64) {
        if !error.is_finite() {
            (self.slow, self.mean_square) = ([0.0; 2], 0.0);
            return;
        }
        let mut rest = error;
        for slow in &mut self.slow {
            let before = *slow;
            *slow += self.corner * (rest - before);
            // The value in the middle of the tick; otherwise the tick's length would matter.
            rest -= 0.5 * (before + *slow);
        }
        self.mean_square += self.window * (rest * rest - self.mean_square);
        self.most = self.most.max(self.mean_square);
    }

    /// Returns the peak-to-peak amplitude of a sine with the largest mean square, rad or m.
    pub fn peak_to_peak(&self) -> f64 {
        2.0 * SQRT_2 * self.most.sqrt()
    }
}
