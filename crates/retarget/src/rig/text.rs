//! Reads side and part of the body from the words in a joint's name.

use crate::Side;

/// A part of a rig that is matched as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Arm,
    Leg,
    Head,
    Trunk,
    /// Parts that no performer has: fingers, grippers, antennas, rods without a drive.
    Other,
}

/// Side and part that a name contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Words {
    pub(super) side: Option<Side>,
    pub(super) part: Option<Part>,
}

pub(super) const HIP: [&str; 5] = ["hip", "thigh", "upleg", "upperleg", "femur"];
pub(super) const KNEE: [&str; 7] = ["knee", "calf", "shin", "shank", "lowleg", "lowerleg", "tibia"];
pub(super) const ANKLE: [&str; 5] = ["ankle", "ank", "foot", "feet", "sole"];
pub(super) const TOE: [&str; 2] = ["toe", "toes"];
pub(super) const SHOULDER: [&str; 5] = ["shoulder", "sho", "shldr", "upperarm", "uparm"];
pub(super) const ELBOW: [&str; 5] = ["elbow", "el", "forearm", "lowerarm", "lowarm"];
pub(super) const WRIST: [&str; 4] = ["wrist", "hand", "wri", "palm"];
const HEAD: [&str; 3] = ["head", "neck", "skull"];
const TRUNK: [&str; 10] =
    ["waist", "torso", "spine", "abs", "bust", "chest", "trunk", "abdomen", "pelvis", "lumbar"];
const OTHER: [&str; 24] = [
    "finger", "fingers", "thumb", "index", "middle", "ring", "pinky", "gripper", "grip", "claw",
    "jaw", "antenna", "ear", "eye", "lid", "brow", "passive", "rod", "rev", "act", "gear", "wheel",
    "clavicle", "tool",
];

/// Splits a name into words in lower case: at changes of case, punctuation and digits.
pub(super) fn tokens(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut words = Vec::new();
    let mut word = String::new();
    for (k, letter) in letters.iter().enumerate() {
        let before = k.checked_sub(1).map(|k| letters[k]);
        let begins = letter.is_uppercase()
            && (before.is_some_and(char::is_lowercase)
                // The last capital of a sequence begins a word: `LElbow`.
                || before.is_some_and(char::is_uppercase)
                    && letters.get(k + 1).is_some_and(|next| next.is_lowercase()));
        if begins || !letter.is_alphabetic() {
            words.push(std::mem::take(&mut word));
        }
        if letter.is_alphabetic() {
            word.extend(letter.to_lowercase());
        }
    }
    words.push(word);
    words.retain(|word| !word.is_empty());
    words
}

/// Returns whether a name contains one of these words.
pub(super) fn has(name: &str, words: &[&str]) -> bool {
    tokens(name).iter().any(|token| {
        words.contains(&token.as_str())
            || side_before_word(token).is_some_and(|(_, word)| words.contains(&word))
    })
}

/// Returns the side and part that a name contains.
pub(super) fn of(name: &str) -> Words {
    let tokens = tokens(name);
    let mut words = Words::default();
    for token in &tokens {
        let (side, word) = match token.as_str() {
            "left" | "l" => (Some(Side::Left), ""),
            "right" | "r" => (Some(Side::Right), ""),
            word => side_before_word(word).map_or((None, word), |(side, word)| (Some(side), word)),
        };
        words.side = words.side.or(side);
        let part = part_of(word);
        // A finger of the left hand counts as a finger.
        if part == Some(Part::Other) || words.part.is_none() {
            words.part = part.or(words.part);
        }
    }
    words
}

fn part_of(word: &str) -> Option<Part> {
    let is_in = |lists: &[&[&str]]| lists.iter().any(|list| list.contains(&word));
    if is_in(&[&OTHER]) {
        Some(Part::Other)
    } else if is_in(&[&HIP, &KNEE, &ANKLE, &TOE, &["leg"]]) {
        Some(Part::Leg)
    } else if is_in(&[&SHOULDER, &ELBOW, &WRIST, &["arm"]]) {
        Some(Part::Arm)
    } else if is_in(&[&HEAD]) {
        Some(Part::Head)
    } else if is_in(&[&TRUNK]) {
        Some(Part::Trunk)
    } else {
        None
    }
}

/// Splits a side's letter from a known word: `lankle`. Returns `None` if the whole is a known word itself, or the rest
/// is not one.
fn side_before_word(token: &str) -> Option<(Side, &str)> {
    if part_of(token).is_some() {
        return None;
    }
    let (side, word) = match token.split_at_checked(1)? {
        ("l", word) => (Side::Left, word),
        ("r", word) => (Side::Right, word),
        _ => return None,
    };
    part_of(word).map(|_| (side, word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_real_rigs_are_understood() {
        let left = Some(Side::Left);
        for (name, side, part) in [
            ("LElbowYaw", left, Some(Part::Arm)),
            ("left_ank_pitch", left, Some(Part::Leg)),
            ("l_arm_z", left, Some(Part::Arm)),
            ("leg_left_4_joint", left, Some(Part::Leg)),
            ("waist_yaw_joint", None, Some(Part::Trunk)),
            ("L_thumb_distal_joint", left, Some(Part::Other)),
            ("head_tilt", None, Some(Part::Head)),
            ("rankle", Some(Side::Right), Some(Part::Leg)),
            ("panda_joint1", None, None),
            ("2xl430_gears_2", None, None),
        ] {
            assert_eq!(of(name), Words { side, part }, "{name}");
        }
        assert_eq!(tokens("leftUpLeg2"), ["left", "up", "leg"]);
    }
}
