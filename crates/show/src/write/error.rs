//! Errors of writing a show.

/// A reason for which a motion cannot be written as a show.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The numbers are not a whole number of samples, or there are too few samples.
    #[error(
        "{found} numbers are not whole samples of {per_sample} coordinates, or fewer than {least} of them"
    )]
    Count {
        /// Number of numbers.
        found: usize,
        /// Numbers per sample.
        per_sample: usize,
        /// Minimum number of samples.
        least: usize,
    },
    /// A number is NaN or too large.
    #[error(
        "sample {sample}, coordinate {coordinate} is {value}; it must be a number from -1e6 to 1e6"
    )]
    Number {
        /// Index of the sample.
        sample: usize,
        /// Index of the coordinate.
        coordinate: usize,
        /// The invalid number.
        value: f64,
    },
    /// A quaternion is not of length 1.
    #[error(
        "sample {sample}, joint {joint}: the quaternion has squared length {squared}; it must be a unit quaternion"
    )]
    NotUnit {
        /// Index of the sample.
        sample: usize,
        /// Index of the joint.
        joint: usize,
        /// Squared length of the quaternion.
        squared: f64,
    },
    /// An angle changes by more than half a turn from sample to sample.
    #[error(
        "joint {joint}: the angle changes by {step} rad before sample {sample}; do not wrap it at a full turn"
    )]
    Leap {
        /// Index of the joint.
        joint: usize,
        /// Index of the sample after the jump.
        sample: usize,
        /// Size of the jump, rad.
        step: f64,
    },
    /// The end of a loop is not close to its start.
    #[error(
        "joint {joint}: the loop's last sample is {seam} from its first, its largest step is {largest}; blend them"
    )]
    Seam {
        /// Index of the joint.
        joint: usize,
        /// Distance from the last sample to the first, rad or m.
        seam: f64,
        /// Largest step between samples, rad or m.
        largest: f64,
    },
    /// A setting is invalid.
    #[error("{name} is {value}; it must be {must}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// The invalid value.
        value: f64,
        /// Description of the valid values.
        must: &'static str,
    },
    /// A cue is invalid.
    #[error("cue {cue} {why}")]
    Cue {
        /// Index of the cue.
        cue: usize,
        /// Description of the problem.
        why: &'static str,
    },
    /// A pair of the time map of a slowed show is not after the previous pair, or is too large.
    #[error("pair {pair} of the course is not after the one before it, or is beyond 2^30 samples")]
    Course {
        /// Index of the pair.
        pair: usize,
    },
    /// The error bound cannot be reached.
    #[error(
        "joint {joint}: the error is {error} {unit} at sample {sample}, more than {bound}: too small for f32 there"
    )]
    Bound {
        /// Index of the joint.
        joint: usize,
        /// Index of the sample.
        sample: usize,
        /// Smallest error that was reached.
        error: f64,
        /// Requested maximum error.
        bound: f64,
        /// Unit of both errors.
        unit: &'static str,
    },
    /// A count is too large.
    #[error("the show has {found} {what}; a show holds {most}")]
    TooMuch {
        /// Name of the count.
        what: &'static str,
        /// Actual count.
        found: usize,
        /// Maximum count.
        most: usize,
    },
}
