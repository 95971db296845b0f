//! Checks joints: the keys that each type needs, accepts and refuses.

use std::f64::consts::PI;

use super::part::{Part, Sign, UNIT_TOLERANCE, shown};
use crate::description::error::{DescriptionError, Step};
use crate::description::{Joint, JointType};

pub(super) fn check(part: Part<'_>, joint: &Joint) -> Result<(), DescriptionError> {
    part.numbers(&[Step::Key("position_m")], &joint.position_m, Sign::Any)?;
    part.unit_length("rotation_xyzw", &joint.rotation_xyzw)?;
    refuse_superfluous(part, joint)?;
    check_axes(part, joint)?;
    check_ranges(part, joint)?;
    check_home(part, joint)?;
    for (key, limit) in [
        ("speed_deg_s", joint.speed_rad_s),
        ("speed_m_s", joint.speed_m_s),
        ("acceleration_deg_s2", joint.acceleration_rad_s2),
        ("acceleration_m_s2", joint.acceleration_m_s2),
    ] {
        part.number_if_any(key, limit, Sign::Motion)?;
    }
    part.number_if_any("effort", joint.effort, Sign::Positive)?;
    for (key, value) in [
        ("rotor_inertia", joint.rotor_inertia),
        ("friction", Some(joint.friction)),
        ("damping", Some(joint.damping)),
    ] {
        part.number_if_any(key, value, Sign::NotNegative)?;
    }
    Ok(())
}

/// Refuses keys that do not apply to this type of joint, such as a range in metres of a joint that turns.
fn refuse_superfluous(part: Part<'_>, joint: &Joint) -> Result<(), DescriptionError> {
    use JointType::{Fixed, Free, Prismatic, Revolute, Spherical, Universal};
    let kind = joint.kind;
    let turns = matches!(kind, Revolute | Universal | Spherical);
    let slides = kind == Prismatic;
    let driven = turns || slides;
    let keys = [
        ("axis", joint.axis.is_some(), matches!(kind, Revolute | Prismatic | Universal)),
        ("second_axis", joint.second_axis.is_some(), kind == Universal),
        ("range_deg", !joint.range_rad.is_empty(), turns),
        ("range_m", joint.range_m.is_some(), slides),
        ("home_deg", joint.home_rad.is_some(), kind == Revolute),
        ("home_m", joint.home_m.is_some(), slides),
        ("speed_deg_s", joint.speed_rad_s.is_some(), turns),
        ("speed_m_s", joint.speed_m_s.is_some(), slides),
        ("acceleration_deg_s2", joint.acceleration_rad_s2.is_some(), turns),
        ("acceleration_m_s2", joint.acceleration_m_s2.is_some(), slides),
        ("effort", joint.effort.is_some(), driven),
        ("rotor_inertia", joint.rotor_inertia.is_some(), driven),
        ("friction", joint.friction.abs() > 0.0, driven),
        ("damping", joint.damping.abs() > 0.0, driven),
    ];
    let why = match kind {
        Fixed => "a fixed joint leaves nothing free",
        Revolute => "a revolute joint turns about one axis",
        Prismatic => "a prismatic joint slides along its axis",
        Universal => "a universal joint turns about two axes",
        Spherical => "a spherical joint turns about any axis",
        Free => "a free joint moves in any way, and has no drive",
    };
    for (key, is_there, has_use) in keys {
        if is_there && !has_use {
            let other_unit = keys.iter().find(|(other, _, has_use)| {
                *has_use && *other != key && key.split('_').next() == other.split('_').next()
            });
            let expected = match other_unit {
                Some((other, _, _)) => format!("{other}, since {why}"),
                None => format!("no {key}, since {why}"),
            };
            return Err(part.refuse(&[Step::Key(key)], expected, key));
        }
    }
    Ok(())
}

fn check_axes(part: Part<'_>, joint: &Joint) -> Result<(), DescriptionError> {
    let axis = |key: &'static str, axis: Option<[f64; 3]>| {
        let expected = "the axis as a vector of length 1, such as [0, 0, 1]";
        let axis = axis.ok_or_else(|| part.refuse(&[Step::Key(key)], expected, "nothing"))?;
        part.unit_length(key, &axis).map(|()| axis)
    };
    match joint.kind {
        JointType::Revolute | JointType::Prismatic => {
            axis("axis", joint.axis)?;
        }
        JointType::Universal => {
            let first = axis("axis", joint.axis)?;
            let second = axis("second_axis", joint.second_axis)?;
            let cosine: f64 = first.iter().zip(&second).map(|(a, b)| a * b).sum();
            if cosine.abs() > UNIT_TOLERANCE {
                let expected = "a right angle between axis and second_axis";
                let found = format!("{:.1} deg", cosine.clamp(-1.0, 1.0).acos().to_degrees());
                return Err(part.refuse(&[Step::Key("second_axis")], expected, found));
            }
        }
        JointType::Fixed | JointType::Spherical | JointType::Free => {}
    }
    Ok(())
}

fn check_ranges(part: Part<'_>, joint: &Joint) -> Result<(), DescriptionError> {
    if let Some(range_m) = joint.range_m {
        check_range(part, &[Step::Key("range_m")], range_m)?;
    }
    let at = [Step::Key("range_deg")];
    for pair in &joint.range_rad {
        check_range(part, &at, *pair)?;
    }
    let count = if joint.kind == JointType::Universal { 2 } else { 1 };
    if !joint.range_rad.is_empty() && joint.range_rad.len() != count {
        let expected = match joint.kind {
            JointType::Universal => "two pairs [least, most], one for each axis",
            _ => "one pair [least, most]",
        };
        return Err(part.refuse(&at, expected, joint.range_rad.len()));
    }
    match (joint.kind, &joint.range_rad[..]) {
        (JointType::Spherical, [[least, most]]) if least.abs() > 0.0 || *most > PI => {
            let expected = "[0, most], the angle away from the zero pose, at most 180 deg";
            let found = format!("{} to {}", shown(&at, *least), shown(&at, *most));
            Err(part.refuse(&at, expected, found))
        }
        _ => Ok(()),
    }
}

/// Refuses a range whose minimum is above its maximum.
pub(super) fn check_range(
    part: Part<'_>,
    at: &[Step],
    [least, most]: [f64; 2],
) -> Result<(), DescriptionError> {
    part.numbers(at, &[least, most], Sign::Any)?;
    if least <= most {
        Ok(())
    } else {
        let found = format!("{}, then {}", shown(at, least), shown(at, most));
        Err(part.refuse(at, "the least value, then the most", found))
    }
}

fn check_home(part: Part<'_>, joint: &Joint) -> Result<(), DescriptionError> {
    let (key, home, range) = if joint.kind == JointType::Prismatic {
        ("home_m", joint.home_m, joint.range_m)
    } else {
        ("home_deg", joint.home_rad, joint.range_rad.first().copied())
    };
    part.number_if_any(key, home, Sign::Any)?;
    match (home, range) {
        (Some(home), Some([least, most])) if home < least || home > most => {
            let at = [Step::Key(key)];
            let expected =
                format!("a position in the range, {} to {}", shown(&at, least), shown(&at, most));
            Err(part.refuse(&at, expected, shown(&at, home)))
        }
        _ => Ok(()),
    }
}
