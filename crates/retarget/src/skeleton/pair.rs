//! Pairs of mirrored limbs: the legs and the arms of a body.

use glam::DVec3;

use super::body::{Body, Pose};
use super::limb::{Limb, LimbKind, candidates};
use crate::Side;

/// Support by names (at most 3) from which a limb is accepted without evidence from the tree.
const NAMED: f64 = 1.5;
/// Number of pairs of legs that are combined with as many pairs of arms.
const TRIED: usize = 40;

/// Two limbs, or only one if the other is missing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pair {
    /// Left and right limb, by their names if these contain sides; otherwise in the file's order.
    pub limbs: [Option<Limb>; 2],
    /// Whether the names contain the sides.
    pub sided: bool,
    /// Difference of the limbs' lengths: 0 is a perfect mirror image, 1 is not a mirror image at all.
    pub asymmetry: f64,
    score: f64,
}

impl Pair {
    /// Returns the limb of a side; `None` if it is missing.
    pub(super) fn limb(&self, side: Side) -> Option<&Limb> {
        self.limbs[side as usize].as_ref()
    }

    /// Returns the limbs that exist.
    pub(super) fn both(&self) -> impl Iterator<Item = &Limb> {
        self.limbs.iter().flatten()
    }

    /// Returns the mean length of both bones of a limb.
    pub(super) fn length(&self) -> f64 {
        let (sum, count) = self.both().fold((0.0, 0.0), |(sum, count), limb| {
            (sum + limb.lengths[0] + limb.lengths[1], count + 1.0)
        });
        sum / f64::max(count, 1.0)
    }

    /// Returns the joint that carries both first joints; for a single limb, its parent.
    pub(super) fn carrier(&self, body: &Body) -> Option<usize> {
        match &self.limbs {
            [Some(left), Some(right)] => {
                Some(body.common_ancestor(left.joints[0], right.joints[0]))
            }
            [Some(limb), None] | [None, Some(limb)] => body.parent(limb.joints[0]),
            [None, None] => None,
        }
    }

    pub(super) fn is_named(&self) -> bool {
        self.both().all(|limb| limb.by_name >= NAMED)
    }
}

/// Finds legs and arms, or the reason why there are none.
pub(super) fn legs_and_arms(body: &Body) -> [Result<Pair, String>; 2] {
    let legs = pairs(body, LimbKind::Leg);
    let arms = pairs(body, LimbKind::Arm);
    let mut best: Option<(f64, &Pair, &Pair)> = None;
    for leg in legs.iter().take(TRIED) {
        for arm in arms.iter().take(TRIED).filter(|arm| are_apart(body, leg, arm)) {
            let score = leg.score + arm.score - cost_together(body, leg, arm);
            if best.is_none_or(|(other, ..)| score > other) {
                best = Some((score, leg, arm));
            }
        }
    }
    if let Some((_, leg, arm)) = best {
        let unnamed = !leg.is_named() && !arm.is_named();
        match not_believed(body, leg, arm) {
            None => return [Ok(leg.clone()), Ok(arm.clone())],
            Some(reason) if unnamed => return [Err(reason.clone()), Err(reason)],
            Some(_) => {}
        }
    }
    let named = |pairs: &[Pair], kind: LimbKind| {
        let pair = pairs.iter().find(|pair| pair.is_named()).cloned();
        pair.or_else(|| single(body, kind)).ok_or_else(|| match kind {
            LimbKind::Leg => {
                "no two limbs that mirror each other look like legs, by name or by length"
                    .to_owned()
            }
            LimbKind::Arm => {
                "no two limbs that mirror each other look like arms, by name or by length"
                    .to_owned()
            }
        })
    };
    [named(&legs, LimbKind::Leg), named(&arms, LimbKind::Arm)]
}

/// Makes the sides of limbs without named sides consistent with those of the other pair: the left arm is above the
/// left leg. A file may list one pair from the left and the other from the right.
pub(super) fn agree_on_sides(body: &Body, legs: &mut Pair, arms: &mut Pair) {
    let aside = |pair: &Pair, pose: &Pose| match &pair.limbs {
        [Some(left), Some(right)] => pose.at(left.joints[0]) - pose.at(right.joints[0]),
        _ => DVec3::ZERO,
    };
    let along: f64 = body.poses.iter().map(|pose| aside(legs, pose).dot(aside(arms, pose))).sum();
    if along < 0.0 {
        match (legs.sided, arms.sided) {
            (true, true) => {}
            (false, true) => legs.limbs.reverse(),
            (_, false) => arms.limbs.reverse(),
        }
    }
}

/// Returns all pairs of limbs of a kind, the best first.
fn pairs(body: &Body, kind: LimbKind) -> Vec<Pair> {
    let limbs = candidates(body, kind);
    let mut pairs = Vec::new();
    for (place, one) in limbs.iter().enumerate() {
        for other in &limbs[place + 1..] {
            pairs.extend(pair(body, one, other));
        }
    }
    pairs.sort_by(|a, b| b.score.total_cmp(&a.score));
    pairs
}

/// Returns the pair of two limbs, if they are separate and not of the same side.
fn pair(body: &Body, one: &Limb, other: &Limb) -> Option<Pair> {
    let swapped = match (one.side, other.side) {
        (Some(one), Some(other)) if one == other => return None,
        (Some(side), _) => side == Side::Right,
        (None, Some(side)) => side == Side::Left,
        (None, None) => one.joints > other.joints,
    };
    let apart = |a: &Limb, b: &Limb| !body.hangs_on(b.joints[0], a.joints[0]);
    if !apart(one, other) || !apart(other, one) {
        return None;
    }
    let carrier = body.common_ancestor(one.joints[0], other.joints[0]);
    let unlike = |a: f64, b: f64| {
        if body.is_zero((a - b).abs()) { 0.0 } else { (libm::log(a / b).abs() / 0.3).min(1.0) }
    };
    let to_carrier = |limb: &Limb| body.length(carrier, limb.joints[0]);
    let asymmetry = (unlike(one.lengths[0], other.lengths[0])
        + unlike(one.lengths[1], other.lengths[1])
        + unlike(to_carrier(one), to_carrier(other)))
        / 3.0;
    let partners = |place: usize| {
        let (a, b) = (&body.names[one.joints[place]], &body.names[other.joints[place]]);
        if a.is_silent() && b.is_silent() {
            0.0
        } else if a.rest == b.rest {
            0.15
        } else {
            -0.15
        }
    };
    let score = one.score + other.score - 1.2 * asymmetry + (0..3).map(partners).sum::<f64>();
    let mut limbs = [Some(one.clone()), Some(other.clone())];
    if swapped {
        limbs.reverse();
    }
    Some(Pair { limbs, sided: one.side.is_some() || other.side.is_some(), asymmetry, score })
}

/// Returns a single limb without partner, if its names are certain.
fn single(body: &Body, kind: LimbKind) -> Option<Pair> {
    let limb = candidates(body, kind).into_iter().find(|limb| limb.by_name >= 2.0)?;
    let score = limb.score;
    let sided = limb.side.is_some();
    let limbs =
        if limb.side == Some(Side::Right) { [None, Some(limb)] } else { [Some(limb), None] };
    Some(Pair { limbs, sided, asymmetry: 1.0, score })
}

fn are_apart(body: &Body, legs: &Pair, arms: &Pair) -> bool {
    legs.both().all(|leg| {
        arms.both().all(|arm| {
            !body.hangs_on(leg.joints[0], arm.joints[0])
                && !body.hangs_on(arm.joints[0], leg.joints[0])
        })
    })
}

/// Returns the cost of combining these legs with these arms.
fn cost_together(body: &Body, legs: &Pair, arms: &Pair) -> f64 {
    let longer_arms = if arms.length() > 1.1 * legs.length() { 0.3 } else { 0.0 };
    let one_carrier = if legs.carrier(body) == arms.carrier(body) { 0.3 } else { 0.0 };
    longer_arms + one_carrier
}

/// Returns why these are not a human's legs and arms, unless the names are certain.
fn not_believed(body: &Body, legs: &Pair, arms: &Pair) -> Option<String> {
    if legs.is_named() && arms.is_named() {
        return None;
    }
    let ratio = arms.length() / legs.length();
    let below = legs
        .carrier(body)
        .zip(arms.carrier(body))
        .map(|(legs, arms)| body.common_ancestor(legs, arms));
    let long = legs.length() / body.below[below.unwrap_or(0)];
    if legs.asymmetry.max(arms.asymmetry) > 0.5 {
        Some("no two pairs of limbs mirror each other".to_owned())
    } else if !(0.45..=1.05).contains(&ratio) {
        Some(format!(
            "the limbs most like arms are {ratio:.2} times as long as those most like legs: a human's are 0.68"
        ))
    } else if long < 0.3 {
        Some(format!(
            "the limbs most like legs are {long:.2} times as long as the skeleton reaches: too short for legs"
        ))
    } else if legs.carrier(body) == arms.carrier(body) {
        Some("all limbs are attached to one joint: no trunk between arms and legs".to_owned())
    } else {
        None
    }
}
