//! Reads tendons of an MJCF that couple joints: as ties and linked limits, or by name in a note.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::super::error::ImportError;
use super::super::note::{NoteKind, Notes, list};
use super::super::tie::Tie;
use super::super::{none, xml};
use super::defaults::MAIN;
use super::joint;
use super::model::Model;
use crate::description::{Description, JointType, LinkedLimit};

/// A sum of joint positions, each with its factor. The length of a fixed tendon has this form.
type Sum<'a> = Vec<(&'a str, f64)>;

const UNTIED: &str =
    "tendons that couple joints: nothing couples them in the rig, until one servo drives them";

/// Returns the joints of a fixed tendon with their factors; `None` for a tendon of another kind.
pub(super) fn fixed<'a>(root: Node<'a, '_>, name: &str) -> Result<Option<Sum<'a>>, ImportError> {
    let Some(tendon) = all(root).find(|node| node.attribute("name") == Some(name)) else {
        return Ok(None);
    };
    if tendon.has_tag_name("fixed") { joints(tendon).map(Some) } else { Ok(None) }
}

fn all<'a, 'd>(root: Node<'a, 'd>) -> impl Iterator<Item = Node<'a, 'd>> {
    xml::children(root, "tendon")
        .flat_map(|section| section.children())
        .filter(|node| node.has_tag_name("fixed") || node.has_tag_name("spatial"))
}

fn joints<'a>(tendon: Node<'a, '_>) -> Result<Sum<'a>, ImportError> {
    let joint =
        |node| Ok((xml::required(node, "joint")?, xml::number(node, "coef")?.unwrap_or(0.0)));
    xml::children(tendon, "joint").map(joint).collect()
}

/// Reads an equality of tendons: `length1 - rest1 = a + b (length2 - rest2)`. Returns a tie if the equality is linear
/// and contains exactly two joints; otherwise adds a note.
pub(super) fn tie<'a, 'd>(
    root: Node<'a, 'd>,
    node: Node<'a, 'd>,
    model: &Model<'a, 'd, '_>,
    description: &Description,
    notes: &mut Notes,
) -> Result<Option<Tie>, ImportError> {
    let first = xml::required(node, "tendon1")?;
    let second = node.attribute("tendon2");
    let factors = xml::numbers(node, "polycoef", 5)?.unwrap_or_else(|| vec![0.0, 1.0]);
    let factor = |place: usize| factors.get(place).copied().unwrap_or(0.0);
    let mut sum: BTreeMap<&str, f64> = BTreeMap::new();
    let mut order = Vec::new();
    let mut is_linear = second.is_none() || (2..5).all(|place| factor(place).abs() <= 0.0);
    let ends = [(Some(first), 1.0), (second, 0.0 - factor(1))];
    for (name, share) in ends.into_iter().filter_map(|(name, share)| Some((name?, share))) {
        let of_tendon = fixed(root, name)?;
        is_linear &= of_tendon.is_some();
        for (joint, factor) in of_tendon.unwrap_or_default() {
            order.push(joint);
            *sum.entry(joint).or_default() += share * factor;
        }
    }
    order.retain(|joint| sum[joint].abs() > 0.0);
    order.dedup();
    let (true, &[leader, follower]) = (is_linear, order.as_slice()) else {
        let names: Vec<&str> = [Some(first), second].into_iter().flatten().collect();
        notes.add_of(NoteKind::LeftOut, UNTIED, told(&names.join(" and "), &order));
        return Ok(None);
    };
    let mut constant = factor(0);
    for joint in [leader, follower] {
        constant += sum[joint] * rest(root, joint, model, description)?;
    }
    Ok(Some(Tie {
        joint: follower.to_owned(),
        of: leader.to_owned(),
        multiplier: 0.0 - sum[leader] / sum[follower],
        offset: constant / sum[follower],
    }))
}

fn rest<'a, 'd>(
    root: Node<'a, 'd>,
    name: &str,
    model: &Model<'a, 'd, '_>,
    description: &Description,
) -> Result<f64, ImportError> {
    let Some(element) = joint::find(root, name, model)? else { return Ok(0.0) };
    let kind = description.joints.iter().find(|joint| joint.name == name);
    joint::reference(&element, kind.map_or(JointType::Fixed, |joint| joint.kind), model)
}

/// Reads the lengths that tendons permit: those of two joints become linked limits. Adds a note on each spatial tendon,
/// and on each other tendon of several joints. Leaves out tendons in an equality, which [`tie`] reads.
pub(super) fn limits<'a, 'd>(
    root: Node<'a, 'd>,
    model: &Model<'a, 'd, '_>,
    description: &mut Description,
    notes: &mut Notes,
) -> Result<(), ImportError> {
    let equal: Vec<&str> = xml::children(root, "equality")
        .flat_map(|section| xml::children(section, "tendon"))
        .flat_map(|node| ["tendon1", "tendon2"].map(|name| node.attribute(name)))
        .flatten()
        .collect();
    for tendon in all(root) {
        let name = tendon.attribute("name").unwrap_or("tendon");
        if equal.contains(&name) {
            continue;
        }
        if tendon.has_tag_name("spatial") {
            notes.add_of(NoteKind::LeftOut, UNTIED, told(name, &[]));
            continue;
        }
        let mut of_tendon = joints(tendon)?;
        of_tendon.retain(|(_, factor)| factor.abs() > 0.0);
        let names: Vec<&str> = of_tendon.iter().map(|(joint, _)| *joint).collect();
        if names.len() < 2 {
            continue;
        }
        let element = model.defaults.element(tendon, &["tendon"], MAIN)?;
        let range = element.range("range", "limited", model.auto_limits)?;
        let range = range.and_then(|range| none::range("the range", range, name, notes));
        let limit = match (range, of_tendon.as_slice()) {
            (Some(range), [one, other]) => linked(description, [*one, *other], range),
            _ => None,
        };
        match limit {
            Some(limit) => {
                description.limits.push(limit);
                let text = "ranges of tendons of two joints: linked limits";
                notes.add_of(NoteKind::Changed, text, told(name, &names));
            }
            None => notes.add_of(NoteKind::LeftOut, UNTIED, told(name, &names)),
        }
    }
    Ok(())
}

/// Returns the limit on the sum of two joints. Both joints must have one dof, and the home pose must be within the
/// limit; otherwise returns `None`.
fn linked(
    description: &Description,
    joints: [(&str, f64); 2],
    [least, most]: [f64; 2],
) -> Option<LinkedLimit> {
    let find = |name: &str| description.joints.iter().find(|joint| joint.name == name);
    let [one, other] = [find(joints[0].0)?, find(joints[1].0)?];
    let has_one_dof = |joint: &crate::description::Joint| {
        matches!(joint.kind, JointType::Revolute | JointType::Prismatic)
    };
    if !has_one_dof(one) || !has_one_dof(other) {
        return None;
    }
    let slides = one.kind == JointType::Prismatic;
    let home = |joint: &crate::description::Joint| joint.home().first().copied().unwrap_or(0.0);
    let sum = joints[0].1 * home(one) + joints[1].1 * home(other);
    if one.name == other.name || sum < least || sum > most {
        return None;
    }
    // If one joint turns and the other slides, the sum is converted to the unit of the first joint.
    let unit = if one.kind == other.kind { 1.0 } else { joints[0].1.abs() };
    let ends = [Some(least / unit), Some(most / unit)];
    let [[least_rad, most_rad], [least_m, most_m]] =
        if slides { [[None; 2], ends] } else { [ends, [None; 2]] };
    Some(LinkedLimit {
        joint: one.name.clone(),
        other: other.name.clone(),
        factor: joints[0].1 / unit,
        other_factor: joints[1].1 / unit,
        least_rad,
        most_rad,
        least_m,
        most_m,
    })
}

fn told(name: &str, joints: &[&str]) -> String {
    if joints.is_empty() { name.to_owned() } else { format!("{name} of {}", list(joints)) }
}
