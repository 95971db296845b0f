//! Ranges of joints.

use crate::joint::JointKind;
use crate::math;

/// The range of a joint, relative to the zero pose of its joint frame.
///
/// ```
/// use sinew_core::projection::{BodyWeight, JointRange, ManifoldProjection, ProjectionError};
/// use sinew_core::{Body, Inertia, JointKind, Transform, Tree, glam::Vec3};
/// # let body = |parent, joint| Body {
/// #     parent,
/// #     joint,
/// #     placement: Transform::IDENTITY,
/// #     inertia: Inertia::default(),
/// #     rotor_inertia: 0.0,
/// # };
/// let knee = JointKind::Revolute { axis: Vec3::X };
/// let leg = Tree::<2>::from_bodies(&[body(None, JointKind::Spherical), body(Some(0), knee)])?;
/// let projection = ManifoldProjection::new(&leg, &[BodyWeight::new(1.0, 0.3); 2])?;
/// let ranges = [JointRange::Turn(1.5), JointRange::Axis([0.0, 2.4])];
/// let swapped = [ranges[1], ranges[0]];
/// assert!(projection.clone().with_ranges(&leg, &ranges).is_ok());
/// let refused = projection.with_ranges(&leg, &swapped);
/// assert_eq!(refused, Err(ProjectionError::Range { joint: 0 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum JointRange {
    /// No limit other than the joint's kind.
    #[default]
    Any,
    /// Revolute joint: from the first to the second angle in rad, both in [-π, π]. Prismatic joint: from the first to
    /// the second displacement in m.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    Axis([f32; 2]),
    /// Both axes of a universal joint, each with its own ends as in [`Self::Axis`].
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    Axes([[f32; 2]; 2]),
    /// Spherical joint: up to this angle in rad, above 0 and up to π, in any direction.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    Turn(f32),
}

impl JointRange {
    /// Returns `true` if the range is valid for this kind of joint. NaN is invalid.
    pub(super) fn fits(self, joint: JointKind) -> bool {
        let angles =
            |[least, most]: [f32; 2]| -math::PI <= least && least <= most && most <= math::PI;
        match (self, joint) {
            (Self::Any, _) => true,
            (Self::Axis(ends), JointKind::Revolute { .. }) => angles(ends),
            (Self::Axis([least, most]), JointKind::Prismatic { .. }) => {
                least.is_finite() && most.is_finite() && least <= most
            }
            (Self::Axes(ends), JointKind::Universal { .. }) => ends.into_iter().all(angles),
            (Self::Turn(most), JointKind::Spherical) => 0.0 < most && most <= math::PI,
            _ => false,
        }
    }

    /// Returns the ends of axis `index`; infinite without a limit.
    pub(super) fn ends(self, index: usize) -> [f32; 2] {
        match self {
            Self::Axis(ends) => ends,
            Self::Axes(ends) => ends.get(index).copied().unwrap_or(EVERYWHERE),
            Self::Any | Self::Turn(_) => EVERYWHERE,
        }
    }

    /// Limits coordinates to the range.
    pub(super) fn clamp(self, along: [f32; 2]) -> [f32; 2] {
        let [a, b] = along;
        let within = |x: f32, [least, most]: [f32; 2]| x.max(least).min(most);
        [within(a, self.ends(0)), within(b, self.ends(1))]
    }
}

const EVERYWHERE: [f32; 2] = [f32::NEG_INFINITY, f32::INFINITY];
