//! Assigns joints to limbs, by the words of their names and their place in the tree.

use sinew_rig::Mechanism;

use super::text::{self, Part, Words};
use crate::Side;

/// Joints of one limb or of the head, from the trunk outwards.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chain {
    pub(super) part: Part,
    /// Side of the limb; `None` for the head, or an arm whose names contain no side.
    pub(super) side: Option<Side>,
    pub(super) joints: Vec<usize>,
    /// Whether words determined the part.
    pub(super) is_named: bool,
}

/// Returns the words of each joint: its own, those of its body, and those inherited from its parent. The base has
/// none.
pub(super) fn words_of(mechanism: &Mechanism) -> Vec<Words> {
    let mut all: Vec<Words> = Vec::new();
    for link in &mechanism.bodies {
        let Some(parent) = link.parent else {
            all.push(Words::default());
            continue;
        };
        let (joint, body, above) = (text::of(&link.joint_name), text::of(&link.name), all[parent]);
        let part = match (joint.part.or(body.part), above.part) {
            // A joint beyond a finger belongs to the finger.
            (_, Some(Part::Other)) => Some(Part::Other),
            (None, above) => above,
            (own, _) => own,
        };
        let inherited = above.side.filter(|_| above.part == part);
        all.push(Words { part, side: joint.side.or(body.side).or(inherited) });
    }
    all
}

/// Returns all limbs, and the head.
pub(super) fn chains(mechanism: &Mechanism) -> Vec<Chain> {
    let words = words_of(mechanism);
    let mut chains = Vec::new();
    for part in [Part::Leg, Part::Arm] {
        for side in Side::ALL {
            let is_in = |joint: usize| words[joint] == Words { side: Some(side), part: Some(part) };
            let joints = longest(mechanism, is_in);
            if !joints.is_empty() {
                chains.push(Chain { part, side: Some(side), joints, is_named: true });
            }
        }
    }
    if !chains.iter().any(|chain| chain.part == Part::Arm) {
        chains.extend(only_arm(mechanism, &words, chains.is_empty()));
    }
    let is_head = |joint: usize| words[joint] == Words { side: None, part: Some(Part::Head) };
    let joints = longest(mechanism, is_head);
    if !joints.is_empty() {
        chains.push(Chain { part: Part::Head, side: None, joints, is_named: true });
    }
    chains
}

/// Returns an arm whose names contain no side. With `or_any`, accepts any chain if no name contains a known word.
fn only_arm(mechanism: &Mechanism, words: &[Words], or_any: bool) -> Option<Chain> {
    // An arm with an elbow needs at least three joints.
    const LEAST: usize = 3;
    let named = |joint: usize| words[joint] == Words { side: None, part: Some(Part::Arm) };
    let mut joints = longest(mechanism, named);
    let is_named = !joints.is_empty();
    if is_named {
        // A parent joint without known words belongs to the arm: the pan joint of a shoulder.
        while let Some(parent) = joints.first().and_then(|joint| mechanism.bodies[*joint].parent)
            && mechanism.bodies[parent].parent.is_some()
            && words[parent].part.is_none()
        {
            joints.insert(0, parent);
        }
    } else if or_any && words.iter().all(|words| matches!(words.part, None | Some(Part::Other))) {
        let unnamed = (1..words.len()).filter(|joint| words[*joint].part.is_none()).count();
        joints = longest(mechanism, |joint| words[joint].part.is_none());
        // A hand or a platform has several chains.
        if joints.len() != unnamed {
            return None;
        }
    }
    (joints.len() >= LEAST).then_some(Chain { part: Part::Arm, side: None, joints, is_named })
}

/// Returns the longest path outwards over the wanted joints; of equal paths the first.
fn longest(mechanism: &Mechanism, is_asked: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut ways: Vec<Vec<usize>> = vec![Vec::new(); mechanism.bodies.len()];
    let mut longest = Vec::new();
    for (joint, link) in mechanism.bodies.iter().enumerate() {
        let Some(parent) = link.parent else { continue };
        if is_asked(joint) {
            let mut way = ways[parent].clone();
            way.push(joint);
            if way.len() > longest.len() {
                longest.clone_from(&way);
            }
            ways[joint] = way;
        }
    }
    longest
}
