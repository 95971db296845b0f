//! Importance of joints: weights from how much of the figure a joint moves, and how far.
//!
//! A small rotation of a joint moves all bodies beyond it, and it moves distant bodies farther. Three methods measure
//! this on a skeleton at rest: [`descendants_length`] from bones alone, [`cylinder_surface`] from bones with a
//! thickness, [`MeshSurface`] from a skinned mesh. The weights apply to errors of joint rotations, when not all errors
//! can be small.
//!
//! After D. Holden, "Joint Error Propagation" (2025).
//!
//! ```
//! use sinew_core::glam::Vec3;
//! use sinew_core::importance::{RestPose, descendants_length};
//! // A hip with two legs; joints may come in any order.
//! let parents = [Some(2), Some(0), None, Some(4), Some(2)];
//! let down = |x, y| Vec3::new(x, y, 0.0);
//! let positions_m = [down(0.1, 0.8), down(0.1, 0.4), down(0.0, 0.9), down(-0.1, 0.4), down(-0.1, 0.8)];
//! let legs = RestPose::<5>::new(&parents, &positions_m)?;
//! let importance = descendants_length(&legs, 0.1, 0.9)?;
//! let [left_hip, left_knee, root, right_knee, right_hip] = [0, 1, 2, 3, 4].map(|joint| importance.as_slice()[joint]);
//! assert_eq!((left_hip, left_knee), (right_hip, right_knee));
//! assert!(root > left_hip && left_hip > left_knee);
//! assert_eq!(left_knee, 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cylinder;
mod lengths;
mod mesh;
mod rest_pose;
mod samples;
mod sum;
mod weights;

use core::fmt;

use heapless::Vec;

use crate::fixed;
pub use cylinder::cylinder_surface;
pub use lengths::descendants_length;
pub use mesh::{MeshSurface, VertexError};
pub use rest_pose::{RestPose, RestPoseError};
pub use samples::{SurfaceSamples, cylinder_samples};
use sum::sum;

/// A weight for each joint, in the given order of joints: finite, zero or more, and not all zero.
///
/// The unit is that of the measure; [`Self::normalised`] removes it.
///
/// ```
/// use sinew_core::importance::{Importance, ImportanceError};
/// let importance = Importance::<4>::new(&[3.0, 1.0, 0.0])?;
/// assert_eq!(importance.normalised().as_slice(), [0.75, 0.25, 0.0]);
/// let refused = Importance::<4>::new(&[3.0, -1.0]);
/// assert_eq!(refused, Err(ImportanceError::Weight { joint: 1, value: -1.0 }));
/// # Ok::<(), ImportanceError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Importance<const N: usize> {
    weights: Vec<f32, N>,
}

impl<const N: usize> Importance<N> {
    /// Validates weights, one per joint. O(n).
    ///
    /// # Errors
    /// [`ImportanceError`] if there are more than `N` weights, a weight is negative or not finite, or their sum is
    /// zero or too large for f32.
    pub fn new(weights: &[f32]) -> Result<Self, ImportanceError> {
        if weights.len() > N {
            return Err(ImportanceError::Full { capacity: N });
        }
        let usable = |weight: f32| weight >= 0.0 && weight.is_finite();
        if let Some((joint, &value)) = weights.iter().enumerate().find(|(_, w)| !usable(**w)) {
            return Err(ImportanceError::Weight { joint, value });
        }
        let sum = sum(weights.iter().copied());
        if sum > 0.0 && sum.is_finite() {
            Ok(Self { weights: fixed::collect(weights.iter().copied()) })
        } else {
            Err(ImportanceError::Sum { value: sum })
        }
    }

    /// Returns the weights by joint.
    pub fn as_slice(&self) -> &[f32] {
        &self.weights
    }

    /// Returns the weights divided by their sum, within f32 rounding. O(n).
    #[must_use]
    pub fn normalised(&self) -> Self {
        let sum = sum(self.weights.iter().copied());
        Self { weights: fixed::collect(self.weights.iter().map(|weight| weight / sum)) }
    }
}

/// An error in weights of joints, or in the measures they are computed from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ImportanceError {
    /// There are more weights than the capacity.
    Full {
        /// Maximum number of weights.
        capacity: usize,
    },
    /// A weight is negative or not finite. It is not finite if the skeleton's measures are too large for f32.
    Weight {
        /// Index of the joint.
        joint: usize,
        /// Weight of the joint.
        value: f32,
    },
    /// All weights are zero, or their sum is too large for f32.
    Sum {
        /// Sum of the weights.
        value: f32,
    },
    /// The base weight, which every joint starts with, is negative or not finite.
    Base {
        /// Base weight of every joint.
        value: f32,
    },
    /// The discount is not from 0 to 1.
    Discount {
        /// Discount per joint.
        value: f32,
    },
    /// The number of radii is not the number of joints.
    RadiusCount {
        /// Number of joints.
        expected: usize,
        /// Number of radii.
        found: usize,
    },
    /// The radius of the bone that ends at a joint is negative or not finite.
    Radius {
        /// Index of the joint.
        joint: usize,
        /// Radius, m.
        value: f32,
    },
    /// A sample is not in [0, 1).
    Sample {
        /// Index of the sample, from 0.
        index: usize,
        /// The pair (u, v).
        value: [f32; 2],
    },
    /// The samples ran out before all points were made.
    TooFewSamples {
        /// Index of the joint at the end of the bone that lacks samples.
        joint: usize,
    },
}

impl fmt::Display for ImportanceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full { capacity } => write!(f, "there is room for {capacity} weights only"),
            Self::Weight { joint, value } => {
                write!(f, "joint {joint}: the weight is {value}; it must be finite, 0 or more")
            }
            Self::Sum { value } => {
                write!(f, "the weights' sum is {value}; it must be finite and above 0")
            }
            Self::Base { value } => {
                write!(f, "the base weight is {value}; it must be finite, 0 or more")
            }
            Self::Discount { value } => {
                write!(f, "the discount is {value}; it must be from 0 to 1")
            }
            Self::RadiusCount { expected, found } => {
                write!(f, "{expected} joints need as many radii, {found} were given")
            }
            Self::Radius { joint, value } => {
                write!(f, "joint {joint}: the radius is {value} m; it must be finite, 0 or more")
            }
            Self::Sample { index, value: [u, v] } => {
                write!(f, "sample {index} is ({u}, {v}); both must be from 0 to below 1")
            }
            Self::TooFewSamples { joint } => {
                write!(
                    f,
                    "the samples end at the bone to joint {joint}; every bone needs one a point"
                )
            }
        }
    }
}

impl core::error::Error for ImportanceError {}
