//! Which joints of a rig are which place of a body.
//!
//! Names say side and limb; geometry says which joints are one ball or hinge: those whose axes nearly meet.

mod at_zero;
mod chains;
mod derive;
mod groups;
mod hinge;
mod mirror;
mod points;
mod propose;
mod text;

use glam::{DQuat, DVec3};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::Pose;

use crate::{Landmark, LandmarkMap};

pub use mirror::{MirrorFault, mended, mirror_faults};

/// The joints that make one landmark.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The place.
    pub landmark: Landmark,
    /// Bodies that the joints move, from the trunk outwards. Of [`Landmark::Chest`]: the joints between pelvis and
    /// chest.
    pub joints: Vec<usize>,
    /// The landmark's point, if it is not to be found from the axes.
    pub point: Option<RigPoint>,
    /// From 0 to 1.
    pub confidence: f64,
    /// Why it is so high, and not higher.
    pub reason: String,
}

/// A point of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigPoint {
    /// Index of the body.
    pub body: usize,
    /// Body frame, m.
    pub position_m: DVec3,
}

/// A joint without a counterpart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Body that the joint moves.
    pub joint: usize,
    /// Why.
    pub reason: String,
}

/// The hinge of an elbow or a knee, as its limb's upper body carries it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hinge {
    /// The upper arm or the thigh.
    pub body: usize,
    /// Body that the hinge moves.
    pub joint: usize,
    /// Unit axis in the frame of `body`; a positive turn about it bends the limb. If `is_sure` is not set, the sign is
    /// unknown.
    pub axis: DVec3,
    /// Angle of the joint at which the limb is straightest, rad.
    pub straight_rad: f64,
    /// Whether the way in which it bends is known.
    pub is_sure: bool,
}

/// Directions of a rig in the world, every joint at zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigDirections {
    /// Unit; forward = left × up.
    pub forward: DVec3,
    /// Unit.
    pub left: DVec3,
    /// Unit.
    pub up: DVec3,
}

impl RigDirections {
    /// The rotation that takes x, y, z to forward, left, up.
    pub fn rotation(&self) -> DQuat {
        DQuat::from_mat3(&glam::DMat3::from_cols(self.forward, self.left, self.up)).normalize()
    }
}

/// A rig, its joints dealt out to landmarks, and what follows from that by geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct RigMatch {
    /// The joints of each landmark that the rig has.
    pub groups: Vec<Group>,
    /// Joints without a counterpart.
    pub left_out: Vec<LeftOut>,
    /// At zero.
    pub directions: RigDirections,
    /// The body that carries the hips.
    pub pelvis: Option<usize>,
    /// The body that carries the shoulders.
    pub chest: Option<usize>,
    /// The last body of the head's joints.
    pub head: Option<usize>,
    /// Points of limbs, on the last body of their group.
    pub points: LandmarkMap<Option<RigPoint>>,
    /// Of elbows and knees.
    pub hinges: LandmarkMap<Option<Hinge>>,
    /// Where each body's frame is at zero, as a rotation to the world.
    pub rotations_at_zero: Vec<DQuat>,
}

impl RigMatch {
    /// Matches a rig by words and geometry. O(n²).
    ///
    /// # Errors
    /// [`NoMatch`] if it has no limb and no head that a performer has.
    pub fn of(mechanism: &Mechanism) -> Result<Self, NoMatch> {
        let (groups, left_out) = propose::propose(mechanism);
        if groups.is_empty() {
            return Err(NoMatch::Nothing { joints: mechanism.bodies.len().saturating_sub(1) });
        }
        Ok(Self { left_out, ..Self::of_groups(mechanism, groups, None)? })
    }

    /// What follows from groups that are known. `forward`: of the rig in the world at zero, if it is known.
    ///
    /// # Errors
    /// [`NoMatch`] if a group's joint is none of the rig's, or slides.
    pub fn of_groups(
        mechanism: &Mechanism,
        groups: Vec<Group>,
        forward: Option<DVec3>,
    ) -> Result<Self, NoMatch> {
        derive::derive(mechanism, groups, forward)
    }

    /// The joints of a landmark; none if the rig has none.
    pub fn joints(&self, landmark: Landmark) -> &[usize] {
        self.group(landmark).map_or(&[], |group| &group.joints)
    }

    /// Unit direction of the limb that ends at a landmark, its bodies at these poses in the world; `None` if the rig
    /// has no such limb.
    pub fn limb_direction(&self, poses: &[Pose], landmark: Landmark) -> Option<DVec3> {
        let point_m = |place: Landmark| {
            let point = self.points[place]?;
            Some(poses.get(point.body)?.point(point.position_m))
        };
        let above = crate::performer::segment_above(landmark)?;
        (point_m(landmark)? - point_m(above)?).try_normalize()
    }

    /// The group of a landmark.
    pub fn group(&self, landmark: Landmark) -> Option<&Group> {
        self.groups.iter().find(|group| group.landmark == landmark)
    }

    /// The last body of a landmark's group: the thigh of a hip, the foot of an ankle.
    pub fn body(&self, landmark: Landmark) -> Option<usize> {
        match landmark {
            Landmark::Pelvis => self.pelvis,
            Landmark::Chest => self.chest,
            _ => self.joints(landmark).last().copied(),
        }
    }
}

/// Why a rig cannot be matched.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoMatch {
    /// No words and no shape of a performer.
    #[error(
        "no arm, leg or head found among {joints} joints: expected names with a side and a limb (left_knee, l_arm_z), \
         or one chain without branches"
    )]
    Nothing {
        /// Number of joints.
        joints: usize,
    },
    /// A joint that does not turn.
    #[error("{landmark}: expected joints that turn, found `{joint}`, which does not")]
    DoesNotTurn {
        /// Name of the landmark.
        landmark: &'static str,
        /// Name of the joint.
        joint: String,
    },
    /// An index without a body.
    #[error(
        "{landmark}: expected joints of the rig, found index {joint}, and it has {bodies} bodies"
    )]
    NoJoint {
        /// Name of the landmark.
        landmark: &'static str,
        /// The index.
        joint: usize,
        /// Bodies of the rig.
        bodies: usize,
    },
}
