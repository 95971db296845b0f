//! How much each body counts, where not all can have the pose or acceleration that they should have.

use core::fmt;
use core::ops::RangeInclusive;

use heapless::Vec;

use crate::fixed;
use crate::importance::Importance;
use crate::joint::JointKind;
use crate::tree::Tree;

/// How much it counts where a body is, and how it is turned.
///
/// Of accelerations, how much it counts where it goes and how it is turning.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct BodyWeight {
    /// Weight of the squared distance of the body's origin from where it should be.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub position: f32,
    /// Weight of its turn from the orientation it should have, as a length in m: a turn of 1 rad counts
    /// like being this far off, at a position weight of 1.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub rotation_m: f32,
}

impl BodyWeight {
    /// Positions of all bodies count alike, and turns by a lever.
    pub const fn new(position: f32, rotation_m: f32) -> Self {
        Self { position, rotation_m }
    }
}

/// Weights of rotations that can be.
const ROTATIONS_M: RangeInclusive<f32> = 1e-2..=1e2;

/// The largest ratio of a position weight to its rotation weight, 1/m²: above, f32 rounding of the positions
/// outweighs the rotation.
const HEAVIEST_PER_M2: f32 = 1e4;

/// The smallest position weight above zero: below, quotients of weights have too few digits in f32.
const LIGHTEST: f32 = 1e-6;

/// One weight for each body of a tree. Validated once.
///
/// ```
/// use sinew_core::projection::{BodyWeight, BodyWeights, BodyWeightsError};
/// use sinew_core::{Body, Inertia, JointKind, Transform, Tree};
/// # let body = |parent| Body {
/// #     parent,
/// #     joint: JointKind::Spherical,
/// #     placement: Transform::IDENTITY,
/// #     inertia: Inertia::default(),
/// #     rotor_inertia: 0.0,
/// # };
/// let tree = Tree::<2>::from_bodies(&[body(None), body(Some(0))])?;
/// // Where the hand is counts more than how it is turned: 1 rad like 5 cm.
/// let weights = [BodyWeight::new(0.0, 1.0), BodyWeight::new(1.0, 0.05)];
/// assert_eq!(BodyWeights::new(&tree, &weights)?.as_slice(), weights);
/// let one = BodyWeights::new(&tree, &weights[..1]);
/// assert_eq!(one, Err(BodyWeightsError::Count { expected: 2, found: 1 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BodyWeights<const N: usize> {
    weights: Vec<BodyWeight, N>,
}

impl<const N: usize> BodyWeights<N> {
    /// Weights by body. O(n).
    ///
    /// # Errors
    /// [`BodyWeightsError`] if there is not a weight for each body, a rotation weight is not from 1 cm to 100 m
    /// (without it, what is best is not unique), or a position weight is neither 0 nor from 1e-6 to 1e4 times the
    /// rotation weight's square.
    pub fn new(tree: &Tree<N>, weights: &[BodyWeight]) -> Result<Self, BodyWeightsError> {
        if weights.len() != tree.len() {
            let (expected, found) = (tree.len(), weights.len());
            return Err(BodyWeightsError::Count { expected, found });
        }
        for (body, weight) in weights.iter().enumerate() {
            if !ROTATIONS_M.contains(&weight.rotation_m) {
                return Err(BodyWeightsError::Rotation { body, value: weight.rotation_m });
            }
            let heaviest = HEAVIEST_PER_M2 * weight.rotation_m * weight.rotation_m;
            if weight.position != 0.0 && !(LIGHTEST..=heaviest * 1.0001).contains(&weight.position)
            {
                return Err(BodyWeightsError::Position { body, value: weight.position });
            }
        }
        Ok(Self { weights: fixed::collect(weights.iter().copied()) })
    }

    /// Positions of all bodies count alike, and turns as their joints' importance: `ρᵢ = rotation_m wᵢ / w̄`, with the
    /// mean w̄ of all, brought into the range that weights may have. O(n).
    ///
    /// A figure of other dimensions then bends where little hangs on the joint, and its trunk stays true.
    ///
    /// # Errors
    /// [`BodyWeightsError`] if there is not a weight for each body, or `rotation_m` is not from 1 cm to 100 m.
    ///
    /// ```
    /// use sinew_core::importance::{RestPose, descendants_length};
    /// use sinew_core::projection::{BodyWeights, ManifoldProjection};
    /// # use sinew_core::{Body, Inertia, JointKind, Transform, Tree, glam::Vec3};
    /// # let body = |parent| Body {
    /// #     parent,
    /// #     joint: JointKind::Spherical,
    /// #     placement: Transform::from_translation(Vec3::X),
    /// #     inertia: Inertia::default(),
    /// #     rotor_inertia: 0.0,
    /// # };
    /// let arm = Tree::<3>::from_bodies(&[body(None), body(Some(0)), body(Some(1))])?;
    /// let importance = descendants_length(&RestPose::of_tree(&arm)?, 0.1, 0.9)?;
    /// let weights = BodyWeights::by_importance(&arm, 0.5, &importance)?;
    /// // The shoulder's, the elbow's, the hand's.
    /// assert!(weights.as_slice().is_sorted_by(|outer, inner| outer.rotation_m > inner.rotation_m));
    /// let projection = ManifoldProjection::new(&arm, weights.as_slice())?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn by_importance(
        tree: &Tree<N>,
        rotation_m: f32,
        importance: &Importance<N>,
    ) -> Result<Self, BodyWeightsError> {
        if !ROTATIONS_M.contains(&rotation_m) {
            return Err(BodyWeightsError::Rotation { body: 0, value: rotation_m });
        }
        // Of normalised weights the mean is one over their number: no sum overflows.
        let normalised = importance.normalised();
        let shares = normalised.as_slice();
        let of_mean = rotation_m * shares.len() as f32;
        let weights: Vec<BodyWeight, N> = fixed::collect(shares.iter().map(|share| {
            let rotation_m = (share * of_mean).clamp(*ROTATIONS_M.start(), *ROTATIONS_M.end());
            BodyWeight::new(1.0, rotation_m)
        }));
        Self::new(tree, &weights)
    }

    /// All turns alike, and positions only of bodies whose joints move them: those on free and prismatic joints.
    ///
    /// On a tree of spherical joints with a free or fixed root, every body can have what it wants.
    pub fn rotations(tree: &Tree<N>) -> Self {
        let weight = |joint| match joint {
            JointKind::Free | JointKind::Prismatic { .. } => BodyWeight::new(1.0, 1.0),
            _ => BodyWeight::new(0.0, 1.0),
        };
        Self { weights: fixed::collect(tree.bodies().iter().map(|body| weight(body.joint))) }
    }

    /// The weights by body.
    pub fn as_slice(&self) -> &[BodyWeight] {
        &self.weights
    }
}

/// Why weights were refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BodyWeightsError {
    /// There must be one for each body of the tree.
    Count {
        /// Number of bodies.
        expected: usize,
        /// Number of weights.
        found: usize,
    },
    /// The weight of a body's position is neither 0 nor in its range, see [`BodyWeights::new`].
    Position {
        /// The body.
        body: usize,
        /// The weight.
        value: f32,
    },
    /// The weight of a body's rotation is not a length from 1 cm to 100 m.
    Rotation {
        /// The body.
        body: usize,
        /// The weight in m.
        value: f32,
    },
}

impl fmt::Display for BodyWeightsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => {
                write!(f, "{expected} bodies need as many weights, {found} were given")
            }
            Self::Position { body, value } => write!(
                f,
                "body {body}: the weight of the position is {value}; it must be 0, or from 1e-6 to 1e4 times the square of the rotation's"
            ),
            Self::Rotation { body, value } => write!(
                f,
                "body {body}: the weight of the rotation is {value} m; it must be from 0.01 to 100 m"
            ),
        }
    }
}

impl core::error::Error for BodyWeightsError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, Inertia, Transform};

    fn star() -> Tree<3> {
        let body = |parent| Body {
            parent,
            joint: JointKind::Spherical,
            placement: Transform::IDENTITY,
            inertia: Inertia::default(),
            rotor_inertia: 0.0,
        };
        Tree::from_bodies(&[body(None), body(Some(0)), body(Some(0))]).unwrap()
    }

    #[test]
    fn the_mean_importance_has_the_weight_that_is_given() {
        let of = |weights: &[f32]| {
            let importance = Importance::new(weights).unwrap();
            let weights = BodyWeights::by_importance(&star(), 0.5, &importance).unwrap();
            weights.as_slice().iter().map(|weight| weight.rotation_m).collect::<Vec<_, 3>>()
        };
        for (weights, expected_m) in [([1e37; 3], [0.5; 3]), ([4.0, 1.0, 1.0], [1.0, 0.25, 0.25])] {
            for (found_m, expected_m) in of(&weights).into_iter().zip(expected_m) {
                assert!((found_m - expected_m).abs() < 1e-6);
            }
        }
        // What is nothing keeps the least weight: without one, the nearest pose is not unique.
        assert_eq!(of(&[1.0, 0.0, 0.0]), [1.5, 0.01, 0.01]);
    }

    #[test]
    fn what_is_no_weight_is_refused() {
        let importance = Importance::new(&[1.0; 3]).unwrap();
        for value in [0.0, -1.0, 101.0, f32::NAN] {
            let refused = BodyWeights::by_importance(&star(), value, &importance);
            assert!(matches!(refused, Err(BodyWeightsError::Rotation { .. })));
        }
        let two = Importance::new(&[1.0; 2]).unwrap();
        let refused = BodyWeights::by_importance(&star(), 0.5, &two);
        assert_eq!(refused, Err(BodyWeightsError::Count { expected: 3, found: 2 }));
    }
}
