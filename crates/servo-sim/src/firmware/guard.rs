//! Detects a condition that lasts for some time.

/// The time for which a condition has lasted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Debounce {
    for_s: f64,
}

impl Debounce {
    /// Advances by `dt_s`. Returns whether the condition has now lasted for `long_s`.
    pub fn lasts(&mut self, condition: bool, dt_s: f64, long_s: f64) -> bool {
        self.for_s = if condition { self.for_s + dt_s } else { 0.0 };
        condition && self.for_s >= long_s
    }
}
