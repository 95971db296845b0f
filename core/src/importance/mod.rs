//! How much each joint matters: weights of joints by how much of the figure they move, and how far.
//!
//! A small turn at a joint moves all that hangs on it, and the further off, the more. Three measures of that, from a
//! skeleton at rest: [`descendants_length`] from bones alone, [`cylinder_surface`] from bones with a thickness,
//! [`MeshSurface`] from a skinned mesh. They weigh errors of joint rotations where not all can be small.
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

/// One weight for each joint, in the order that the joints were given in: finite, zero or more, and not all zero.
///
/// Its unit is that of the measure it comes from; [`Self::normalised`] leaves it out.
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
    /// Weights by joint. O(n).
    ///
    /// # Errors
    /// [`ImportanceError`] if there are more than `N`, one is negative or not finite, or their sum is zero or too large
    /// for f32.
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

    /// The weights by joint.
    pub fn as_slice(&self) -> &[f32] {
        &self.weights
    }

    /// The same weights with a sum of 1, as near as f32 comes to it. O(n).
    #[must_use]
    pub fn normalised(&self) -> Self {
        let sum = sum(self.weights.iter().copied());
        Self { weights: fixed::collect(self.weights.iter().map(|weight| weight / sum)) }
    }
}

/// Why there are no weights.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ImportanceError {
    /// There is no room for so many weights.
    Full {
        /// How many there is room for.
        capacity: usize,
    },
    /// A weight is negative, or no finite number: the skeleton's measures are too large for f32.
    Weight {
        /// The joint.
        joint: usize,
        /// Its weight.
        value: f32,
    },
    /// All weights are zero, or their sum is too large for f32.
    Sum {
        /// The sum.
        value: f32,
    },
    /// The weight that every joint begins with is negative or not finite.
    Base {
        /// The weight.
        value: f32,
    },
    /// The discount is not from 0 to 1.
    Discount {
        /// The discount.
        value: f32,
    },
    /// There must be a radius for each joint.
    RadiusCount {
        /// Number of joints.
        expected: usize,
        /// Number of radii.
        found: usize,
    },
    /// The radius of the bone that ends at a joint is negative or not finite.
    Radius {
        /// The joint.
        joint: usize,
        /// The radius in m.
        value: f32,
    },
    /// A sample is not in [0, 1).
    Sample {
        /// Which one, from 0.
        index: usize,
        /// The sample.
        value: [f32; 2],
    },
    /// There are fewer samples than points to make.
    TooFewSamples {
        /// The joint that the bone ends at for which there were none left.
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
