//! Checks limits that join two joints.

use super::names::Names;
use super::part::{Part, Sign, shown};
use crate::description::error::{DescriptionError, Step};
use crate::description::{Description, Joint, JointType, LinkedLimit};

/// Tolerance for rounding of a sum of two products, rad or m. It is far below any motion that matters.
const ROUNDING: f64 = 1e-9;

pub(super) fn check(
    rig: &Description,
    joints: &Names<'_>,
    index: usize,
    limit: &LinkedLimit,
) -> Result<(), DescriptionError> {
    let part = Part::of("limit", index, &limit.joint);
    let pair = check_joints(part, rig, joints, limit)?;
    for (key, factor) in [("factor", limit.factor), ("other_factor", limit.other_factor)] {
        let at = [Step::Key(key)];
        part.number(&at, factor, Sign::Any)?;
        if factor.abs() <= 0.0 {
            return Err(part.refuse(&at, "a factor other than 0", "0"));
        }
    }
    let ends = check_ends(part, limit, pair[0].kind == JointType::Prismatic)?;
    let [home, other_home] = pair.map(|joint| joint.home().first().copied().unwrap_or(0.0));
    let sum = limit.factor * home + limit.other_factor * other_home;
    for ((key, end), sign) in ends.into_iter().zip([1.0, -1.0]) {
        let at = [Step::Key(key)];
        if let Some(end) = end.filter(|end| sign * (sum - end) < -ROUNDING) {
            let found = format!("{} there, and the limit {}", shown(&at, sum), shown(&at, end));
            return Err(part.refuse(&at, "a home pose that keeps the limit", found));
        }
    }
    Ok(())
}

/// Returns the two joints. Each must have one dof.
fn check_joints<'a>(
    part: Part<'_>,
    rig: &'a Description,
    joints: &Names<'_>,
    limit: &LinkedLimit,
) -> Result<[&'a Joint; 2], DescriptionError> {
    let find = |key, name: &str| {
        let at = [Step::Key(key)];
        let joint = &rig.joints[joints.find(part, &at, name)?];
        if matches!(joint.kind, JointType::Revolute | JointType::Prismatic) {
            Ok(joint)
        } else {
            let found = format!("{name:?}, which is neither");
            Err(part.refuse(&at, "a revolute or a prismatic joint", found))
        }
    };
    let pair = [find("joint", &limit.joint)?, find("other", &limit.other)?];
    if limit.joint == limit.other {
        let expected = "another joint; the range of a single one is the joint's own";
        let found = format!("{:?} twice", limit.other);
        return Err(part.refuse(&[Step::Key("other")], expected, found));
    }
    Ok(pair)
}

/// Returns the minimum and the maximum of the sum, each with its key. `slide`: whether the first joint slides, so that
/// the sum is in m.
fn check_ends(
    part: Part<'_>,
    limit: &LinkedLimit,
    slide: bool,
) -> Result<[(&'static str, Option<f64>); 2], DescriptionError> {
    let turns = [("least_deg", limit.least_rad), ("most_deg", limit.most_rad)];
    let slides = [("least_m", limit.least_m), ("most_m", limit.most_m)];
    let (right, wrong, why) =
        if slide { (slides, turns, "slides") } else { (turns, slides, "turns") };
    for ((wrong, value), (right, _)) in wrong.into_iter().zip(right) {
        if value.is_some() {
            let expected = format!("{right}, since {:?} {why}", limit.joint);
            return Err(part.refuse(&[Step::Key(wrong)], expected, wrong));
        }
    }
    for (key, end) in right {
        part.number_if_any(key, end, Sign::Any)?;
    }
    let [(least_key, least), (most_key, most)] = right;
    match (least, most) {
        (None, None) => Err(part.refuse(&[], format!("{least_key} or {most_key}"), "neither")),
        (Some(least), Some(most)) if least > most => {
            let at = [Step::Key(most_key)];
            let expected = format!("at least {}, as {least_key}", shown(&at, least));
            Err(part.refuse(&at, expected, shown(&at, most)))
        }
        _ => Ok(right),
    }
}
