//! Measures of the distance between two poses.

use std::fmt;

use glam::DQuat;
use sinew_batch::PoseSequence;
use sinew_core::pose_space::{
    BodyPoses, JointCoordinates, JointRotations, LineWorkspace, PoseCoordinates, PoseSpace,
    PoseSpaceError,
};
use sinew_core::{Body, JointKind};

use super::BODY_COUNT;
use super::rig::{SpatialRig, single};
use crate::geodesic::{JointPosition, Options, Rig, RigJoint, solve};

/// The quantity that a distance compares, after Hauberg & Pedersen (2012). `core` computes all metrics except
/// geodesics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Metric {
    /// Coordinates of joints, rad: eq. (1).
    Angles,
    /// Angles between the joints' rotations times the lengths of the bones, m rad: Tournier et al. (2009).
    Rotations,
    /// Positions of joints, m.
    Positions,
    /// Length in space of the straight line between the joint coordinates, m: eq. (4) in section 2.2.
    Line,
    /// Length of the shortest path in space that keeps the bones' lengths, m. A line approximates it at a
    /// thousandth of the cost.
    Geodesic,
}

impl Metric {
    /// Metrics of `core`, in the order in which they are shown: fast enough to compare all poses of a study.
    pub const ALL: [Self; 4] = [Self::Angles, Self::Rotations, Self::Positions, Self::Line];

    /// Returns the name for tables and options.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Angles => "angles",
            Self::Rotations => "rotations",
            Self::Positions => "positions",
            Self::Line => "line",
            Self::Geodesic => "geodesic",
        }
    }

    /// Returns the unit of the distance.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Angles => "rad",
            Self::Rotations => "m rad",
            Self::Positions | Self::Line | Self::Geodesic => "m",
        }
    }

    /// Returns whether the metric is the length of a curve in steps. The straight-line distance of the joints is
    /// then a lower bound.
    pub const fn is_length_of_curve(self) -> bool {
        matches!(self, Self::Line | Self::Geodesic)
    }
}

/// The weights of the joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weighting {
    /// Equal weights.
    Alike,
    /// Weights by importance, see [`SpatialRig::importance`].
    Importance,
}

/// A distance measure of poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Measure {
    /// Quantity that is compared.
    pub metric: Metric,
    /// Weights of the joints.
    pub weighting: Weighting,
    /// Number of steps of a line or a geodesic.
    pub steps: u16,
}

impl Measure {
    /// Creates a measure with equal weights, and ten steps for lines as in the paper.
    pub const fn new(metric: Metric) -> Self {
        Self { metric, weighting: Weighting::Alike, steps: 10 }
    }

    /// Returns the measure with joints weighted by importance.
    #[must_use]
    pub const fn weighted(self) -> Self {
        Self { weighting: Weighting::Importance, ..self }
    }

    /// Returns every metric of `core`, with equal weights and with weights by importance.
    pub fn all() -> impl Iterator<Item = Self> {
        Metric::ALL.into_iter().map(Self::new).flat_map(|measure| [measure, measure.weighted()])
    }
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.weighting {
            Weighting::Alike => f.pad(self.metric.name()),
            Weighting::Importance => f.pad(&format!("{}, weighted", self.metric.name())),
        }
    }
}

/// A measure for the poses of one rig.
#[derive(Debug, Clone, PartialEq)]
pub struct RigMeasure<'r, const N: usize = BODY_COUNT> {
    rig: &'r SpatialRig<N>,
    space: PoseSpace<'r, N>,
    measure: Measure,
    /// Rig for geodesics, if those are measured.
    geodesics: Option<Rig>,
}

/// A pose that is prepared for comparison: 68 bytes for each of `N` bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredPose<const N: usize = BODY_COUNT> {
    coordinates: PoseCoordinates<N>,
    places: BodyPoses<N>,
    rotations: JointRotations<N>,
}

impl<'r, const N: usize> RigMeasure<'r, N> {
    /// Creates a measure for the poses of a rig.
    ///
    /// # Panics
    /// Never: a rig's importances, and the squares of its bones' lengths, are valid weights.
    pub fn new(rig: &'r SpatialRig<N>, measure: Measure) -> Self {
        let alike = PoseSpace::new(rig.tree());
        let mut weights = match measure.weighting {
            Weighting::Alike => vec![1.0; rig.tree().bodies().len()],
            Weighting::Importance => rig.importance().to_vec(),
        };
        if measure.metric == Metric::Rotations {
            for (weight, length_m) in weights.iter_mut().zip(alike.bone_lengths_m()) {
                *weight *= length_m * length_m;
            }
        }
        if weights.iter().all(|weight| *weight <= 0.0) {
            weights.fill(1.0);
        }
        let space = alike.with_weights(&weights).expect("importances and lengths are weights");
        let joint = |(body, weight): (&Body, &f32)| RigJoint {
            weight: f64::from(*weight),
            ..RigJoint::from(body)
        };
        let joints = || rig.tree().bodies().iter().zip(&weights).map(joint).collect::<Vec<_>>();
        let geodesics = (measure.metric == Metric::Geodesic)
            .then(|| Rig::new(&joints()).expect("a tree's bodies are joints of a rig"));
        Self { rig, space, measure, geodesics }
    }

    /// Returns the measure of this object.
    pub const fn measure(&self) -> Measure {
        self.measure
    }

    /// Returns the space in which `core` compares the poses.
    pub const fn space(&self) -> &PoseSpace<'r, N> {
        &self.space
    }

    /// Prepares a pose from the local rotations of the skeleton's joints.
    ///
    /// # Errors
    /// [`PoseSpaceError::Pose`] if a rotation is not finite or not unit.
    pub fn pose(&self, rotations: &[DQuat]) -> Result<MeasuredPose<N>, PoseSpaceError> {
        let coordinates = self.space.coordinates(&self.rig.joint_poses(rotations))?;
        let places = self.space.body_poses(&coordinates);
        let rotations = self.space.joint_rotations(&coordinates);
        Ok(MeasuredPose { coordinates, places, rotations })
    }

    /// Returns the distance of two poses, in the metric's unit. If the geodesic's solver does not converge, the
    /// result is the length of its last curve.
    pub fn distance(
        &self,
        a: &MeasuredPose<N>,
        b: &MeasuredPose<N>,
        workspace: &mut Workspace<N>,
    ) -> f32 {
        match self.measure.metric {
            Metric::Angles => self.space.angle_distance(&a.coordinates, &b.coordinates),
            Metric::Rotations => self.space.rotation_distance(&a.rotations, &b.rotations),
            Metric::Positions => self.position_distance(a, b),
            Metric::Line => {
                let (a, b) = (&a.coordinates, &b.coordinates);
                self.space.line_distance(a, b, self.measure.steps, workspace)
            }
            Metric::Geodesic => self.geodesics.as_ref().map_or(0.0, |rig| {
                let options = Options { steps: self.measure.steps.into(), ..Options::default() };
                let found = solve(rig, &self.position(a), &self.position(b), &options);
                single(found.expect("a measured pose is one of the rig").length_m)
            }),
        }
    }

    /// Converts a pose for the geodesics' solver. A spatial rig has only ball joints and fixed joints.
    fn position(&self, pose: &MeasuredPose<N>) -> Vec<JointPosition> {
        let bodies = self.rig.tree().bodies().iter().zip(pose.coordinates.as_slice());
        let turn = |(body, of): (&Body, &JointCoordinates)| match body.joint {
            JointKind::Spherical => {
                JointPosition::Turn(DQuat::from_scaled_axis(of.angular_rad.as_dvec3()))
            }
            _ => JointPosition::Fixed,
        };
        bodies.map(turn).collect()
    }

    /// Stores poses for distances to many of them at once: distances of the metric, or straight-line distances of the
    /// joints if the metric is the length of a curve. The weights are those of [`Self::space`].
    pub fn sequence(&self, poses: &[MeasuredPose<N>]) -> PoseSequence {
        match self.measure.metric {
            Metric::Angles => {
                let coordinates = poses.iter().map(|pose| &pose.coordinates);
                let sequence = PoseSequence::of_angles(self.rig.tree(), coordinates);
                sequence.expect("a spatial rig has only ball joints and fixed joints")
            }
            Metric::Rotations => {
                PoseSequence::of_rotations(poses.iter().map(|pose| &pose.rotations))
            }
            Metric::Positions | Metric::Line | Metric::Geodesic => {
                PoseSequence::of_positions(poses.iter().map(|pose| &pose.places))
            }
        }
    }

    /// Returns the straight-line distance of the joints, with the measure's weights. In exact arithmetic no line
    /// and no geodesic is shorter.
    pub fn position_distance(&self, a: &MeasuredPose<N>, b: &MeasuredPose<N>) -> f32 {
        self.space.position_distance(&a.places, &b.places)
    }
}

impl<const N: usize> MeasuredPose<N> {
    /// Returns the coordinates of the pose's joints.
    pub const fn coordinates(&self) -> &PoseCoordinates<N> {
        &self.coordinates
    }

    /// Returns the poses of the bodies relative to the root.
    pub const fn places(&self) -> &BodyPoses<N> {
        &self.places
    }
}

/// Scratch memory for distances. Each thread needs its own.
pub type Workspace<const N: usize = BODY_COUNT> = LineWorkspace<N>;

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_figure::builtin;

    #[test]
    fn the_same_turn_counts_more_the_longer_the_bone() {
        let skeleton = builtin::clips()[0].skeleton.clone();
        let rig = SpatialRig::new(&skeleton, None).unwrap();
        let measuring = RigMeasure::new(&rig, Measure::new(Metric::Rotations));
        let lengths_m = measuring.space().bone_lengths_m();
        let at_rest = vec![DQuat::IDENTITY; skeleton.joints.len()];
        let mut workspace = Workspace::new();
        for (body, length_m) in lengths_m.iter().enumerate().skip(1) {
            let mut turned = at_rest.clone();
            let joint = skeleton.find(rig.joint(body)).unwrap();
            turned[joint] = DQuat::from_rotation_x(0.5);
            let [a, b] = [&at_rest, &turned].map(|pose| measuring.pose(pose).unwrap());
            let off = measuring.distance(&a, &b, &mut workspace) - 0.5 * length_m;
            assert!(off.abs() < 1e-6, "{}: {off}", rig.joint(body));
        }
    }
}
