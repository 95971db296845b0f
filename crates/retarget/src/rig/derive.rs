//! Derives bodies, directions, points and hinges from the groups, by geometry.

use glam::DVec3;
use sinew_rig::Mechanism;

use super::at_zero::{AtZero, meeting_point};
use super::error::RigMatchError;
use super::groups::{axes, middle_m};
use super::matched::{Group, Hinge, RigDirections, RigMatch, RigPoint};
use super::{hinge, points, text};
use crate::{Landmark, LandmarkMap, Side};

/// Weight by which a ball's centre or a hinge's point is drawn to its expected place, if the axes leave it open.
const TOWARDS: f64 = 1e-3;
/// Maximum distance between a ball's axes, as a share of the limb's segment. If it is exceeded, the last two axes
/// determine the centre: they move the segment, and the first axis only shifts them, like a shoulder blade.
const APART: f64 = 0.15;
/// Minimum cosine between an axis and a limb for the axis to run along the limb.
const ALONG: f64 = 0.7;
/// Minimum distance of a twist joint from the elbow to be the wrist, as a share of the upper arm.
const AWAY: f64 = 0.3;

pub(super) fn derive(
    mechanism: &Mechanism,
    groups: Vec<Group>,
    forward: Option<DVec3>,
) -> Result<RigMatch, RigMatchError> {
    check(mechanism, &groups)?;
    let rig = AtZero::of(mechanism);
    let mut places = Places {
        rig: &rig,
        groups: &groups,
        world_m: LandmarkMap::default(),
        on: LandmarkMap::default(),
    };
    for side in Side::ALL {
        places.balls(Landmark::Shoulder(side));
        places.balls(Landmark::Hip(side));
    }
    let directions = places.directions(forward);
    for side in Side::ALL {
        for (landmark, above) in [
            (Landmark::Elbow(side), Landmark::Shoulder(side)),
            (Landmark::Wrist(side), Landmark::Elbow(side)),
            (Landmark::Knee(side), Landmark::Hip(side)),
            (Landmark::Ankle(side), Landmark::Knee(side)),
            (Landmark::Toe(side), Landmark::Ankle(side)),
        ] {
            places.below(landmark, above);
        }
        places.ends(side, &directions);
    }
    let hinges = places.hinges(&directions);
    let points = LandmarkMap::of(|landmark| {
        let (world_m, body) = (places.world_m[landmark]?, places.on[landmark]?);
        Some(RigPoint { body, position_m: rig.poses[body].to_local(world_m) })
    });
    let tips = LandmarkMap::of(|landmark| {
        let Landmark::Wrist(side) = landmark else { return None };
        let group = |place| groups.iter().find(|group| group.landmark == place);
        let last = group(landmark).or_else(|| group(Landmark::Elbow(side)))?.joints.last()?;
        let body = points::last_of_chain(&rig, *last);
        let world_m = points::end_m(&rig, body, &text::WRIST);
        Some(RigPoint { body, position_m: rig.poses[body].to_local(world_m) })
    });
    let head_joints = groups.iter().find(|group| group.landmark == Landmark::Head);
    let on_head = head_joints.and_then(|group| rig.parent(*group.joints.first()?));
    Ok(RigMatch {
        directions,
        pelvis: carrier(&rig, &groups, Landmark::Hip),
        chest: carrier(&rig, &groups, Landmark::Shoulder).or(on_head),
        head: head_joints.and_then(|group| group.joints.last().copied()),
        points,
        tips,
        hinges,
        rotations_at_zero: rig.poses.iter().map(|pose| pose.rotation).collect(),
        groups,
        left_out: Vec::new(),
    })
}

fn check(mechanism: &Mechanism, groups: &[Group]) -> Result<(), RigMatchError> {
    let bodies = mechanism.bodies.len();
    for group in groups {
        let landmark = group.landmark.name();
        let point = group.point.map(|point| point.body);
        for joint in group.joints.iter().copied().chain(point) {
            if joint >= bodies {
                return Err(RigMatchError::NoJoint { landmark, joint, bodies });
            }
        }
        for joint in &group.joints {
            let link = &mechanism.bodies[*joint];
            let turns = !matches!(
                link.joint,
                sinew_rig::mechanism::JointModel::Prismatic(_)
                    | sinew_rig::mechanism::JointModel::Fixed
                    | sinew_rig::mechanism::JointModel::Free
            );
            if !turns {
                return Err(RigMatchError::DoesNotTurn {
                    landmark,
                    joint: link.joint_name.clone(),
                });
            }
        }
    }
    Ok(())
}

/// Returns the body that carries the left and the right limb; if the rig has only one of the two, the parent of that
/// limb.
pub(super) fn carrier(
    rig: &AtZero<'_>,
    groups: &[Group],
    landmark: fn(Side) -> Landmark,
) -> Option<usize> {
    let of_side = |side| {
        let group = groups.iter().find(|group| group.landmark == landmark(side))?;
        rig.parent(*group.joints.first()?)
    };
    match (of_side(Side::Left), of_side(Side::Right)) {
        (Some(left), Some(right)) => Some(rig.common_body(left, right)),
        (one, other) => one.or(other),
    }
}

/// Points of landmarks found so far: in the world at zero, and the body that each is fixed to.
struct Places<'r> {
    rig: &'r AtZero<'r>,
    groups: &'r [Group],
    world_m: LandmarkMap<Option<DVec3>>,
    on: LandmarkMap<Option<usize>>,
}

impl Places<'_> {
    fn group(&self, landmark: Landmark) -> Option<&Group> {
        self.groups.iter().find(|group| group.landmark == landmark)
    }

    fn set(&mut self, landmark: Landmark, body: usize, world_m: DVec3) {
        self.on[landmark] = Some(body);
        self.world_m[landmark] = Some(world_m);
    }

    /// Uses the point that the user has given, and returns whether there is one.
    fn given(&mut self, landmark: Landmark) -> bool {
        let Some(point) = self.group(landmark).and_then(|group| group.point) else { return false };
        self.set(landmark, point.body, self.rig.poses[point.body].point(point.position_m));
        true
    }

    /// Sets the point where the axes of a shoulder or a hip nearly meet.
    fn balls(&mut self, landmark: Landmark) {
        if self.given(landmark) {
            return;
        }
        let Some((mut axes, last)) = self.axes_of(landmark) else { return };
        let mut point_m = meeting_point(&axes, middle_m(&axes), TOWARDS);
        let spread_m = axes.iter().map(|axis| axis.distance_to(point_m)).fold(0.0, f64::max);
        if spread_m > APART * self.segment_m(landmark, point_m) && axes.len() > 2 {
            axes.drain(..axes.len() - 2);
            point_m = meeting_point(&axes, middle_m(&axes), TOWARDS);
        }
        self.set(landmark, last, point_m);
    }

    /// Returns the distance from a ball to the first joint beyond it, m.
    fn segment_m(&self, ball: Landmark, point_m: DVec3) -> f64 {
        let beyond = match ball {
            Landmark::Shoulder(side) => Landmark::Elbow(side),
            Landmark::Hip(side) => Landmark::Knee(side),
            _ => return f64::INFINITY,
        };
        let joint = self.group(beyond).and_then(|group| group.joints.first());
        joint.map_or(f64::INFINITY, |joint| self.rig.poses[*joint].position_m.distance(point_m))
    }

    fn axes_of(&self, landmark: Landmark) -> Option<(Vec<super::at_zero::Axis>, usize)> {
        let group = self.group(landmark)?;
        Some((axes(self.rig, &group.joints)?, *group.joints.last()?))
    }

    /// Sets the point of a hinge: the point of its axis that is nearest to the landmark above.
    fn below(&mut self, landmark: Landmark, above: Landmark) {
        if self.given(landmark) {
            return;
        }
        let Some((mut axes, last)) = self.axes_of(landmark) else { return };
        let above_m = self.world_m[above].unwrap_or_else(|| middle_m(&axes));
        if matches!(landmark, Landmark::Elbow(_) | Landmark::Knee(_)) {
            // Only the hinge: axes beyond it, which twist the limb, may pass at a distance.
            axes.truncate(1);
        }
        let point_m = match axes[..] {
            [axis] => {
                let way = axis.anchor_m - above_m;
                let is_along = axis.direction.dot(way).abs() > ALONG * way.length();
                if is_along { axis.anchor_m } else { axis.nearest_to(above_m) }
            }
            _ => meeting_point(&axes, above_m, TOWARDS),
        };
        self.set(landmark, last, point_m);
    }

    /// Sets the points of hands, toes and ankles that have no joint.
    fn ends(&mut self, side: Side, directions: &RigDirections) {
        let (elbow, wrist) = (Landmark::Elbow(side), Landmark::Wrist(side));
        if self.world_m[wrist].is_none()
            && let (Some(group), Some(elbow_m)) = (self.group(elbow), self.world_m[elbow])
            && let Some(last) = group.joints.last().copied()
        {
            let upper_m =
                self.world_m[Landmark::Shoulder(side)].map_or(0.0, |above| above.distance(elbow_m));
            let twist = group.joints.iter().skip(1).rev().find_map(|joint| {
                let anchor_m = self.rig.axes(*joint).first()?.anchor_m;
                (anchor_m.distance(elbow_m) > AWAY * upper_m).then_some(anchor_m)
            });
            let end_m = twist.unwrap_or_else(|| points::end_m(self.rig, last, &text::WRIST));
            if end_m.distance(elbow_m) > f64::EPSILON {
                self.set(wrist, last, end_m);
            }
        }
        let (knee, ankle, toe) = (Landmark::Knee(side), Landmark::Ankle(side), Landmark::Toe(side));
        if self.world_m[toe].is_some() {
            return;
        }
        if let Some(foot) = self.group(ankle).and_then(|group| group.joints.last().copied()) {
            let toe_m = points::toe_m(self.rig, foot, directions.forward, directions.up);
            self.set(toe, foot, toe_m);
        } else if let Some(shank) = self.group(knee).and_then(|group| group.joints.last().copied())
        {
            // A leg that ends in a shank stands on the end of the shank.
            self.set(ankle, shank, points::end_m(self.rig, shank, &text::ANKLE));
        }
    }

    fn directions(&self, forward: Option<DVec3>) -> RigDirections {
        let up = DVec3::Y;
        let flat = |v: DVec3| (v - up * up.dot(v)).try_normalize();
        let across = |landmark: fn(Side) -> Landmark| {
            let [left, right] = Side::ALL.map(|side| self.world_m[landmark(side)]);
            flat(left? - right?)
        };
        let left = forward
            .and_then(flat)
            .map(|forward| up.cross(forward))
            .or_else(|| across(Landmark::Hip))
            .or_else(|| across(Landmark::Shoulder))
            .or_else(|| self.reaching_forward().and_then(flat).map(|forward| up.cross(forward)))
            // x points forward in URDF and MJCF (REP 103).
            .or_else(|| flat(self.rig.poses[0].rotation * DVec3::X).map(|x| up.cross(x)))
            .unwrap_or(DVec3::NEG_Z);
        RigDirections { forward: left.cross(up), left, up }
    }

    /// Returns the direction in which a single arm reaches, unless it points up or down.
    fn reaching_forward(&self) -> Option<DVec3> {
        let arm = Side::ALL.into_iter().find_map(|side| self.group(Landmark::Shoulder(side)))?;
        let first = *arm.joints.first()?;
        let last = (first..self.rig.poses.len()).rfind(|body| self.rig.moves_with(*body, first))?;
        let way = self.rig.poses[last].position_m - self.rig.poses[first].position_m;
        (way.with_y(0.0).length() > 0.5 * way.length()).then_some(way)
    }

    fn hinges(&self, directions: &RigDirections) -> LandmarkMap<Option<Hinge>> {
        LandmarkMap::of(|landmark| {
            let (above, below) = match landmark {
                Landmark::Elbow(side) => (Landmark::Shoulder(side), Landmark::Wrist(side)),
                Landmark::Knee(side) => (Landmark::Hip(side), Landmark::Ankle(side)),
                _ => return None,
            };
            let joints = &self.group(landmark)?.joints;
            let here = self.world_m[landmark]?;
            let (upper, lower) = (here - self.world_m[above]?, self.world_m[below]? - here);
            hinge::hinge(self.rig, landmark, joints, upper, lower, directions)
        })
    }
}
