//! Joints that follow other joints: mimic joints (URDF) and equalities of joints (MJCF).

use std::collections::BTreeMap;

use super::note::{NoteKind, Notes};
use crate::description::{Description, Joint, JointType, LinkedLimit};

/// A relation `q[joint] = multiplier · q[of] + offset`, rad or m.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tie {
    pub(super) joint: String,
    pub(super) of: String,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

/// Ties joints by limits with equal ends, and moves their homes to positions that satisfy these limits. Adds a note
/// on each joint that a rig cannot tie.
pub(super) fn tie(ties: &[Tie], description: &mut Description, notes: &mut Notes) {
    let places: BTreeMap<String, usize> =
        description.joints.iter().enumerate().map(|(at, joint)| (joint.name.clone(), at)).collect();
    for tie in leaders_first(ties) {
        let ends = places.get(&tie.joint).zip(places.get(&tie.of));
        let Some((joint, of)) = ends else {
            let text = format!("follows `{}`, which is left out: nothing ties it now", tie.of);
            notes.add_of(NoteKind::LeftOut, text, &tie.joint);
            continue;
        };
        let (joint, of) = (*joint, *of);
        match limit(tie, &mut description.joints, joint, of) {
            Ok(limit) => {
                description.limits.push(limit);
                let text = "joints that follow others: a limit with equal ends ties each to the other. If one servo \
                            moves both, give them one drive: joints = [the other, this one], and a matrix \
                            [[1], [factor]]";
                notes.add_of(NoteKind::Changed, text, tie.to_string());
            }
            Err(why) => notes.add_of(NoteKind::LeftOut, why, tie.to_string()),
        }
    }
}

impl std::fmt::Display for Tie {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { joint, of, multiplier, offset } = self;
        write!(f, "{joint} = {multiplier} {of} + {offset}")
    }
}

/// Sorts ties so that a joint is tied before those that follow it; circular ties keep the order of the file.
fn leaders_first(ties: &[Tie]) -> Vec<&Tie> {
    let of: BTreeMap<&str, usize> =
        ties.iter().enumerate().map(|(at, tie)| (tie.joint.as_str(), at)).collect();
    let mut is_in = vec![false; ties.len()];
    let mut order = Vec::new();
    for start in 0..ties.len() {
        let mut way = Vec::new();
        let mut at = Some(start);
        while let Some(here) = at.filter(|here| !is_in[*here]) {
            is_in[here] = true;
            way.push(&ties[here]);
            at = of.get(ties[here].of.as_str()).copied();
        }
        order.extend(way.into_iter().rev());
    }
    order
}

/// Tolerance for rounding of a sum of products, rad or m. It is far below any motion that matters.
const ROUNDING: f64 = 1e-9;

fn limit(
    tie: &Tie,
    joints: &mut [Joint],
    joint: usize,
    of: usize,
) -> Result<LinkedLimit, &'static str> {
    let slides = match (joints[joint].kind, joints[of].kind) {
        (JointType::Revolute, JointType::Revolute) => false,
        (JointType::Prismatic, JointType::Prismatic) => true,
        (
            JointType::Revolute | JointType::Prismatic,
            JointType::Revolute | JointType::Prismatic,
        ) => {
            return Err(
                "one turns and the other slides: nothing ties them, until one servo drives both by a matrix \
                        [[1], [factor]]",
            );
        }
        _ => return Err("only joints of one dof follow each other in a rig"),
    };
    if tie.multiplier.abs() <= 0.0 {
        return Err(
            "a factor of zero: the joint does not follow, and the rig leaves it as any other",
        );
    }
    let home_of = joints[of].home().first().copied().unwrap_or(0.0);
    let home = tie.multiplier * home_of + tie.offset;
    let joint = &mut joints[joint];
    let range = if slides { joint.range_m } else { joint.range_rad.first().copied() };
    if let Some([least, most]) = range
        && (home < least - ROUNDING || home > most + ROUNDING)
    {
        return Err("with the other one at home it is out of its range: the rig leaves it untied");
    }
    let home = range.map_or(home, |[least, most]| home.max(least).min(most));
    let at_home = joint.home().first().copied().unwrap_or(0.0);
    if (home - at_home).abs() > ROUNDING {
        if slides {
            joint.home_m = Some(home);
        } else {
            joint.home_rad = Some(home);
        }
    }
    let (rad, m) = if slides { (None, Some(tie.offset)) } else { (Some(tie.offset), None) };
    Ok(LinkedLimit {
        joint: tie.joint.clone(),
        other: tie.of.clone(),
        factor: 1.0,
        other_factor: 0.0 - tie.multiplier,
        least_rad: rad,
        most_rad: rad,
        least_m: m,
        most_m: m,
    })
}
