//! What the study knows of a joint by its name: its group, how thick its bones are, and its counterpart in Geno.

use serde::Serialize;

/// Part of the body whose joints are averaged together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// Pelvis and spine up to the thorax.
    Spine,
    /// Neck and head.
    Head,
    /// Shoulders to elbows.
    Arms,
    /// Wrists, fingers, thumbs.
    Hands,
    /// Hips and knees.
    Legs,
    /// Ankles and toes.
    Feet,
}

impl Group {
    /// All groups, as tables list them.
    pub const ALL: [Self; 6] =
        [Self::Spine, Self::Head, Self::Arms, Self::Hands, Self::Legs, Self::Feet];

    /// The group as tables name it.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Spine => "spine",
            Self::Head => "head",
            Self::Arms => "arms",
            Self::Hands => "hands",
            Self::Legs => "legs",
            Self::Feet => "feet",
        }
    }
}

/// A joint by its name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Anatomy {
    pub(super) group: Group,
    /// Radius of the cylinder from the parent to this joint.
    pub(super) radius_m: f64,
    /// Radius of the cylinder from this joint to its end site.
    pub(super) end_radius_m: f64,
    /// The joints of Geno whose importance this one has, as a sum; empty where there is none.
    pub(super) geno: Vec<String>,
}

type Row = (&'static str, Group, f64, f64, &'static [&'static str]);

/// The 31 joints of CMU's skeleton without their sides. Geno has four bones between pelvis and neck where CMU has three:
/// those at the nearest share of the way count. A knuckle of CMU moves four fingers of Geno. Hip joints without a
/// length are the thighs'.
///
/// The radii are estimates. Thigh, clavicle, upper arm, forearm and head have those that the article's list of cylinder
/// weights back-solves to (`tests/oracles/geno_article_radii.csv`, by the joint in which a bone ends). Others depart
/// from it by mistake, not by intent: shank 0.045 for 0.065, foot 0.055 for 0.045, toes 0.045 for 0.055, lower neck 0.06
/// for 0.05, upper neck 0.05 for 0.06, chest to neck 0.12 and to shoulder 0.07 for 0.09, hip 0.1 for 0.09, thumb 0.02
/// for 0.01. The spine's 0.13 is among those of Geno's bones, from 0.09 to 0.14; one finger stands for four of 0.01.
/// The figures of `docs/importance-study.md` are of these radii.
const CMU: [Row; 19] = [
    ("Hips", Group::Spine, 0.0, 0.0, &["Hips"]),
    ("HipJoint", Group::Legs, 0.0, 0.0, &["UpLeg"]),
    ("UpLeg", Group::Legs, 0.1, 0.0, &["UpLeg"]),
    ("Leg", Group::Legs, 0.065, 0.0, &["Leg"]),
    ("Foot", Group::Feet, 0.045, 0.0, &["Foot"]),
    ("ToeBase", Group::Feet, 0.055, 0.045, &["ToeBase"]),
    ("LowerBack", Group::Spine, 0.0, 0.0, &["Spine"]),
    ("Spine", Group::Spine, 0.13, 0.0, &["Spine1"]),
    ("Spine1", Group::Spine, 0.13, 0.0, &["Spine3"]),
    ("Neck", Group::Head, 0.12, 0.0, &["Neck"]),
    ("Neck1", Group::Head, 0.06, 0.0, &["Neck1"]),
    ("Head", Group::Head, 0.05, 0.08, &["Head"]),
    ("Shoulder", Group::Arms, 0.07, 0.0, &["Shoulder"]),
    ("Arm", Group::Arms, 0.07, 0.0, &["Arm"]),
    ("ForeArm", Group::Arms, 0.06, 0.0, &["ForeArm"]),
    ("Hand", Group::Hands, 0.045, 0.0, &["Hand"]),
    (
        "FingerBase",
        Group::Hands,
        0.03,
        0.0,
        &["HandIndex1", "HandMiddle1", "HandRing1", "HandPinky1"],
    ),
    (
        "HandIndex1",
        Group::Hands,
        0.02,
        0.02,
        &["HandIndex2", "HandMiddle2", "HandRing2", "HandPinky2"],
    ),
    ("Thumb", Group::Hands, 0.02, 0.01, &["HandThumb1"]),
];

/// The built-in figure without its sides; it is not compared with Geno.
const FIGURE: [Row; 11] = [
    ("pelvis", Group::Spine, 0.0, 0.0, &[]),
    ("abdomen", Group::Spine, 0.13, 0.0, &[]),
    ("thorax", Group::Spine, 0.13, 0.0, &[]),
    ("head", Group::Head, 0.12, 0.08, &[]),
    ("clavicle", Group::Arms, 0.07, 0.0, &[]),
    ("upper_arm", Group::Arms, 0.07, 0.0, &[]),
    ("forearm", Group::Arms, 0.06, 0.0, &[]),
    ("hand", Group::Hands, 0.045, 0.02, &[]),
    ("thigh", Group::Legs, 0.1, 0.0, &[]),
    ("shank", Group::Legs, 0.065, 0.0, &[]),
    ("foot", Group::Feet, 0.045, 0.055, &[]),
];

impl Anatomy {
    /// The joint called `name`, of CMU's skeleton or the built-in figure.
    pub(super) fn of(name: &str) -> Option<Self> {
        let of_figure = name.strip_suffix("_l").or(name.strip_suffix("_r")).unwrap_or(name);
        if let Some(row) = FIGURE.iter().find(|row| row.0 == of_figure) {
            return Some(Self::from_row(row, ""));
        }
        [("", ""), ("Left", "Left"), ("Right", "Right"), ("L", "Left"), ("R", "Right")]
            .iter()
            .find_map(|(prefix, side)| {
                let unsided = name.strip_prefix(prefix)?;
                let row = CMU.iter().find(|row| row.0 == unsided)?;
                Some(Self::from_row(row, side))
            })
    }

    fn from_row((_, group, radius_m, end_radius_m, geno): &Row, side: &str) -> Self {
        Self {
            group: *group,
            radius_m: *radius_m,
            end_radius_m: *end_radius_m,
            geno: geno.iter().map(|joint| format!("{side}{joint}")).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_are_kept() {
        let hip = Anatomy::of("RHipJoint").unwrap();
        assert_eq!((hip.group, hip.geno), (Group::Legs, vec!["RightUpLeg".to_owned()]));
        assert_eq!(Anatomy::of("LThumb").unwrap().geno, ["LeftHandThumb1"]);
        assert_eq!(Anatomy::of("LeftLeg").unwrap().geno, ["LeftLeg"]);
        assert_eq!(Anatomy::of("LowerBack").unwrap().geno, ["Spine"]);
        assert_eq!(Anatomy::of("shank_l").unwrap().group, Group::Legs);
        assert_eq!(Anatomy::of("Tail"), None);
    }
}
