//! The two kinds of errors.

use sinew_evaluation::ErrorTotals;

/// A kind of error, with its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// Angular errors, in degrees.
    Angular,
    /// Linear errors, in centimetres.
    Linear,
}

impl Quantity {
    pub(crate) const BOTH: [Self; 2] = [Self::Angular, Self::Linear];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Angular => "angular",
            Self::Linear => "linear",
        }
    }

    pub(crate) const fn unit(self) -> &'static str {
        match self {
            Self::Angular => "°",
            Self::Linear => "cm",
        }
    }

    pub(super) fn mean(self, totals: &ErrorTotals) -> f64 {
        match self {
            Self::Angular => totals.angular_mean_deg(),
            Self::Linear => totals.linear_mean_cm(),
        }
    }

    pub(super) fn max(self, totals: &ErrorTotals) -> f64 {
        match self {
            Self::Angular => totals.angular_max_deg(),
            Self::Linear => totals.linear_max_cm(),
        }
    }
}
