//! Importance from a skinned mesh.

use core::fmt;

use glam::Vec3;

use super::weights::Weights;
use super::{Importance, ImportanceError, RestPose};
use crate::math;

/// Sums for weights in m³ from the skin that a joint moves, `w = base + Σ area · share · |vertex - joint|`. Vertices
/// are added one by one, so the mesh need not fit in memory. A vertex's share for a joint is the part of its skinning
/// weights that belongs to the joint and all joints below it.
///
/// The sums are compensated: 100,000 vertices are as exact as ten. A vertex's area must be a third of the total area of
/// its triangles; the areas then sum to the surface. (The published numbers of Holden's article result from the mean
/// area of these triangles instead. On its mesh, this is about half as much, which doubles the effect of its base.)
///
/// ```
/// use sinew_core::{glam::Vec3, importance::{MeshSurface, RestPose}};
/// let arm = RestPose::<2>::new(&[None, Some(0)], &[Vec3::ZERO, Vec3::X])?;
/// let mut surface = MeshSurface::new(arm, 0.0)?;
/// // A vertex on the upper arm, then a vertex that is bound to the elbow with a share of a fourth.
/// surface.add(Vec3::X * 0.5, 0.01, &[(0, 1.0)])?;
/// surface.add(Vec3::X * 2.0, 0.02, &[(0, 0.75), (1, 0.25)])?;
/// let importance = surface.importance()?;
/// let [shoulder, elbow] = [0, 1].map(|joint| importance.as_slice()[joint]);
/// assert!((shoulder - 0.045).abs() < 1e-8 && (elbow - 0.005).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MeshSurface<const N: usize> {
    rest_pose: RestPose<N>,
    weights: Weights<N>,
}

impl<const N: usize> MeshSurface<N> {
    /// Creates the sums for a skeleton, without any vertex.
    ///
    /// # Errors
    /// [`ImportanceError::Base`] if the base is negative or not finite.
    pub fn new(rest_pose: RestPose<N>, base_m3: f32) -> Result<Self, ImportanceError> {
        let weights = Weights::new(rest_pose.len(), base_m3)?;
        Ok(Self { rest_pose, weights })
    }

    /// Adds a vertex: its position in the axes of the rest pose in m, its area in m², and its joints with their
    /// skinning weights. O(influences · depth).
    ///
    /// Skinning weights are divided by their sum, so quantised or truncated weights need no correction. A vertex
    /// without a triangle has an area of zero and adds nothing.
    ///
    /// # Errors
    /// [`VertexError`], and nothing is added, if the position is not finite, the area or a weight is negative or not
    /// finite, a joint does not exist, the sum of the weights is zero or too large for f32, or the vertex would add
    /// too large a value to a joint.
    pub fn add(
        &mut self,
        position_m: Vec3,
        area_m2: f32,
        influences: &[(usize, f32)],
    ) -> Result<(), VertexError> {
        let usable = |value: f32| value >= 0.0 && value.is_finite();
        if !position_m.is_finite() {
            return Err(VertexError::NonFinitePosition);
        }
        if !usable(area_m2) {
            return Err(VertexError::Area { value: area_m2 });
        }
        let mut sum = 0.0;
        for &(joint, value) in influences {
            if joint >= self.rest_pose.len() {
                return Err(VertexError::NoSuchJoint { joint, count: self.rest_pose.len() });
            }
            if !usable(value) {
                return Err(VertexError::Influence { joint, value });
            }
            sum += value;
        }
        if !(sum > 0.0 && sum.is_finite()) {
            return Err(VertexError::InfluenceSum { value: sum });
        }
        let rest_pose = &self.rest_pose;
        let moments_m3 = || {
            influences.iter().flat_map(|&(joint, value)| {
                let share_m2 = area_m2 * (value / sum);
                core::iter::once(joint).chain(rest_pose.ancestors(joint)).map(move |moved_by| {
                    let distance_m = math::length(position_m - rest_pose.position_m(moved_by));
                    (moved_by, share_m2 * distance_m)
                })
            })
        };
        if let Some((joint, value)) = moments_m3().find(|(_, value)| !value.is_finite()) {
            return Err(VertexError::Moment { joint, value });
        }
        for (joint, value) in moments_m3() {
            self.weights.add(joint, value);
        }
        Ok(())
    }

    /// Returns the weights from the vertices so far. O(n).
    ///
    /// # Errors
    /// [`ImportanceError`] if a weight is too large for f32, or all weights are zero.
    pub fn importance(&self) -> Result<Importance<N>, ImportanceError> {
        self.weights.importance()
    }
}

/// An error in a vertex of a skinned mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum VertexError {
    /// The position has a NaN or infinite component.
    NonFinitePosition,
    /// The area is negative or not finite.
    Area {
        /// Area of the vertex, m².
        value: f32,
    },
    /// The vertex is bound to a joint that does not exist.
    NoSuchJoint {
        /// Index of the joint.
        joint: usize,
        /// Number of joints.
        count: usize,
    },
    /// A skinning weight is negative or not finite.
    Influence {
        /// Index of the joint.
        joint: usize,
        /// Skinning weight of the vertex for the joint.
        value: f32,
    },
    /// The vertex is bound to no joint, or the sum of its skinning weights is too large for f32.
    InfluenceSum {
        /// Sum of the skinning weights.
        value: f32,
    },
    /// The area times the distance from a joint is too large for f32.
    Moment {
        /// Index of the joint.
        joint: usize,
        /// Area times distance, m³.
        value: f32,
    },
}

impl fmt::Display for VertexError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinitePosition => f.write_str("the vertex' position is not finite"),
            Self::Area { value } => {
                write!(f, "the vertex' area is {value} m²; it must be finite, 0 or more")
            }
            Self::NoSuchJoint { joint, count } => {
                write!(f, "the vertex is bound to joint {joint}; there are {count}, from 0")
            }
            Self::Influence { joint, value } => write!(
                f,
                "the vertex' skinning weight of joint {joint} is {value}; it must be finite, 0 or more"
            ),
            Self::InfluenceSum { value } => {
                write!(
                    f,
                    "the sum of the vertex' skinning weights is {value}; it must be finite and above 0"
                )
            }
            Self::Moment { joint, value } => write!(
                f,
                "the vertex' area times its distance from joint {joint} is {value} m³; it must be finite"
            ),
        }
    }
}

impl core::error::Error for VertexError {}

#[cfg(test)]
mod tests {
    use super::*;

    /// The root's part fits in f32; the elbow's does not.
    #[test]
    fn a_vertex_too_far_from_one_joint_is_not_added_to_others() {
        let positions_m = [Vec3::ZERO, Vec3::X * 1e19];
        let arm = RestPose::<2>::new(&[None, Some(0)], &positions_m).expect("an arm");
        let mut surface = MeshSurface::new(arm, 0.1).expect("a base");
        let before = surface.clone();
        let refused = surface.add(Vec3::X, 1e30, &[(0, 0.5), (1, 0.5)]);
        assert_eq!(refused, Err(VertexError::Moment { joint: 1, value: f32::INFINITY }));
        assert_eq!(surface, before);
        surface.add(Vec3::X, 1e10, &[(0, 0.5), (1, 0.5)]).expect("less of it");
        assert_ne!(surface, before);
    }
}
