//! A condition that must last.

/// How long something has lasted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Debounce {
    for_s: f64,
}

impl Debounce {
    /// Time passes. Whether the condition has now lasted for so long.
    pub fn lasts(&mut self, condition: bool, dt_s: f64, long_s: f64) -> bool {
        self.for_s = if condition { self.for_s + dt_s } else { 0.0 };
        condition && self.for_s >= long_s
    }
}
