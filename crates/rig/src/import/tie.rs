//! Joints that follow other joints: mimic joints (URDF) and equalities of joints (MJCF).

use std::collections::BTreeMap;

use super::note::{NoteKind, Notes};
use crate::description::{Description, Joint, JointType, LinkedLimit};

/// A relation `q[joint] = multiplier · q[of] + offset`, rad or m. If one of the joints turns and the other slides, the
/// multiplier is in rad/m or m/rad.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tie {
    pub(super) joint: String,
    pub(super) of: String,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

/// Ties joints by limits with equal ends, narrows the ranges of leaders to positions that their followers can reach,
/// and moves homes to positions that satisfy the ties. Adds a note on each cut, and on each joint that a rig cannot
/// tie.
pub(super) fn tie(ties: &[Tie], description: &mut Description, notes: &mut Notes) {
    let places: BTreeMap<String, usize> =
        description.joints.iter().enumerate().map(|(at, joint)| (joint.name.clone(), at)).collect();
    let joints = &mut description.joints;
    let mut tied = Vec::new();
    for tie in leaders_first(ties) {
        let ends = places.get(&tie.joint).zip(places.get(&tie.of));
        let Some((joint, of)) = ends else {
            let text = format!("follows `{}`, which is left out: nothing ties it now", tie.of);
            notes.add_of(NoteKind::LeftOut, text, &tie.joint);
            continue;
        };
        match check(tie, &joints[*joint], &joints[*of]) {
            Ok(()) => tied.push((tie, *joint, *of)),
            Err(why) => notes.add_of(NoteKind::LeftOut, why, tie.to_string()),
        }
    }
    // The last follower of a chain first, because its range bounds all before it.
    let mut kept = vec![true; tied.len()];
    for ((tie, joint, of), kept) in tied.iter().zip(&mut kept).rev() {
        match cut(tie, joints, *joint, *of) {
            Ok(Cut::Leader(range)) => {
                let text = "ranges of joints that others follow: cut to what these can";
                notes.add_of(
                    NoteKind::Changed,
                    text,
                    format!("{} {range} by {}", tie.of, tie.joint),
                );
            }
            Ok(Cut::Turned) => {
                let text = "the range of a follower permits one pose of its leader: taken as that of the leader, times the \
                            factor";
                notes.add_of(NoteKind::Doubtful, text, &tie.joint);
            }
            Ok(Cut::Nothing) => {}
            Err(why) => {
                notes.add_of(NoteKind::LeftOut, why, tie.to_string());
                *kept = false;
            }
        }
    }
    for ((tie, joint, of), _) in tied.into_iter().zip(kept).filter(|(_, kept)| *kept) {
        let limit = limit(tie, joints, joint, of);
        description.limits.push(limit);
        let text = "joints that follow others: a limit with equal ends ties each to the other. If one servo moves \
                    both, give them one drive: joints = [the other, this one], and a matrix [[1], [factor]]";
        notes.add_of(NoteKind::Changed, text, tie.to_string());
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

/// Checks that a rig can tie these joints.
fn check(tie: &Tie, joint: &Joint, of: &Joint) -> Result<(), &'static str> {
    let has_one_dof =
        |joint: &Joint| matches!(joint.kind, JointType::Revolute | JointType::Prismatic);
    if !has_one_dof(joint) || !has_one_dof(of) {
        return Err("only joints of one dof follow each other in a rig");
    }
    if tie.multiplier.abs() <= 0.0 {
        return Err(
            "a factor of zero: the joint does not follow, and the rig leaves it as any other",
        );
    }
    Ok(())
}

/// Change of ranges by a tie.
enum Cut {
    Nothing,
    /// The leader's range was narrowed: the new range as text.
    Leader(String),
    /// The follower's range was replaced by that of its leader, times the factor.
    Turned,
}

fn range(joint: &Joint) -> Option<[f64; 2]> {
    joint.range_m.or_else(|| joint.range_rad.first().copied())
}

/// Narrows the range of the leader to positions that the follower can reach; fails if nothing would remain.
fn cut(tie: &Tie, joints: &mut [Joint], joint: usize, of: usize) -> Result<Cut, &'static str> {
    let Some(own) = range(&joints[joint]) else { return Ok(Cut::Nothing) };
    let [a, b] = own.map(|end| (end - tie.offset) / tie.multiplier);
    let leader = &mut joints[of];
    let before = range(leader).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let [mut least, mut most] = [before[0].max(a.min(b)), before[1].min(a.max(b))];
    // Only one pose is common, though both can move: writers forget the sign of the factor in the follower's range.
    let can_move = |[least, most]: [f64; 2]| most > least + ROUNDING;
    if (most - least).abs() <= ROUNDING && can_move(own) && can_move(before) {
        let [a, b] = before.map(|end| tie.multiplier * end + tie.offset);
        set_range(&mut joints[joint], [a.min(b), a.max(b)]);
        return Ok(Cut::Turned);
    }
    if least > most + ROUNDING {
        return Err(
            "its range and that of the other one have nothing in common: the rig leaves it untied",
        );
    }
    // Rounding may exchange ends that are equal.
    (least, most) = (least.min(most), most.max(least));
    // The end 0 of a range often comes out as a few units of rounding.
    [least, most] = [least, most].map(|end| if end.abs() < ROUNDING { 0.0 } else { end });
    let is_less = least > before[0] + ROUNDING || most < before[1] - ROUNDING;
    if !is_less {
        return Ok(Cut::Nothing);
    }
    let shown = if leader.kind == JointType::Prismatic {
        format!("to {least:.4} .. {most:.4} m")
    } else {
        format!("to {:.2} .. {:.2} deg", least.to_degrees(), most.to_degrees())
    };
    set_range(leader, [least, most]);
    Ok(Cut::Leader(shown))
}

/// Sets the range of a joint of one dof, and its home within that.
fn set_range(joint: &mut Joint, [least, most]: [f64; 2]) {
    if joint.kind == JointType::Prismatic {
        joint.range_m = Some([least, most]);
    } else {
        joint.range_rad = vec![[least, most]];
    }
    for home in [&mut joint.home_m, &mut joint.home_rad] {
        *home = home.map(|home| home.max(least).min(most));
    }
}

/// Returns the limit of a tie, and moves the follower's home to the position that the leader's home gives it.
fn limit(tie: &Tie, joints: &mut [Joint], joint: usize, of: usize) -> LinkedLimit {
    let home_of = joints[of].home().first().copied().unwrap_or(0.0);
    let home = tie.multiplier * home_of + tie.offset;
    let joint = &mut joints[joint];
    let slides = joint.kind == JointType::Prismatic;
    let home = range(joint).map_or(home, |[least, most]| home.max(least).min(most));
    let at_home = joint.home().first().copied().unwrap_or(0.0);
    if (home - at_home).abs() > ROUNDING {
        if slides {
            joint.home_m = Some(home);
        } else {
            joint.home_rad = Some(home);
        }
    }
    let (rad, m) = if slides { (None, Some(tie.offset)) } else { (Some(tie.offset), None) };
    LinkedLimit {
        joint: tie.joint.clone(),
        other: tie.of.clone(),
        factor: 1.0,
        other_factor: 0.0 - tie.multiplier,
        least_rad: rad,
        most_rad: rad,
        least_m: m,
        most_m: m,
    }
}
