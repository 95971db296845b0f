//! Limits that join two joints.

use super::names::Names;
use super::part::{Part, Sign, shown};
use crate::description::error::{DescriptionError, Step};
use crate::description::{Description, JointType, LinkedLimit};

/// What a sum of two products of angles or ways is off by through rounding, far below anything that moves, rad or m.
const ROUNDING: f64 = 1e-9;

pub(super) fn check(
    rig: &Description,
    joints: &Names<'_>,
    index: usize,
    limit: &LinkedLimit,
) -> Result<(), DescriptionError> {
    let part = Part::of("limit", index, &limit.joint);
    let find = |key, name: &str| {
        let joint = &rig.joints[joints.find(part, &[Step::Key(key)], name)?];
        match joint.kind {
            JointType::Revolute | JointType::Prismatic => Ok(joint),
            _ => {
                let expected = "a revolute or a prismatic joint";
                let found = format!("{name:?}, which is neither");
                Err(part.refuse(&[Step::Key(key)], expected, found))
            }
        }
    };
    let joint = find("joint", &limit.joint)?;
    let other = find("other", &limit.other)?;
    if limit.joint == limit.other {
        let expected = "another joint; the range of a single one is the joint's own";
        return Err(part.refuse(
            &[Step::Key("other")],
            expected,
            format!("{:?} twice", limit.other),
        ));
    }
    if joint.kind != other.kind {
        let expected = "two joints that turn, or two that slide";
        let found = format!("{:?} and {:?}, one of each", limit.joint, limit.other);
        return Err(part.refuse(&[Step::Key("other")], expected, found));
    }
    for (key, factor) in [("factor", limit.factor), ("other_factor", limit.other_factor)] {
        let at = [Step::Key(key)];
        part.number(&at, factor, Sign::Any)?;
        if factor.abs() <= 0.0 {
            return Err(part.refuse(&at, "a factor other than 0", "0"));
        }
    }
    let (keys, ends, wrong) = if joint.kind == JointType::Prismatic {
        let wrong = [("least_deg", limit.least_rad), ("most_deg", limit.most_rad)];
        (["least_m", "most_m"], [limit.least_m, limit.most_m], wrong)
    } else {
        let wrong = [("least_m", limit.least_m), ("most_m", limit.most_m)];
        (["least_deg", "most_deg"], [limit.least_rad, limit.most_rad], wrong)
    };
    for ((wrong, value), right) in wrong.iter().zip(keys) {
        if value.is_some() {
            let what = if joint.kind == JointType::Prismatic { "slide" } else { "turn" };
            let expected = format!("{right}, since the joints {what}");
            return Err(part.refuse(&[Step::Key(*wrong)], expected, wrong));
        }
    }
    let [(least_at, least), (most_at, most)] =
        [([Step::Key(keys[0])], ends[0]), ([Step::Key(keys[1])], ends[1])];
    part.number_if_any(keys[0], least, Sign::Any)?;
    part.number_if_any(keys[1], most, Sign::Any)?;
    match (least, most) {
        (None, None) => {
            return Err(part.refuse(&[], format!("{} or {}", keys[0], keys[1]), "neither"));
        }
        (Some(least), Some(most)) if least > most => {
            let expected = format!("at least {}, as {}", shown(&least_at, least), keys[0]);
            return Err(part.refuse(&most_at, expected, shown(&most_at, most)));
        }
        _ => {}
    }
    let position = |home: Vec<f64>| home.first().copied().unwrap_or(0.0);
    let sum = limit.factor * position(joint.home()) + limit.other_factor * position(other.home());
    for (at, is_kept, end) in [
        (least_at, least.is_none_or(|least| sum >= least - ROUNDING), least),
        (most_at, most.is_none_or(|most| sum <= most + ROUNDING), most),
    ] {
        if let (false, Some(end)) = (is_kept, end) {
            let expected = "a home pose that keeps the limit";
            let found = format!("{} there, and the limit {}", shown(&at, sum), shown(&at, end));
            return Err(part.refuse(&at, expected, found));
        }
    }
    Ok(())
}
