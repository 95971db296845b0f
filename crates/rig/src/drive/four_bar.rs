//! A drive of one servo and one joint by a four-bar linkage, in closed form.

use core::f32::consts::TAU;

use sinew_core::coordinates::nearest_turn;
use sinew_core::glam::Vec2;
use sinew_core::math;

use super::error::DriveError;
use super::numbers::{Numbers, bounded, collect};
use super::pose::{DrivePose, Tangent};
use crate::limited::{LimitReason, within};

/// Minimum angle between crank and rod, and between rod and lever. At 5 deg the force in a lever is eleven times
/// that at 90 deg; good designs stay above 30 deg.
const LEAST_ANGLE_RAD: f32 = 5.0 * math::PI / 180.0;

/// Accepted lengths of links, m: from a push-rod of a watch to that of a crane.
const LENGTHS_M: [f32; 2] = [1e-4, 10.0];

/// A four-bar linkage: a rod connects the servo's horn (the crank) to a lever on the joint (the rocker).
///
/// Angles of crank and rocker are counterclockwise from the ground line, which leads from the servo's axis to the
/// joint's axis. Within the servo's range, the angle between crank and rod and that between rod and lever must be
/// at least 5 deg: if crank and rod are in line, the servo no longer moves the joint, and if rod and lever are in
/// line, it cannot hold the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FourBar {
    links: Links,
    range_rad: [f32; 2],
    joint_rad: [f32; 2],
    /// Side of the rod's far end, seen along the line from the joint's axis to the crank's tip: 1 or -1.
    side: f32,
    /// Side of the crank's tip, seen along the line from the servo's axis to the rod's far end: 1 or -1.
    elbow: f32,
}

/// Lengths of a four-bar's links, and its angles at zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Links {
    /// Distance from the servo's axis to the joint's axis, m.
    pub ground_m: f32,
    /// Length of the servo's horn, m.
    pub crank_m: f32,
    /// Length of the rod, m.
    pub coupler_m: f32,
    /// Length of the lever on the joint, m.
    pub rocker_m: f32,
    /// Angle of the crank when the servo is at zero, rad.
    pub crank_zero_rad: f32,
    /// Angle of the rocker when the joint is at zero, rad.
    pub rocker_zero_rad: f32,
    /// Selects one of the two ways to assemble the links. Not crossed: when the servo is at zero, crank and rocker
    /// are on the same side of the ground line.
    pub crossed: bool,
}

/// The linkage at one position. The origin is at the servo's axis, and x points to the joint's axis.
#[derive(Clone, Copy)]
struct Closed {
    /// Position of the crank's tip.
    tip: Vec2,
    /// Vector from the joint's axis to the rod's far end.
    lever: Vec2,
    rod: Vec2,
}

impl Closed {
    /// Returns the angle between the lines of two links, 0 to π/2.
    fn angle(a: Vec2, b: Vec2) -> f32 {
        math::atan2(a.perp_dot(b).abs(), a.dot(b).abs())
    }

    /// Returns dq/ds, which follows from the constant length of the rod.
    fn slope(&self) -> f32 {
        self.tip.perp_dot(self.rod) / self.lever.perp_dot(self.rod)
    }
}

impl FourBar {
    /// Creates a linkage whose servo moves within a range, rad.
    ///
    /// # Errors
    /// [`DriveError`] if a number is not finite, a length is not from 0.1 mm to 10 m, an angle is above 360 deg in
    /// absolute value, the servo's range is empty or a whole turn, the links cannot be connected everywhere in that
    /// range or come too close to a line there, or the rocker turns by more than 180 deg from its zero.
    pub fn new(links: Links, range_rad: [f32; 2]) -> Result<Self, DriveError> {
        for (what, length) in [
            ("ground_m", links.ground_m),
            ("crank_m", links.crank_m),
            ("coupler_m", links.coupler_m),
            ("rocker_m", links.rocker_m),
        ] {
            bounded(what, 0, length, LENGTHS_M)?;
        }
        let [least, most] = range_rad;
        for (index, angle) in
            [links.crank_zero_rad, links.rocker_zero_rad, least, most].into_iter().enumerate()
        {
            bounded("angle", index, angle, [-TAU, TAU])?;
        }
        // Less than a turn, by about one step of an encoder with 4096 steps.
        bounded("width of the servo's range", 0, most - least, [1e-3, TAU - 1e-3])?;
        let mut all = Self { links, range_rad, joint_rad: [0.0; 2], side: 1.0, elbow: 1.0 };
        let (crank_side, _) = math::sin_cos(links.crank_zero_rad);
        all.side = if (crank_side < 0.0) == links.crossed { 1.0 } else { -1.0 };
        all.check()?;
        let at = |servo_rad| all.close(servo_rad).ok_or(DriveError::Open { servo_rad });
        let (first, last) = (at(least)?, at(most)?);
        let (from, to) = (all.joint_of(&first), all.joint_of(&last));
        if (to - from) * first.slope() <= 0.0 {
            return Err(DriveError::RockerWraps);
        }
        let end = first.lever + Vec2::new(links.ground_m, 0.0);
        all.elbow = if end.perp_dot(first.tip) < 0.0 { -1.0 } else { 1.0 };
        all.joint_rad = [from, to];
        Ok(all)
    }

    /// Returns the lengths and zero angles of the links.
    pub fn links(&self) -> Links {
        self.links
    }

    /// Returns the servo's range, rad.
    pub fn range_rad(&self) -> [f32; 2] {
        self.range_rad
    }

    /// Checks both angles at every position where they can have a minimum: at the ends of the range, where the
    /// crank is on the ground line, where crank and rod are in line, and where the rocker is on the ground line.
    fn check(&self) -> Result<(), DriveError> {
        let Links { ground_m: g, crank_m: a, coupler_m: b, rocker_m: c, .. } = self.links;
        let [least, most] = self.range_rad;
        // NaN angles belong to positions that the linkage cannot reach.
        let corner = |near: f32, next: f32, far: f32| {
            let cosine = (near * near + next * next - far * far) / (2.0 * near * next);
            math::atan2(math::sqrt((1.0 - cosine) * (1.0 + cosine)), cosine)
        };
        let (stretched, folded) = (corner(a + b, g, c), math::PI - corner(b - a, g, c));
        let (outward, inward) = (corner(a, g + c, b), corner(a, g - c, b));
        let crank_angles = [0.0, math::PI].into_iter().chain(
            [stretched, folded, outward, inward].into_iter().flat_map(|angle| [angle, -angle]),
        );
        let places = crank_angles
            .map(|crank| nearest_turn(crank - self.links.crank_zero_rad, 0.5 * (least + most)))
            // The comparisons also drop NaN.
            .filter(|servo| *servo >= least && *servo <= most);
        for servo_rad in [least, most].into_iter().chain(places) {
            let closed = self.close(servo_rad).ok_or(DriveError::Open { servo_rad })?;
            let least_rad = LEAST_ANGLE_RAD;
            let found_rad = Closed::angle(closed.lever, closed.rod);
            if found_rad < least_rad {
                return Err(DriveError::Transmission { servo_rad, found_rad, least_rad });
            }
            let found_rad = Closed::angle(closed.tip, closed.rod);
            if found_rad < least_rad {
                return Err(DriveError::Toggle { servo_rad, found_rad, least_rad });
            }
        }
        Ok(())
    }

    /// Returns the linkage at a servo position; `None` if the links cannot be connected.
    fn close(&self, servo_rad: f32) -> Option<Closed> {
        let links = &self.links;
        let tip = turned(links.crank_m, servo_rad + links.crank_zero_rad);
        let ground = Vec2::new(links.ground_m, 0.0);
        let lever = third_corner(tip - ground, links.rocker_m, links.coupler_m, self.side)?;
        Some(Closed { tip, lever, rod: ground + lever - tip })
    }

    fn joint_of(&self, closed: &Closed) -> f32 {
        let angle = math::atan2(closed.lever.y, closed.lever.x);
        nearest_turn(angle - self.links.rocker_zero_rad, 0.0)
    }

    pub(super) fn at_servo(&self, s: f32) -> DrivePose<'_> {
        let servo = within(s, self.range_rad, LimitReason::Range);
        self.pose(servo.value, servo.reason)
    }

    pub(super) fn at_joint(&self, q: f32) -> DrivePose<'_> {
        let links = &self.links;
        let [from, to] = self.joint_rad;
        let joint = within(q, [from.min(to), from.max(to)], LimitReason::Range);
        let lever = turned(links.rocker_m, joint.value + links.rocker_zero_rad);
        let end = lever + Vec2::new(links.ground_m, 0.0);
        let [least, most] = self.range_rad;
        let tip = third_corner(end, links.crank_m, links.coupler_m, -self.elbow);
        // Always some, because the range was checked.
        let servo = tip.map_or(least, |tip| {
            let servo = math::atan2(tip.y, tip.x) - links.crank_zero_rad;
            nearest_turn(servo, 0.5 * (least + most)).max(least).min(most)
        });
        DrivePose { joints: collect([joint.value]), ..self.pose(servo, joint.reason) }
    }

    fn pose(&self, servo: f32, reason: Option<LimitReason>) -> DrivePose<'_> {
        let one = |number: f32| -> Numbers { collect([number]) };
        // Always some, because the range was checked.
        let (joint, slope) =
            self.close(servo).map_or((0.0, 1.0), |closed| (self.joint_of(&closed), closed.slope()));
        DrivePose { joints: one(joint), servos: one(servo), reason, tangent: Tangent::Slope(slope) }
    }
}

fn turned(length: f32, angle: f32) -> Vec2 {
    let (sine, cosine) = math::sin_cos(angle);
    Vec2::new(length * cosine, length * sine)
}

/// Returns the vector from the first corner of a triangle to the third. `second` is the vector to the second
/// corner; the third is at `distance` from the first and at `far` from the second. `side` is 1 if the third corner
/// is clockwise of the second, -1 if counterclockwise. `None` if there is no such triangle.
fn third_corner(second: Vec2, distance: f32, far: f32, side: f32) -> Option<Vec2> {
    let base = math::sqrt(second.dot(second));
    let cosine = (distance * distance + base * base - far * far) / (2.0 * distance * base);
    // NaN is not in the range either.
    if !(-1.0..=1.0).contains(&cosine) {
        return None;
    }
    let along = second * (distance / base);
    let sine = math::sqrt((1.0 - cosine) * (1.0 + cosine));
    Some(along * cosine - along.perp() * (sine * side))
}
