//! Knowledge about a joint by its name: its group, the radius of its bones, and its counterpart in Geno.

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
    /// All groups, in the order of tables.
    pub const ALL: [Self; 6] =
        [Self::Spine, Self::Head, Self::Arms, Self::Hands, Self::Legs, Self::Feet];

    /// Returns the group's name in tables.
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

/// Properties of a joint.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Anatomy {
    pub(super) group: Group,
    /// Radius of the cylinder from the parent to this joint, m.
    pub(super) radius_m: f64,
    /// Radius of the cylinder from this joint to its end site, m.
    pub(super) end_radius_m: f64,
    /// Joints of Geno whose summed importance is that of this joint; empty if there is no counterpart.
    pub(super) geno: Vec<String>,
}

type Row = (&'static str, Group, f64, f64, &'static [&'static str]);

/// The 31 joints of CMU's skeleton without their sides. The radius of a bone follows from the article's list of
/// cylinder weights, for the bone of Geno that ends in the joint of the same name, except where the skeletons differ:
///
/// - From pelvis to neck Geno has five bones and CMU three of equal length. The lower two have the mean radius of
///   Geno's over the same third of the distance, weighted by length and rounded to 5 mm. The counterpart of a joint
///   is Geno's joint at the nearest share of the distance.
/// - Palm and fingers are one chain. Geno has four chains, each with a radius of 1 cm; with a radius of 4 cm, the
///   single chain has the same surface. Its knuckle corresponds to those of four fingers of Geno.
/// - `HipJoint` and `LowerBack` are at the hips: bones without a length, which need no radius. Everything on a hip
///   joint belongs to the thigh.
const CMU: [Row; 19] = [
    ("Hips", Group::Spine, 0.0, 0.0, &["Hips"]),
    ("HipJoint", Group::Legs, 0.0, 0.0, &["UpLeg"]),
    ("UpLeg", Group::Legs, 0.09, 0.0, &["UpLeg"]),
    ("Leg", Group::Legs, 0.065, 0.0, &["Leg"]),
    ("Foot", Group::Feet, 0.065, 0.0, &["Foot"]),
    ("ToeBase", Group::Feet, 0.045, 0.055, &["ToeBase"]),
    ("LowerBack", Group::Spine, 0.0, 0.0, &["Spine"]),
    ("Spine", Group::Spine, 0.115, 0.0, &["Spine1"]),
    ("Spine1", Group::Spine, 0.12, 0.0, &["Spine3"]),
    ("Neck", Group::Head, 0.09, 0.0, &["Neck"]),
    ("Neck1", Group::Head, 0.05, 0.0, &["Neck1"]),
    ("Head", Group::Head, 0.06, 0.08, &["Head"]),
    ("Shoulder", Group::Arms, 0.09, 0.0, &["Shoulder"]),
    ("Arm", Group::Arms, 0.07, 0.0, &["Arm"]),
    ("ForeArm", Group::Arms, 0.06, 0.0, &["ForeArm"]),
    ("Hand", Group::Hands, 0.045, 0.0, &["Hand"]),
    (
        "FingerBase",
        Group::Hands,
        0.04,
        0.0,
        &["HandIndex1", "HandMiddle1", "HandRing1", "HandPinky1"],
    ),
    (
        "HandIndex1",
        Group::Hands,
        0.04,
        0.04,
        &["HandIndex2", "HandMiddle2", "HandRing2", "HandPinky2"],
    ),
    ("Thumb", Group::Hands, 0.01, 0.01, &["HandThumb1"]),
];

/// The built-in figure without its sides, with similar radii: its neck begins in the thorax, its foot has no toes. It
/// is not compared with Geno.
const FIGURE: [Row; 11] = [
    ("pelvis", Group::Spine, 0.0, 0.0, &[]),
    ("abdomen", Group::Spine, 0.115, 0.0, &[]),
    ("thorax", Group::Spine, 0.12, 0.0, &[]),
    ("head", Group::Head, 0.075, 0.08, &[]),
    ("clavicle", Group::Arms, 0.09, 0.0, &[]),
    ("upper_arm", Group::Arms, 0.07, 0.0, &[]),
    ("forearm", Group::Arms, 0.06, 0.0, &[]),
    ("hand", Group::Hands, 0.045, 0.04, &[]),
    ("thigh", Group::Legs, 0.09, 0.0, &[]),
    ("shank", Group::Legs, 0.065, 0.0, &[]),
    ("foot", Group::Feet, 0.065, 0.05, &[]),
];

impl Anatomy {
    /// Returns the joint with a name, of CMU's skeleton or the built-in figure.
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
    use std::collections::BTreeMap;
    use std::path::Path;

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

    #[test]
    fn bones_are_as_thick_as_those_of_geno_that_end_in_the_same_joint() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../tests/oracles/geno_article_radii.csv");
        let mut reader = csv::Reader::from_path(file).unwrap();
        let geno: BTreeMap<String, f64> = reader.deserialize().collect::<Result<_, _>>().unwrap();
        let fingers = 4.0 * geno["RightHandIndex1"];
        let others = [("Spine", 0.115), ("Spine1", 0.12), ("HandIndex1", fingers), ("Thumb", 0.01)];
        for (name, _, radius_m, end_radius_m, _) in CMU {
            let of_geno = |suffix: &str| {
                let of = |side: &str| geno.get(&format!("{side}{name}{suffix}"));
                of("").or(of("Right")).copied()
            };
            let other = others.iter().find(|other| other.0 == name).map(|other| other.1);
            let palm = (name == "FingerBase").then_some(fingers);
            let expected = other.or(of_geno("")).or(palm).unwrap_or(0.0);
            let end = of_geno("End").or(other.filter(|_| !name.starts_with("Spine")));
            let found = [radius_m, end_radius_m];
            for (found, expected) in found.into_iter().zip([expected, end.unwrap_or(0.0)]) {
                assert!((found - expected).abs() < 1e-12, "{name}: {found} {expected}");
            }
        }
    }
}
