//! Candidates for the three joints of a limb, scored by names and lengths.

use super::body::Body;
use super::name::{Kind, Name, Part};
use crate::Side;

/// Maximum number of joints between two joints of a limb.
const BETWEEN_MAX: usize = 5;
/// Number of candidates that are kept for each limb and side.
const KEPT: usize = 24;

/// Kind of a limb.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LimbKind {
    Leg,
    Arm,
}

impl LimbKind {
    /// Returns the parts of the body to which the limb's three joints belong.
    pub(super) fn parts(self) -> [Part; 3] {
        match self {
            Self::Leg => [Part::Hip, Part::Knee, Part::Ankle],
            Self::Arm => [Part::Shoulder, Part::Elbow, Part::Wrist],
        }
    }

    /// Returns the length of the lower bone relative to the upper (Drillis and Contini, in D. A. Winter,
    /// Biomechanics and Motor Control of Human Movement, figure 4.1).
    pub(super) fn lower_by_upper(self) -> f64 {
        match self {
            Self::Leg => 0.246 / 0.245,
            Self::Arm => 0.146 / 0.186,
        }
    }

    /// Returns the length of both bones relative to those of a leg.
    fn by_leg(self) -> f64 {
        match self {
            Self::Leg => 1.0,
            Self::Arm => (0.146 + 0.186) / (0.246 + 0.245),
        }
    }
}

/// A candidate for a limb: a joint at each end and one between them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Limb {
    /// Hip or shoulder; knee or elbow; ankle or wrist.
    pub joints: [usize; 3],
    /// Lengths of the upper and the lower bone.
    pub lengths: [f64; 2],
    /// Side that the joints' names contain, or `None`.
    pub side: Option<Side>,
    /// Support by the names: at most 3, negative if they contradict.
    pub by_name: f64,
    /// Cost of other joints between the limb's three joints.
    pub skipped: f64,
    /// Sum of all evidence.
    pub score: f64,
}

/// Returns the best candidates for a limb, separately for each named side.
pub(super) fn candidates(body: &Body, kind: LimbKind) -> Vec<Limb> {
    let mut limbs = Vec::new();
    for end in 0..body.count() {
        if says(body, end, kind.parts()[2]) < -0.4 {
            continue;
        }
        for middle in body.upwards(end).skip(1).take(BETWEEN_MAX + 1) {
            for upper in body.upwards(middle).skip(1).take(BETWEEN_MAX + 1) {
                limbs.extend(limb(body, kind, [upper, middle, end]));
            }
        }
    }
    let longest = limbs
        .iter()
        .filter(|limb| (0.4..2.5).contains(&(limb.lengths[1] / limb.lengths[0])))
        .map(|limb| limb.lengths[0] + limb.lengths[1])
        .fold(0.0, f64::max);
    for limb in &mut limbs {
        let by_longest = (limb.lengths[0] + limb.lengths[1]) / longest;
        limb.score -= 0.3 * libm::log(by_longest / kind.by_leg()).abs().min(3.0);
    }
    // Among equal candidates, the candidate nearest to the root is preferred, because it carries the others.
    limbs.sort_by(|a, b| b.score.total_cmp(&a.score).then(a.joints.cmp(&b.joints)));
    let mut kept = [0; 3];
    limbs.retain(|limb| {
        let of_side = &mut kept[limb.side.map_or(2, |side| side as usize)];
        *of_side += 1;
        *of_side <= KEPT
    });
    limbs
}

/// Returns the candidate of these joints, unless the names contradict it.
fn limb(body: &Body, kind: LimbKind, joints: [usize; 3]) -> Option<Limb> {
    let [upper, middle, end] = joints;
    let parts = kind.parts();
    let by_joint: Vec<f64> =
        joints.iter().zip(parts).map(|(joint, part)| says(body, *joint, part)).collect();
    let by_name: f64 = by_joint.iter().sum();
    if by_name < -0.9 || body.parent(upper).is_none() && by_name < 1.5 {
        return None;
    }
    let mut side = None;
    for joint in joints {
        match (side, body.names[joint].side) {
            (Some(side), Some(other)) if side != other => return None,
            (None, named) => side = named,
            _ => {}
        }
    }
    let lengths = [body.length(upper, middle), body.length(middle, end)];
    // Several joints at one position, such as NAO's ball joints, are not a limb.
    if lengths.iter().any(|length| body.is_zero(*length)) {
        return None;
    }
    // A helper of no length is not the joint, if another follows on the way.
    let way = body.way(upper, middle);
    let another = way[..way.len() - 1].iter().any(|joint| !body.is_at_parent(*joint));
    if another && body.is_helper(upper) {
        return None;
    }
    let ratio = lengths[1] / lengths[0] / kind.lower_by_upper();
    let skipped: f64 = cost_of_skipped(body, upper, middle, parts[0])
        + cost_of_skipped(body, middle, end, parts[1])
        + joints
            .iter()
            .zip(parts)
            .map(|(joint, part)| cost_of_second(body, *joint, part))
            .sum::<f64>();
    let score = by_name - 0.4 * libm::log(ratio).abs().min(3.0) - skipped;
    Some(Limb { joints, lengths, side, by_name, skipped, score })
}

/// Returns how well the name of `joint` supports `part`: from 1 (the name certainly means this part) over 0 (unknown
/// name) to -1 (a finger or a part of the face).
pub(super) fn says(body: &Body, joint: usize, part: Part) -> f64 {
    let name = &body.names[joint];
    let likely = name.says(part);
    match name.kind {
        Kind::Finger | Kind::Face => -1.0,
        Kind::Helper | Kind::End => -0.6,
        Kind::Twist => 0.5 * likely - 0.3,
        Kind::Animal => -0.5,
        Kind::Body if likely > 0.0 => likely,
        Kind::Body if name.parts.is_empty() => 0.0,
        Kind::Body => -0.8,
    }
}

/// Returns the cost of skipping the joints between two joints of a limb: zero for joints that only rotate the bone.
fn cost_of_skipped(body: &Body, from: usize, to: usize, part: Part) -> f64 {
    let of = |joint: usize| {
        let name = &body.names[joint];
        let turns_only = matches!(name.kind, Kind::Twist | Kind::Helper | Kind::End)
            || body.is_at_parent(joint)
            || is_same(name, part) && name.says(part) <= body.names[from].says(part);
        if turns_only || body.stays_straight[joint] { 0.0 } else { 0.3 }
    };
    let way = body.way(from, to);
    way[..way.len() - 1].iter().map(|joint| of(*joint)).sum()
}

/// Returns whether the name certainly means `part`. If two joints are called shoulder, the first is the clavicle.
fn is_same(name: &Name, part: Part) -> bool {
    name.says(part) > 0.0 && name.says(Part::Clavicle) <= 0.0
}

/// Returns the cost of a joint whose parent has an equally good name: of `upperarm01` and `upperarm02`, the first
/// is intended.
fn cost_of_second(body: &Body, joint: usize, part: Part) -> f64 {
    let likely = body.names[joint].says(part);
    let before = body.parent(joint).filter(|parent| !body.is_helper(*parent));
    let before = before.map_or(0.0, |parent| {
        let name = &body.names[parent];
        if name.kind == Kind::Body && is_same(name, part) { name.says(part) } else { 0.0 }
    });
    if likely > 0.0 && before >= likely { 0.5 } else { 0.0 }
}
