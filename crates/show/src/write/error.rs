//! Why there is no show of a motion.

/// Why there is no show of a motion.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The samples are not whole.
    #[error(
        "{found} numbers are not whole samples of {per_sample} coordinates, or fewer than {least} of them"
    )]
    Count {
        /// How many numbers there are.
        found: usize,
        /// How many a sample has.
        per_sample: usize,
        /// How many samples there must be.
        least: usize,
    },
    /// A number is NaN or too large.
    #[error(
        "sample {sample}, coordinate {coordinate} is {value}; it must be a number from -1e6 to 1e6"
    )]
    Number {
        /// Which sample.
        sample: usize,
        /// Which coordinate.
        coordinate: usize,
        /// The number.
        value: f64,
    },
    /// A quaternion is not of length 1.
    #[error(
        "sample {sample}, joint {joint}: the quaternion has squared length {squared}; it must be a unit quaternion"
    )]
    NotUnit {
        /// Which sample.
        sample: usize,
        /// Which joint.
        joint: usize,
        /// Its squared length.
        squared: f64,
    },
    /// An angle changes by more than half a turn from sample to sample.
    #[error(
        "joint {joint}: the angle changes by {step} rad before sample {sample}; do not wrap it at a full turn"
    )]
    Leap {
        /// Which joint.
        joint: usize,
        /// The sample behind the leap.
        sample: usize,
        /// How far, rad.
        step: f64,
    },
    /// The end of a loop is not next to its beginning.
    #[error(
        "joint {joint}: the loop's last sample is {seam} from its first, its largest step is {largest}; blend them"
    )]
    Seam {
        /// Which joint.
        joint: usize,
        /// How far the first sample is from the last one, rad or m.
        seam: f64,
        /// The largest step between samples, rad or m.
        largest: f64,
    },
    /// A setting cannot be.
    #[error("{name} is {value}; it must be {must}")]
    Setting {
        /// Which one.
        name: &'static str,
        /// The value that was found.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A cue cannot be.
    #[error("cue {cue} {why}")]
    Cue {
        /// Which one.
        cue: usize,
        /// Why.
        why: &'static str,
    },
    /// The course of a slowed show goes back.
    #[error("pair {pair} of the course is not after the one before it, or is beyond 2^30 samples")]
    Course {
        /// Which one.
        pair: usize,
    },
    /// The bound cannot be held.
    #[error(
        "joint {joint}: the error is {error} {unit} at sample {sample}, more than {bound}: too small for f32 there"
    )]
    Bound {
        /// Which joint.
        joint: usize,
        /// In which sample.
        sample: usize,
        /// The error.
        error: f64,
        /// The largest error that was asked for.
        bound: f64,
        /// Of both.
        unit: &'static str,
    },
    /// There is too much of something.
    #[error("the show has {found} {what}; a show holds {most}")]
    TooMuch {
        /// Of what.
        what: &'static str,
        /// How much there is.
        found: usize,
        /// How much there may be.
        most: usize,
    },
}
