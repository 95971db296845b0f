//! Assigns joints of a rig to landmarks.
//!
//! Names give side and limb; geometry finds the joints that form one ball or hinge: those whose axes nearly meet.

mod at_zero;
mod chains;
mod derive;
mod error;
mod groups;
mod hinge;
mod matched;
mod mirror;
mod points;
mod propose;
mod text;

use glam::DVec3;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::Pose;

use crate::{Landmark, Side};

pub use error::RigMatchError;
pub use matched::{Group, Hinge, RigDirections, RigMatch, RigPoint, UnmatchedJoint};
pub use mirror::{MirrorFault, mirror_faults, with_axes_turned};

impl RigMatch {
    /// Matches a rig by words and geometry. O(n²).
    ///
    /// # Errors
    /// [`RigMatchError`] if it has neither a limb nor a head that match a performer.
    pub fn of(mechanism: &Mechanism) -> Result<Self, RigMatchError> {
        let (groups, left_out) = propose::propose(mechanism);
        if groups.is_empty() {
            return Err(RigMatchError::Nothing {
                joints: mechanism.bodies.len().saturating_sub(1),
            });
        }
        Ok(Self { left_out, ..Self::of_groups(mechanism, groups, None)? })
    }

    /// Derives the match from known groups. `forward` is the rig's forward direction in the world at zero, if
    /// known.
    ///
    /// # Errors
    /// [`RigMatchError`] if a group's joint does not exist in the rig, or slides.
    pub fn of_groups(
        mechanism: &Mechanism,
        groups: Vec<Group>,
        forward: Option<DVec3>,
    ) -> Result<Self, RigMatchError> {
        derive::derive(mechanism, groups, forward)
    }

    /// Returns the joints of a landmark; empty if the rig does not have the landmark.
    pub fn joints(&self, landmark: Landmark) -> &[usize] {
        self.group(landmark).map_or(&[], |group| &group.joints)
    }

    /// Returns the unit direction of the limb that ends at a landmark, for these world poses of the bodies; `None`
    /// if the rig has no such limb.
    pub fn limb_direction(&self, poses: &[Pose], landmark: Landmark) -> Option<DVec3> {
        let point_m = |place: Landmark| {
            let point = self.points[place]?;
            Some(poses.get(point.body)?.point(point.position_m))
        };
        let above = crate::performer::segment_above(landmark)?;
        (point_m(landmark)? - point_m(above)?).try_normalize()
    }

    /// Returns whether the rig has one arm, and no other part of a body.
    pub fn is_one_arm(&self) -> bool {
        let has = |landmark: fn(Side) -> Landmark| {
            Side::ALL.map(|side| self.group(landmark(side)).is_some())
        };
        let [left, right] = has(Landmark::Shoulder);
        let has_legs = has(Landmark::Hip).contains(&true);
        left != right && !has_legs && self.group(Landmark::Head).is_none()
    }

    /// Returns the group of a landmark; `None` if the rig does not have the landmark.
    pub fn group(&self, landmark: Landmark) -> Option<&Group> {
        self.groups.iter().find(|group| group.landmark == landmark)
    }

    /// Returns the last body of a landmark's group: for a hip the thigh, for an ankle the foot. `None` if the rig does
    /// not have the landmark.
    pub fn body(&self, landmark: Landmark) -> Option<usize> {
        match landmark {
            Landmark::Pelvis => self.pelvis,
            Landmark::Chest => self.chest,
            _ => self.joints(landmark).last().copied(),
        }
    }
}
