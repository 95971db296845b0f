//! Confidence of each landmark, with the reason why it is not higher.

use std::collections::BTreeMap;

use super::body::Body;
use super::directions::Stance;
use super::found::Found;
use super::limb::{Limb, LimbKind};
use super::name::{Kind, Part};
use super::pair::Pair;
use super::trunk::{Trunk, toe};
use crate::{Landmark, Side};

/// Maximum confidence of an animal's landmarks.
const QUADRUPED_MAX: f64 = 0.4;
/// Minimum cosine between a human's trunk and legs, which is reached in some pose of every clip.
const UPRIGHT: f64 = 0.7;
/// Evidence above this value needs no explanation.
const AGREES: f64 = 0.9;

/// One kind of evidence: its weight, its support for the joint (0 to 1), and the text if the support is low.
type Evidence = (f64, f64, String);

/// Weighs the evidence for each landmark.
pub(super) struct Judge<'a> {
    body: &'a Body<'a>,
    legs: &'a Result<Pair, String>,
    arms: &'a Result<Pair, String>,
    trunk: &'a Trunk,
    stance: &'a Stance,
    quadruped: Option<String>,
}

impl<'a> Judge<'a> {
    pub(super) fn new(
        body: &'a Body<'a>,
        legs: &'a Result<Pair, String>,
        arms: &'a Result<Pair, String>,
        trunk: &'a Trunk,
        stance: &'a Stance,
    ) -> Self {
        let stands = stance.directions.is_some_and(|at| at.upright > UPRIGHT);
        let speaks = |joint: &usize| {
            let name = &body.names[*joint];
            // Costumes have tails and wings too, on a body that stands.
            name.quadruped || name.kind == Kind::Animal && !stands
        };
        let quadruped = match (0..body.count()).find(speaks) {
            Some(joint) => Some(format!("the name `{}` speaks of an animal", body.name(joint))),
            None => stance.on_all_fours.then(|| {
                "the trunk lies level over arms and legs: an animal, or a human on all fours"
                    .to_owned()
            }),
        };
        Self { body, legs, arms, trunk, stance, quadruped }
    }

    /// Returns the landmarks that were found, and for each other landmark the reason why it was not.
    pub(super) fn landmarks(&self) -> (BTreeMap<Landmark, Found>, BTreeMap<Landmark, String>) {
        let (mut found, mut missing) = (BTreeMap::new(), BTreeMap::new());
        for landmark in Landmark::ALL {
            match self.landmark(landmark) {
                Ok(one) => drop(found.insert(landmark, one)),
                Err(reason) => drop(missing.insert(landmark, reason)),
            }
        }
        (found, missing)
    }

    /// Returns findings about the skeleton as a whole.
    pub(super) fn findings(&self) -> Vec<String> {
        let mut findings: Vec<String> = self.quadruped.iter().cloned().collect();
        if self.sides_contradict() {
            findings.push(
                "left and right in the names are on the wrong sides, by the toes and knees: the file is mirrored, or \
                 left-handed"
                    .to_owned(),
            );
        }
        findings
    }

    fn landmark(&self, landmark: Landmark) -> Result<Found, String> {
        match landmark {
            Landmark::Pelvis => {
                self.trunk_joint(self.trunk.pelvis, Part::Pelvis, self.legs, "hips")
            }
            Landmark::Chest => {
                self.trunk_joint(self.trunk.chest, Part::Chest, self.arms, "shoulders")
            }
            Landmark::Neck => self.head_joint(self.trunk.neck, Part::Neck),
            Landmark::Head => self.head_joint(self.trunk.head, Part::Head),
            Landmark::Shoulder(side) => self.limb_joint(LimbKind::Arm, side, 0),
            Landmark::Elbow(side) => self.limb_joint(LimbKind::Arm, side, 1),
            Landmark::Wrist(side) => self.limb_joint(LimbKind::Arm, side, 2),
            Landmark::Hip(side) => self.limb_joint(LimbKind::Leg, side, 0),
            Landmark::Knee(side) => self.limb_joint(LimbKind::Leg, side, 1),
            Landmark::Ankle(side) => self.limb_joint(LimbKind::Leg, side, 2),
            Landmark::Toe(side) => self.toe(side),
        }
    }

    fn trunk_joint(
        &self,
        joint: Option<usize>,
        part: Part,
        limbs: &Result<Pair, String>,
        carried: &str,
    ) -> Result<Found, String> {
        let joint = joint.ok_or_else(|| match limbs {
            Ok(_) => format!("no joint carries both {carried}"),
            Err(reason) => reason.clone(),
        })?;
        let tree = match limbs {
            Ok(pair) if pair.both().count() == 2 && Some(joint) == pair.carrier(self.body) => {
                (0.5, 1.0, String::new())
            }
            Ok(_) => (
                0.5,
                0.7,
                format!(
                    "the {carried} are attached to another joint, but the names indicate this one"
                ),
            ),
            Err(_) => (0.5, 0.4, format!("only its name shows it; no {carried} were found on it")),
        };
        let both = self.trunk.pelvis == self.trunk.chest;
        let alone =
            (0.3, if both { 0.0 } else { 1.0 }, "one joint carries hips and shoulders".to_owned());
        // The chest is often called spine.
        let name = match self.by_name(joint, part) {
            (weight, value, _) if part == Part::Chest && value > 0.5 => {
                (weight, 1.0, String::new())
            }
            evidence => evidence,
        };
        Ok(self.weigh(joint, &[name, tree, alone]))
    }

    fn head_joint(&self, joint: Option<usize>, part: Part) -> Result<Found, String> {
        let joint = joint.ok_or_else(|| match (part, self.trunk.head) {
            (Part::Neck, Some(head)) => {
                format!(
                    "there is no joint between the chest and the head `{}`",
                    self.body.name(head)
                )
            }
            _ => "no joint continues from the chest between the arms, and none has this name"
                .to_owned(),
        })?;
        let neck_is_head = part == Part::Head && self.body.names[joint].best() == Some(Part::Neck);
        let name = if neck_is_head {
            (
                0.6,
                0.7,
                format!("`{}` is called a neck, but there is no other head", self.body.name(joint)),
            )
        } else {
            self.by_name(joint, part)
        };
        let above = self.trunk.chest.is_some_and(|chest| self.body.hangs_on(joint, chest));
        let tree =
            (0.4, if above { 1.0 } else { 0.3 }, "it is not attached to the chest".to_owned());
        Ok(self.weigh(joint, &[name, tree]))
    }

    fn limb_joint(&self, kind: LimbKind, side: Side, place: usize) -> Result<Found, String> {
        let pair = match kind {
            LimbKind::Leg => self.legs.as_ref().map_err(Clone::clone)?,
            LimbKind::Arm => self.arms.as_ref().map_err(Clone::clone)?,
        };
        let limb = pair.limb(side).ok_or("only the other side has this limb")?;
        let joint = limb.joints[place];
        let name = self.by_name(joint, kind.parts()[place]);
        let mut evidence = vec![
            name,
            self.by_side(joint, side),
            by_tree(limb),
            by_mirror(pair),
            by_lengths(limb, kind),
        ];
        evidence.extend(self.by_place(pair, place));
        Ok(self.weigh(joint, &evidence))
    }

    /// Returns the evidence against a hip or shoulder that is at the same place as that of the other side, or `None`.
    fn by_place(&self, pair: &Pair, place: usize) -> Option<Evidence> {
        let [Some(left), Some(right)] = &pair.limbs else { return None };
        let [left, right] = [left.joints[place], right.joints[place]];
        let rest = self.body.poses.last()?;
        let is_one = self.body.is_zero(rest.at(left).distance(rest.at(right)));
        let [left, right] = [left, right].map(|joint| self.body.name(joint));
        let words = format!("`{left}` and `{right}` are at one place: a bone has no length");
        (place == 0 && is_one).then_some((2.0, 0.0, words))
    }

    fn toe(&self, side: Side) -> Result<Found, String> {
        let pair = self.legs.as_ref().map_err(Clone::clone)?;
        let limb = pair.limb(side).ok_or("only the other side has this limb")?;
        let ankle = limb.joints[2];
        let joint = toe(self.body, ankle).ok_or_else(|| {
            format!("there is no joint beyond the ankle `{}`", self.body.name(ankle))
        })?;
        let partner = pair.limb(side.other()).and_then(|limb| toe(self.body, limb.joints[2]));
        let mirror = (
            0.2,
            if partner.is_some() { 1.0 } else { 0.0 },
            "the other foot has no toe".to_owned(),
        );
        let name = self.by_name(joint, Part::Toe);
        Ok(self.weigh(joint, &[name, self.by_side(joint, side), mirror, by_tree(limb)]))
    }

    fn by_name(&self, joint: usize, part: Part) -> Evidence {
        let (name, spelled) = (&self.body.names[joint], self.body.name(joint));
        let likely = name.says(part);
        if likely >= 0.8 {
            (0.4, 1.0, String::new())
        } else if likely > 0.0 {
            (
                0.4,
                0.5 + 0.5 * likely,
                format!("the name `{spelled}` can mean something else than {}", part.words()),
            )
        } else if let Some(other) = name.best().filter(|other| part.is_near(*other)) {
            (
                0.4,
                0.4,
                format!("the name `{spelled}` says {}, the tree {}", other.words(), part.words()),
            )
        } else if let Some(other) = name.best() {
            // A contradicting name weighs more than a missing one.
            (
                0.8,
                0.0,
                format!("the name `{spelled}` says {}, the tree {}", other.words(), part.words()),
            )
        } else {
            (0.4, 0.0, format!("the name `{spelled}` says nothing of {}", part.words()))
        }
    }

    fn by_side(&self, joint: usize, side: Side) -> Evidence {
        let word = if side == Side::Left { "left" } else { "right" };
        match (self.body.names[joint].side, self.stance.faces) {
            (Some(_), _) if self.sides_contradict() => {
                (0.2, 0.3, format!("the name says {word}, toes and knees say the other side"))
            }
            (Some(_), _) => (0.15, 1.0, String::new()),
            (None, Some(_)) => {
                (0.15, 0.7, format!("no name says {word}: so by where toes and knees point"))
            }
            (None, None) => {
                (0.3, 0.0, "neither names nor feet distinguish left from right".to_owned())
            }
        }
    }

    fn sides_contradict(&self) -> bool {
        let sided = self.legs.iter().chain(self.arms).any(|pair| pair.sided);
        sided && self.stance.faces.is_some_and(|faces| faces < -0.3)
    }

    /// Returns the weighted mean of the evidence, with the text of the weakest.
    fn weigh(&self, joint: usize, evidence: &[Evidence]) -> Found {
        let sum: f64 = evidence.iter().map(|(weight, value, _)| weight * value).sum();
        let weight: f64 = evidence.iter().map(|(weight, ..)| weight).sum();
        let weakest =
            evidence.iter().min_by(|a, b| a.1.total_cmp(&b.1)).filter(|weakest| weakest.1 < AGREES);
        let reason = weakest.map_or_else(
            || "names, tree and lengths agree".to_owned(),
            |(.., words)| words.clone(),
        );
        let confidence = sum / weight;
        match &self.quadruped {
            Some(why) => {
                Found { joint, confidence: confidence.min(QUADRUPED_MAX), reason: why.clone() }
            }
            None => Found { joint, confidence, reason },
        }
    }
}

fn by_tree(limb: &Limb) -> Evidence {
    (
        0.15,
        1.0 - limb.skipped.min(1.0),
        "joints without a known name are within the limb".to_owned(),
    )
}

fn by_mirror(pair: &Pair) -> Evidence {
    let words = if pair.both().count() == 2 {
        "the limbs of both sides differ in length"
    } else {
        "the other side has no such limb"
    };
    (0.2, 1.0 - pair.asymmetry, words.to_owned())
}

fn by_lengths(limb: &Limb, kind: LimbKind) -> Evidence {
    let ratio = limb.lengths[1] / limb.lengths[0];
    let off = libm::log(ratio / kind.lower_by_upper()).abs();
    // A deviation of a third occurs in people and drawn figures.
    let value = (1.3 - off).clamp(0.0, 1.0);
    (
        0.1,
        value,
        format!(
            "the lower bone is {ratio:.2} times as long as the upper, a human's {:.2}",
            kind.lower_by_upper()
        ),
    )
}
