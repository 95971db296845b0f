//! A joint that takes part in idle life.

use glam::DVec3;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::moves::span_s;
use super::role::Role;

/// Shares of a joint's maximum speed and acceleration that one move uses. The splines of a show need the rest.
const SPEED_SHARE: f64 = 0.6;
const ACCELERATION_SHARE: f64 = 0.4;

/// A joint that takes part in idle life.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Actor {
    /// Name of the joint.
    pub(super) name: String,
    /// Role of the joint.
    pub(super) role: Role,
    /// Index of the body that the joint moves.
    pub(super) body: usize,
    /// Index of the joint's coordinate.
    pub(super) place: usize,
    /// Middle of the motion, rad or m. For a lid: the open position.
    pub(super) middle: f64,
    /// Change of the coordinate for the value 1, rad or m. It is negative if the axis points against the axis of the
    /// first joint of the role. For a lid: the way from open to closed.
    pub(super) amplitude: f64,
    speed: f64,
    acceleration: f64,
}

impl Actor {
    /// Returns the joint of a body as an actor, with a share of the usual amplitude. Returns `None` if the joint cannot
    /// take part: it neither turns about one axis nor slides, or it slides without a range.
    pub(super) fn of(mechanism: &Mechanism, body: usize, role: Role, share: f64) -> Option<Self> {
        let link = &mechanism.bodies[body];
        let slides = match link.joint {
            JointModel::Revolute(_) => false,
            JointModel::Prismatic(_) => true,
            _ => return None,
        };
        let home = *link.home.first()?;
        let largest = share * largest_deg(role).to_radians();
        let range =
            link.ranges.first().copied().filter(|range| range.iter().all(|x| x.is_finite()));
        let (least, most) = match range {
            Some([least, most]) => (least, most),
            None if slides => return None,
            None => (home - 3.0 * largest, home + 3.0 * largest),
        };
        let (middle, amplitude) = if role == Role::Blink {
            let far = if most - home > home - least { most } else { least };
            let is_lower = ["lower", "bottom"].iter().any(|word| link.joint_name.contains(word));
            // An upper lid closes by nine tenths of its range, a lower lid only a little.
            let way = if is_lower { 0.3 } else { 0.9 };
            (home, share * way * (far - home))
        } else {
            let largest = if slides { 0.1 * share * (most - least) } else { largest };
            let amplitude = largest.min(0.35 * (most - least));
            let margin = 1.2 * amplitude;
            (home.clamp(least + margin, most - margin), amplitude)
        };
        Some(Self {
            name: link.joint_name.clone(),
            role,
            body,
            place: mechanism.coordinate_ranges().get(body)?.start,
            middle,
            amplitude,
            speed: SPEED_SHARE * link.speed,
            acceleration: ACCELERATION_SHARE * link.acceleration,
        })
    }

    /// Returns the duration of a move that changes the value by `change`, s.
    pub(super) fn span_s(&self, change: f64) -> f64 {
        span_s(change * self.amplitude.abs(), self.speed, self.acceleration)
    }
}

/// Reverses the amplitude of each joint whose axis points against the axis of the first joint of its role. Brows mirror
/// each other.
pub(super) fn align(mechanism: &Mechanism, actors: &mut [Actor]) {
    let poses = mechanism.poses(&mechanism.home());
    let axis = |actor: &Actor| match mechanism.bodies[actor.body].joint {
        JointModel::Revolute(axis) | JointModel::Prismatic(axis) => {
            poses[actor.body].rotation * axis
        }
        _ => DVec3::ZERO,
    };
    let is_right =
        |name: &str| name.contains("right") || name.starts_with("r_") || name.ends_with("_r");
    for role in Role::all().filter(|role| *role != Role::Blink) {
        let mut first = None;
        for actor in actors.iter_mut().filter(|actor| actor.role == role) {
            let mut sign = axis(actor).dot(*first.get_or_insert(axis(actor)));
            if role == Role::Brow && is_right(&actor.name) {
                sign = -sign;
            }
            if sign < 0.0 {
                actor.amplitude = -actor.amplitude;
            }
        }
    }
}

/// Returns the largest amplitude of a role, deg.
fn largest_deg(role: Role) -> f64 {
    match role {
        Role::EyeTurn => 16.0,
        Role::HeadTurn => 12.0,
        Role::EyeNod => 8.0,
        Role::HeadNod | Role::Brow => 6.0,
        Role::HeadTilt => 4.0,
        Role::Weight | Role::Sway => 3.0,
        Role::Breath => 2.5,
        Role::Blink | Role::Still => 0.0,
    }
}
