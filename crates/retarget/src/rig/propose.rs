//! Proposes a landmark for each joint, with a confidence.

use sinew_rig::Mechanism;

use super::at_zero::AtZero;
use super::chains::{Chain, chains, words_of};
use super::groups;
use super::matched::{Group, UnmatchedJoint};
use super::text::{self, Part};
use crate::{Landmark, Side};

/// Reduction of the confidence by each doubt.
const DOUBT: f64 = 0.25;

pub(super) fn propose(mechanism: &Mechanism) -> (Vec<Group>, Vec<UnmatchedJoint>) {
    let rig = AtZero::of(mechanism);
    let chains = chains(mechanism);
    let mut all: Vec<Group> = chains.iter().flat_map(|chain| of_chain(&rig, chain)).collect();
    if let Some(waist) = waist(&rig, &all) {
        all.push(waist);
    }
    doubt_partners(&mut all);
    all.sort_by_key(|group| group.landmark);
    let left_out = left_out(mechanism, &all);
    (all, left_out)
}

/// Returns the landmarks of a limb from the trunk outwards, with the words that name them.
fn landmarks(part: Part, side: Side) -> Vec<(Landmark, &'static [&'static str])> {
    match part {
        Part::Leg => vec![
            (Landmark::Hip(side), &text::HIP),
            (Landmark::Knee(side), &text::KNEE),
            (Landmark::Ankle(side), &text::ANKLE),
            (Landmark::Toe(side), &text::TOE),
        ],
        Part::Arm => vec![
            (Landmark::Shoulder(side), &text::SHOULDER),
            (Landmark::Elbow(side), &text::ELBOW),
            (Landmark::Wrist(side), &text::WRIST),
        ],
        Part::Head | Part::Trunk | Part::Other => Vec::new(),
    }
}

fn of_chain(rig: &AtZero<'_>, chain: &Chain) -> Vec<Group> {
    if chain.part == Part::Head {
        return vec![Group {
            landmark: Landmark::Head,
            joints: chain.joints.clone(),
            point: None,
            confidence: 1.0,
            reason: "named as neck or head".to_owned(),
        }];
    }
    let end_m = chain.joints.last().map_or(0.0, |last| super::points::reach_m(rig, *last));
    let steps = chain
        .joints
        .windows(2)
        .map(|pair| rig.poses[pair[0]].position_m.distance(rig.poses[pair[1]].position_m));
    let chain_m = steps.sum::<f64>() + end_m;
    let found = groups::groups(rig, &chain.joints, chain_m);
    // An arm whose names contain no side is taken for the right one, because most people demonstrate with that arm.
    let side = chain.side.unwrap_or(Side::Right);
    let landmarks = landmarks(chain.part, side);
    landmarks
        .into_iter()
        .zip(found)
        .map(|((landmark, words), joints)| {
            let mut doubts = Vec::new();
            if chain.side.is_none() {
                doubts.push("no name shows a side: right is a guess".to_owned());
            }
            if !chain.is_named {
                doubts.push("no name shows a limb: the only chain is taken for an arm".to_owned());
            }
            let says = |joint: &usize| text::has(&rig.mechanism.bodies[*joint].joint_name, words);
            if !joints.iter().any(says) {
                doubts.push(format!("no name says {}", words[0]));
            }
            Group { landmark, joints, point: None, confidence: 1.0, reason: String::new() }
                .doubted(&doubts)
        })
        .collect()
}

impl Group {
    fn doubted(mut self, doubts: &[String]) -> Self {
        for doubt in doubts {
            self.confidence *= 1.0 - DOUBT;
            if !self.reason.is_empty() {
                self.reason.push_str("; ");
            }
            self.reason.push_str(doubt);
        }
        if self.reason.is_empty() {
            "names and geometry agree".clone_into(&mut self.reason);
        }
        self
    }
}

/// Lowers the confidence of groups whose partner on the other side is missing or has another number of joints.
fn doubt_partners(groups: &mut [Group]) {
    let counts: Vec<(Landmark, usize)> =
        groups.iter().map(|group| (group.landmark, group.joints.len())).collect();
    for group in groups {
        let Some(partner) = group.landmark.mirrored() else { continue };
        let count = counts.iter().find(|(landmark, _)| *landmark == partner).map(|found| found.1);
        let doubt = match count {
            Some(count) if count == group.joints.len() => continue,
            Some(count) => {
                format!("{} has {count} joints, and this {}", partner.name(), group.joints.len())
            }
            None => format!("there is no {}", partner.name()),
        };
        *group = group.clone().doubted(&[doubt]);
    }
}

/// Returns the joints between the body that carries the hips and the body that carries the shoulders or, without
/// shoulders, the head; `None` if there are no such joints.
fn waist(rig: &AtZero<'_>, groups: &[Group]) -> Option<Group> {
    let carrier = super::derive::carrier;
    let pelvis = carrier(rig, groups, Landmark::Hip)?;
    let chest = carrier(rig, groups, Landmark::Shoulder).or_else(|| {
        let head = groups.iter().find(|group| group.landmark == Landmark::Head)?;
        rig.parent(*head.joints.first()?)
    })?;
    let common = rig.common_body(pelvis, chest);
    let up_from = |body| rig.way_to_base(body).take_while(|above| *above != common);
    let mut joints: Vec<usize> = up_from(pelvis).collect();
    let mut of_chest: Vec<usize> = up_from(chest).collect();
    of_chest.reverse();
    joints.extend(of_chest);
    (!joints.is_empty()).then(|| Group {
        landmark: Landmark::Chest,
        joints,
        point: None,
        confidence: 1.0,
        reason: "between hips and shoulders".to_owned(),
    })
}

fn left_out(mechanism: &Mechanism, groups: &[Group]) -> Vec<UnmatchedJoint> {
    let words = words_of(mechanism);
    let is_matched = |joint| groups.iter().any(|group| group.joints.contains(&joint));
    (1..mechanism.bodies.len())
        .filter(|joint| !is_matched(*joint))
        .map(|joint| {
            let reason = match words[joint].part {
                Some(Part::Other) => "by its name no joint of a performer: it stays at home",
                Some(_) => "beside the chain of its limb: it stays at home",
                None => "its name is not that of a part of a body: it stays at home",
            };
            UnmatchedJoint { joint, reason: reason.to_owned() }
        })
        .collect()
}
