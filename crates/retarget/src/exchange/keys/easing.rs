//! Easings: courses of the motion from a key to the next.

/// The course of the motion from a key to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Easing {
    /// Holds the key's value, then moves with 90 % of the joint's limits, and arrives at the next key's time.
    Step,
    /// Moves at constant speed.
    Linear,
    /// Begins at rest.
    In,
    /// Ends at rest.
    Out,
    /// Begins and ends at rest.
    Both,
    /// Follows a cubic whose speed is continuous at the keys, and which never leaves the values of the two keys.
    #[default]
    Cubic,
}

impl Easing {
    /// Reads the name of an easing, in any case, with or without "ease" before it; words may be joined by `-` or `_`.
    /// Returns `None` for an unknown name.
    pub(super) fn named(text: &str) -> Option<Self> {
        let words = text.trim().to_lowercase().replace(['-', '_'], " ");
        match words.strip_prefix("ease ").unwrap_or(&words) {
            "step" => Some(Self::Step),
            "linear" => Some(Self::Linear),
            "in" => Some(Self::In),
            "out" => Some(Self::Out),
            "both" | "in out" => Some(Self::Both),
            "cubic" => Some(Self::Cubic),
            _ => None,
        }
    }

    /// Returns the share of the change at a share of the time, both from 0 to 1; `None` for a step and a cubic, which
    /// depend on more data.
    pub(super) fn share(self, time: f64) -> Option<f64> {
        match self {
            Self::Linear => Some(time),
            Self::In => Some(time * time),
            Self::Out => Some(time * (2.0 - time)),
            Self::Both => Some(smooth(time)),
            Self::Step | Self::Cubic => None,
        }
    }

    /// Returns the speeds at the beginning and at the end, as factors of the mean speed; `None` for a cubic, which
    /// adapts to its neighbours.
    pub(super) fn end_speeds(self) -> Option<[f64; 2]> {
        match self {
            Self::Linear => Some([1.0, 1.0]),
            Self::In => Some([0.0, 2.0]),
            Self::Out => Some([2.0, 0.0]),
            Self::Step | Self::Both => Some([0.0, 0.0]),
            Self::Cubic => None,
        }
    }
}

/// Returns the share of a change that begins and ends at rest: 3 t² - 2 t³, t from 0 to 1.
pub(super) fn smooth(time: f64) -> f64 {
    time * time * (3.0 - 2.0 * time)
}
