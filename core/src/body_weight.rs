//! Weights of bodies, for rigs in which not all bodies can reach their desired pose or acceleration.

use core::fmt;
use core::ops::RangeInclusive;

use heapless::Vec;

use crate::fixed;
use crate::importance::Importance;
use crate::joint::JointKind;
use crate::tree::Tree;

/// Weights of a body's position error and of its rotation error.
///
/// For accelerations: weights of the linear and the angular acceleration error.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct BodyWeight {
    /// Weight of the squared distance between the body's origin and its desired position.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub position: f32,
    /// Weight of the rotation error, as a length in m: at a position weight of 1, an error of 1 rad costs as much as
    /// a position error of this length.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub rotation_m: f32,
}

impl BodyWeight {
    /// Creates a weight from a position weight and a rotation weight, m.
    pub const fn new(position: f32, rotation_m: f32) -> Self {
        Self { position, rotation_m }
    }
}

/// Range of valid rotation weights, m.
const ROTATIONS_M: RangeInclusive<f32> = 1e-2..=1e2;

/// Maximum ratio of a position weight to the square of its rotation weight, 1/m². Above it, the f32 rounding of
/// positions outweighs the rotation.
const HEAVIEST_PER_M2: f32 = 1e4;

/// Minimum of a position weight above zero. Below it, quotients of weights have too few digits in f32.
const LIGHTEST: f32 = 1e-6;

/// A validated weight for each body of a tree.
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
/// // The hand's position counts more than its rotation: 1 rad costs as much as 5 cm.
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
    /// Validates weights, one per body. O(n).
    ///
    /// # Errors
    /// [`BodyWeightsError`] if the number of weights is not the number of bodies, a rotation weight is not from 1 cm to
    /// 100 m (with a weight of 0 the best pose would not be unique), or a position weight is not valid. A valid
    /// position weight is 0, or at least 1e-6 and at most 1e4 / m² times the square of the rotation weight.
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

    /// Weighs all positions by 1, and each rotation by the importance of its joint: `ρᵢ = rotation_m wᵢ / w̄`,
    /// where w̄ is the mean importance of all joints. The result is clamped to the valid range. O(n).
    ///
    /// A figure whose dimensions differ from the performer's then bends at joints that carry little, and its trunk
    /// keeps the desired pose.
    ///
    /// # Errors
    /// [`BodyWeightsError`] if the number of importances is not the number of joints, or `rotation_m` is not from 1
    /// cm to 100 m.
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
    /// // Rotation weights of shoulder, elbow and hand.
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
        // The mean of normalised weights is 1 divided by their number: no sum overflows.
        let normalised = importance.normalised();
        let shares = normalised.as_slice();
        let of_mean = rotation_m * shares.len() as f32;
        let weights: Vec<BodyWeight, N> = fixed::collect(shares.iter().map(|share| {
            let rotation_m = (share * of_mean).clamp(*ROTATIONS_M.start(), *ROTATIONS_M.end());
            BodyWeight::new(1.0, rotation_m)
        }));
        Self::new(tree, &weights)
    }

    /// Weighs all rotations by 1, and positions by 1 only for bodies on free and prismatic joints: other joints
    /// cannot move the origin of their body. Other positions have weight 0.
    ///
    /// On a tree of spherical joints with a free or fixed root, every body can reach its desired orientation.
    pub fn rotations(tree: &Tree<N>) -> Self {
        let weight = |joint| match joint {
            JointKind::Free | JointKind::Prismatic { .. } => BodyWeight::new(1.0, 1.0),
            _ => BodyWeight::new(0.0, 1.0),
        };
        Self { weights: fixed::collect(tree.bodies().iter().map(|body| weight(body.joint))) }
    }

    /// Returns the weights by body.
    pub fn as_slice(&self) -> &[BodyWeight] {
        &self.weights
    }
}

/// An error in the weights of bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BodyWeightsError {
    /// The number of weights is not the number of bodies.
    Count {
        /// Number of bodies.
        expected: usize,
        /// Number of weights.
        found: usize,
    },
    /// The weight of a body's position is neither 0 nor in its range, see [`BodyWeights::new`].
    Position {
        /// Index of the body.
        body: usize,
        /// Weight of the position.
        value: f32,
    },
    /// The weight of a body's rotation is not a length from 1 cm to 100 m.
    Rotation {
        /// Index of the body.
        body: usize,
        /// Weight of the rotation, m.
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
        // A joint without importance keeps the minimum weight: with none, the nearest pose is not unique.
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
