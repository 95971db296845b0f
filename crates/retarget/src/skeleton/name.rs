//! Side, part and kind of a joint, derived from its name.

use std::collections::BTreeSet;

use super::text::words;
use super::vocabulary::Word;
use crate::Side;

/// A part of a body that names can mean; there are more parts than landmarks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Pelvis,
    Spine,
    Chest,
    Neck,
    Head,
    Clavicle,
    Shoulder,
    Elbow,
    Wrist,
    Hip,
    Knee,
    Ankle,
    Toe,
}

impl Part {
    /// Returns whether makers exchange the names of these parts of the trunk: a pelvis or head called spine, a
    /// chest called neck.
    pub(super) fn is_near(self, named: Self) -> bool {
        matches!(
            (self, named),
            (Self::Pelvis | Self::Neck | Self::Head, Self::Spine) | (Self::Chest, Self::Neck)
        )
    }

    /// Returns the part in plain words.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Pelvis => "a pelvis",
            Self::Spine => "a spine",
            Self::Chest => "a chest",
            Self::Neck => "a neck",
            Self::Head => "a head",
            Self::Clavicle => "a clavicle",
            Self::Shoulder => "a shoulder",
            Self::Elbow => "an elbow",
            Self::Wrist => "a wrist",
            Self::Hip => "a hip",
            Self::Knee => "a knee",
            Self::Ankle => "an ankle",
            Self::Toe => "a toe",
        }
    }
}

/// Kind of joint that a name means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A joint of the body, or an unknown name.
    Body,
    /// A joint of a finger.
    Finger,
    /// A part of the face: eye, jaw, hair.
    Face,
    /// A joint that rotates a bone about its own axis.
    Twist,
    /// The end of a bone, not a joint.
    End,
    /// A handle, a prop, clothes.
    Helper,
    /// A part that only animals have.
    Animal,
}

/// Meaning of a name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Name {
    /// Side in the name, or `None`.
    pub side: Option<Side>,
    /// Kind of joint.
    pub kind: Kind,
    /// Parts that the name may mean, each with a probability, 0 to 1.
    pub parts: Vec<(Part, f64)>,
    /// Whether the name contains words for front or hind legs.
    pub quadruped: bool,
    /// Words other than the side: they are equal for mirror partners.
    pub rest: Vec<Word>,
}

impl Name {
    /// Returns the probability that the name means `part`, 0 to 1.
    pub(super) fn says(&self, part: Part) -> f64 {
        self.parts.iter().find(|(other, _)| *other == part).map_or(0.0, |(_, likely)| *likely)
    }

    /// Returns the most probable part; `None` if the name means no part.
    pub(super) fn best(&self) -> Option<Part> {
        self.parts.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(part, _)| *part)
    }

    /// Returns whether the name has no known meaning.
    pub(super) fn is_silent(&self) -> bool {
        self.parts.is_empty() && self.kind == Kind::Body
    }
}

/// Reads the names of a skeleton.
pub(super) fn read_all(names: &[&str]) -> Vec<Name> {
    let mut all: Vec<Vec<Word>> = names.iter().map(|name| words(name)).collect();
    drop_prefix(&mut all);
    // Some exporters add `ctrl` or `leaf` to every name: then the word has no meaning.
    let is_everywhere = |word: Word| {
        let count = all.iter().filter(|words| words.contains(&word)).count();
        matches!(word, Word::Helper | Word::End | Word::Twist | Word::Torso)
            && 10 * count > 6 * all.len()
    };
    let mut everywhere: Vec<Word> = [Word::Helper, Word::End, Word::Twist, Word::Torso]
        .into_iter()
        .filter(|word| is_everywhere(*word))
        .collect();
    // A spine has one base. If several names contain it, as `CC_Base_Spine01` and `CC_Base_Spine02`, it is the name
    // of the file.
    let is_base = |words: &&Vec<Word>| words.contains(&Word::Spine) && words.contains(&Word::Base);
    if all.iter().filter(is_base).count() > 1 {
        everywhere.push(Word::Base);
    }
    let spelled: BTreeSet<&str> = names.iter().copied().collect();
    names
        .iter()
        .zip(&all)
        .map(|(name, words)| {
            let says = |word: &Word| !everywhere.contains(word);
            let mut read = read(&words.iter().copied().filter(says).collect::<Vec<_>>());
            // MakeHuman's `__UpLeg_L` is a helper before `UpLeg_L`.
            let bare = name.trim_start_matches('_');
            if bare != *name && spelled.contains(bare) {
                (read.kind, read.parts) = (Kind::Helper, Vec::new());
            }
            read
        })
        .collect()
}

/// Drops the word at the beginning of nearly all names, as in `CC_Base_L_Thigh`: it is the name of the file.
fn drop_prefix(all: &mut [Vec<Word>]) {
    let Some(prefix) = all
        .iter()
        .filter_map(|words| words.first())
        .copied()
        .max_by_key(|word| all.iter().filter(|words| words.first() == Some(word)).count())
    else {
        return;
    };
    let begins = |words: &Vec<Word>| words.first() == Some(&prefix);
    let count = all.iter().filter(|words| begins(words)).count();
    if count < 5 || 10 * count < 8 * all.len() || matches!(prefix, Word::Left | Word::Right) {
        return;
    }
    for words in all.iter_mut().filter(|words| begins(words)) {
        words.remove(0);
    }
}

/// Derives the meaning of `words`.
fn read(words: &[Word]) -> Name {
    let has = |word| words.contains(&word);
    let side = words.iter().rev().find_map(|word| match word {
        Word::Left => Some(Side::Left),
        Word::Right => Some(Side::Right),
        _ => None,
    });
    let mut rest: Vec<Word> =
        words.iter().copied().filter(|word| !matches!(word, Word::Left | Word::Right)).collect();
    rest.sort_unstable();
    let leg = has(Word::Leg) || has(Word::Thigh);
    let quadruped = leg && [Word::Front, Word::Hind, Word::Fore, Word::Spine].into_iter().any(has);
    let kind = kind(&has, side);
    // A finger or an eye is not a hand or a head, even if its name contains these words.
    let parts = match kind {
        Kind::Body | Kind::Twist | Kind::End => parts(&has, side),
        Kind::Finger | Kind::Face | Kind::Helper | Kind::Animal => Vec::new(),
    };
    Name { side, kind, parts, quadruped, rest }
}

fn kind(has: &impl Fn(Word) -> bool, side: Option<Side>) -> Kind {
    let trunk_or_limb = [
        Word::Spine,
        Word::Torso,
        Word::Chest,
        Word::Foot,
        Word::Leg,
        Word::Arm,
        Word::Hip,
        Word::Shoulder,
        Word::Neck,
        Word::Hand,
    ];
    let middle_finger = has(Word::Middle) && side.is_some() && !trunk_or_limb.into_iter().any(has);
    let foot = has(Word::Toe) || has(Word::Foot);
    if has(Word::Helper) {
        Kind::Helper
    } else if has(Word::End) {
        Kind::End
    } else if has(Word::Face) {
        Kind::Face
    } else if (has(Word::Finger) && !foot)
        || middle_finger
        || (has(Word::Hand) && has(Word::Middle))
    {
        Kind::Finger
    } else if has(Word::Animal) {
        Kind::Animal
    } else if has(Word::Twist) {
        Kind::Twist
    } else {
        Kind::Body
    }
}

/// Words, whether the joint is on a side, and parts.
type Meaning = (&'static [Word], Option<bool>, &'static [(Part, f64)]);

/// Meanings of word combinations; the first row that fits is used. A row contains the words, whether the joint is
/// on a side (if it matters), and the parts that they may mean, with relative weights: how often makers of files use
/// the words in this meaning.
const MEANINGS: &[Meaning] = {
    use Part::{
        Ankle, Chest, Clavicle, Elbow, Head, Hip, Knee, Neck, Pelvis, Shoulder, Spine, Toe, Wrist,
    };
    &[
        (&[Word::Toe], None, &[(Toe, 1.0)]),
        (&[Word::Metatarsal], None, &[(Toe, 0.6)]),
        (&[Word::Ankle], None, &[(Ankle, 1.0)]),
        (&[Word::Foot, Word::Middle], None, &[(Toe, 0.7)]),
        (&[Word::Foot, Word::Finger], None, &[(Toe, 0.7)]),
        // A foot begins at the ankle, but in a file with an ankle it is the ball of the foot.
        (&[Word::Foot], None, &[(Ankle, 0.8), (Toe, 0.4)]),
        (&[Word::Knee], None, &[(Knee, 1.0)]),
        (&[Word::Shank], None, &[(Knee, 1.0)]),
        (&[Word::Thigh], None, &[(Hip, 1.0)]),
        (&[Word::Leg, Word::Upper], None, &[(Hip, 1.0)]),
        (&[Word::Leg, Word::Lower], None, &[(Knee, 1.0)]),
        (&[Word::Leg], None, &[(Knee, 0.8), (Hip, 0.5)]),
        (&[Word::Buttock], None, &[(Hip, 0.3)]),
        (&[Word::Hip], Some(true), &[(Hip, 0.8)]),
        (&[Word::Hip], None, &[(Pelvis, 1.0)]),
        (&[Word::Elbow], None, &[(Elbow, 1.0)]),
        (&[Word::Wrist], None, &[(Wrist, 1.0)]),
        (&[Word::LowerArm], None, &[(Elbow, 1.0)]),
        (&[Word::UpperArm], None, &[(Shoulder, 1.0)]),
        (&[Word::Arm, Word::Upper], None, &[(Shoulder, 1.0)]),
        (&[Word::Arm, Word::Lower], None, &[(Elbow, 1.0)]),
        (&[Word::Arm, Word::Fore], None, &[(Elbow, 1.0)]),
        (&[Word::Arm], None, &[(Shoulder, 0.9), (Elbow, 0.3)]),
        (&[Word::Clavicle], None, &[(Clavicle, 1.0)]),
        // A shoulder may be the ball joint or the clavicle; Kinect's centre of the shoulders is the chest.
        (&[Word::Shoulder], Some(true), &[(Shoulder, 0.6), (Clavicle, 0.6)]),
        (&[Word::Shoulder], None, &[(Chest, 0.8)]),
        (&[Word::Hand], None, &[(Wrist, 0.8)]),
        (&[Word::Palm], None, &[(Wrist, 0.4)]),
        (&[Word::Head], None, &[(Head, 1.0)]),
        (&[Word::Neck], None, &[(Neck, 1.0)]),
        (&[Word::Chest], None, &[(Chest, 1.0), (Spine, 0.8)]),
        (&[Word::Pelvis], None, &[(Pelvis, 1.0)]),
        (&[Word::Torso, Word::Lower], None, &[(Pelvis, 0.9)]),
        (&[Word::Torso], None, &[(Spine, 0.8), (Chest, 0.8), (Pelvis, 0.4)]),
        (&[Word::Spine, Word::Base], None, &[(Pelvis, 0.9)]),
        (&[Word::Spine], None, &[(Spine, 1.0), (Chest, 0.7)]),
        (&[Word::Root], None, &[(Pelvis, 0.5)]),
    ]
};

/// Returns the parts that the words may mean.
fn parts(has: &impl Fn(Word) -> bool, side: Option<Side>) -> Vec<(Part, f64)> {
    let fits = |(words, sided, _): &&Meaning| {
        words.iter().all(|word| has(*word)) && sided.is_none_or(|sided| sided == side.is_some())
    };
    MEANINGS.iter().find(fits).map_or_else(Vec::new, |(.., parts)| parts.to_vec())
}
