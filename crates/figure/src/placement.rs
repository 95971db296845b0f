//! Places the segments of a body model on a skeleton, by the same rules for all models.
//!
//! - The longitudinal axis of a segment points from its joint to its end. The sagittal axis is the figure's
//!   forward direction made perpendicular to the longitudinal axis. For a segment that points forward itself, like
//!   the feet, the transverse axis is the figure's left instead. Forward and left are those of the zero pose, in
//!   which all body frames are parallel.
//! - The ends of a limb (upper arm, forearm, thigh, shank) are joints: a limb is as long as its bone. All other
//!   segments end at landmarks that a skeleton lacks, or whose distance in the skeleton is zero.
//! - The lower trunk starts in the middle of the hips, not at the pelvis joint.

use glam::{DMat3, DVec3};

use super::body::BODIES;
use super::error::BodyModelError;
use crate::FigureMotion;

/// Distance from heel to ankle, as a fraction of the foot's length. This is our assumption.
pub(super) const HEEL_TO_ANKLE: f64 = 0.25;

/// Length below which a bone has no direction, in metres.
const SHORTEST_BONE_M: f64 = 1e-3;

/// A part of the human body. Left and right share one variant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BodyPart {
    LowerTrunk,
    MidTrunk,
    /// The upper trunk without its shoulder parts.
    Thorax,
    Head,
    Shoulder,
    UpperArm,
    Forearm,
    Hand,
    Thigh,
    Shank,
    Foot,
}

impl BodyPart {
    /// All parts in the order of their declaration.
    pub(super) const ALL: [Self; 11] = [
        Self::LowerTrunk,
        Self::MidTrunk,
        Self::Thorax,
        Self::Head,
        Self::Shoulder,
        Self::UpperArm,
        Self::Forearm,
        Self::Hand,
        Self::Thigh,
        Self::Shank,
        Self::Foot,
    ];

    /// Returns the part that a body of the figure is.
    pub(super) fn new(body: usize) -> Self {
        match BODIES[body].name.trim_end_matches("_l").trim_end_matches("_r") {
            "pelvis" => Self::LowerTrunk,
            "abdomen" => Self::MidTrunk,
            "thorax" => Self::Thorax,
            "head" => Self::Head,
            "clavicle" => Self::Shoulder,
            "upper_arm" => Self::UpperArm,
            "forearm" => Self::Forearm,
            "hand" => Self::Hand,
            "thigh" => Self::Thigh,
            "shank" => Self::Shank,
            _ => Self::Foot,
        }
    }

    /// Returns whether both ends of the part are joints.
    pub(super) fn is_limb(self) -> bool {
        matches!(self, Self::UpperArm | Self::Forearm | Self::Thigh | Self::Shank)
    }
}

/// The joints and ends of a figure.
#[derive(Debug, Clone, Copy)]
pub(super) struct Skeleton<'a> {
    /// Position of joint `i` in the frame of body `i`'s parent, in metres.
    pub offset_m: &'a [DVec3],
    /// End of each body's segment in its own frame, in metres.
    pub segment_end_m: &'a [DVec3],
}

impl<'a> Skeleton<'a> {
    pub(super) fn of(motion: &'a FigureMotion) -> Self {
        Self { offset_m: &motion.offset_m, segment_end_m: &motion.segment_end_m }
    }
}

/// A skeleton, and its directions.
pub(super) struct Placement<'a> {
    skeleton: Skeleton<'a>,
    /// Length of thigh and shank together, mean of left and right.
    pub leg_m: f64,
    middle_of_hips_m: DVec3,
    left: DVec3,
    up: DVec3,
    forward: DVec3,
}

/// Placement of a segment, in its body's frame.
pub(super) struct SegmentPlacement {
    /// Start of the segment, at its joint.
    start_m: DVec3,
    /// Vector from the body's joint to the end of its segment.
    pub bone_m: DVec3,
    /// Unit vector from the segment's start to its end.
    direction: DVec3,
    /// Columns: sagittal (front to back), transverse (left to right) and longitudinal axis.
    axes: DMat3,
}

impl SegmentPlacement {
    /// Returns the point on the longitudinal axis at `distance_m` from the segment's start.
    pub(super) fn along(&self, distance_m: f64) -> DVec3 {
        self.start_m + self.direction * distance_m
    }

    /// Returns the transverse axis, a unit vector.
    pub(super) fn left(&self) -> DVec3 {
        self.axes.y_axis
    }

    /// Returns the inertia in body axes, from its moments about the sagittal, transverse and longitudinal axes.
    pub(super) fn in_body_frame(&self, moments_kg_m2: DVec3) -> DMat3 {
        let rotated = self.axes * DMat3::from_diagonal(moments_kg_m2) * self.axes.transpose();
        // Makes the matrix symmetric in spite of rounding.
        (rotated + rotated.transpose()) * 0.5
    }
}

impl<'a> Placement<'a> {
    pub(super) fn new(skeleton: Skeleton<'a>) -> Result<Self, BodyModelError> {
        let Skeleton { offset_m: offset, segment_end_m: end } = skeleton;
        for (body, (offset, end)) in offset.iter().zip(end).enumerate() {
            if !(offset.is_finite() && end.is_finite()) {
                return Err(BodyModelError::NonFinite(BODIES[body].name));
            }
        }
        let [abdomen, thorax, head] = named(["abdomen", "thorax", "head"]);
        let [thigh_l, thigh_r] = named(["thigh_l", "thigh_r"]);
        let legs = named(["thigh_l", "shank_l", "thigh_r", "shank_r"]);

        let two_legs: f64 = legs.iter().map(|leg| end[*leg].length()).sum();
        let middle_of_hips_m = 0.5 * (offset[thigh_l] + offset[thigh_r]);
        let neck = offset[abdomen] + offset[thorax] + offset[head];
        let left = (offset[thigh_l] - offset[thigh_r]).try_normalize();
        let forward = left.and_then(|left| left.cross(neck - middle_of_hips_m).try_normalize());
        let (Some(left), Some(forward)) = (left, forward) else {
            return Err(BodyModelError::NoOrientation);
        };
        Ok(Self {
            skeleton,
            leg_m: 0.5 * two_legs,
            middle_of_hips_m,
            left,
            up: forward.cross(left),
            forward,
        })
    }

    /// Computes the placement of the segment of `body`.
    pub(super) fn place(&self, body: usize) -> Result<SegmentPlacement, BodyModelError> {
        let part = BodyPart::new(body);
        let bone_m = self.skeleton.segment_end_m[body];
        if part.is_limb() && bone_m.length() < SHORTEST_BONE_M {
            return Err(BodyModelError::NoLength(BODIES[body].name));
        }
        let direction = self.direction(body);
        let axes = if part == BodyPart::Shoulder {
            // The bone of a shoulder part is its breadth.
            let forward = perpendicular(self.forward, direction);
            DMat3::from_cols(forward, direction, forward.cross(direction))
        } else if direction.dot(self.forward).abs() < core::f64::consts::FRAC_1_SQRT_2 {
            let forward = perpendicular(self.forward, direction);
            DMat3::from_cols(forward, direction.cross(forward), direction)
        } else {
            let left = perpendicular(self.left, direction);
            DMat3::from_cols(left.cross(direction), left, direction)
        };
        let start_m =
            if part == BodyPart::LowerTrunk { self.middle_of_hips_m } else { DVec3::ZERO };
        Ok(SegmentPlacement { start_m, bone_m, direction, axes })
    }

    /// Returns the position of the joint of `body` in its parent's frame.
    pub(super) fn offset_m(&self, body: usize) -> DVec3 {
        self.skeleton.offset_m[body]
    }

    /// Returns the unit direction of a segment. A segment whose end is at its joint has the direction of its
    /// joint's offset, or else of its parent; the pelvis points up.
    fn direction(&self, body: usize) -> DVec3 {
        let along = |v: DVec3| (v.length() >= SHORTEST_BONE_M).then(|| v.normalize());
        match BODIES[body].parent {
            None => self.up,
            Some(parent) => along(self.skeleton.segment_end_m[body])
                .or_else(|| along(self.skeleton.offset_m[body]))
                .unwrap_or_else(|| self.direction(parent)),
        }
    }
}

/// Calls `make` for every body. Returns all results, or the first error.
pub(super) fn each_body<T, E>(make: impl FnMut(usize) -> Result<T, E>) -> Result<Vec<T>, E> {
    (0..BODIES.len()).map(make).collect()
}

/// Returns the unit vector of `v` made perpendicular to the unit vector `axis`; any perpendicular vector if `v` is
/// parallel to `axis`.
fn perpendicular(v: DVec3, axis: DVec3) -> DVec3 {
    v.reject_from_normalized(axis).try_normalize().unwrap_or_else(|| axis.any_orthonormal_vector())
}

pub(super) fn named<const K: usize>(names: [&str; K]) -> [usize; K] {
    names.map(|name| {
        BODIES.iter().position(|body| body.name == name).expect("the figure has this body")
    })
}
