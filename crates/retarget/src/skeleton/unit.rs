//! Finds the unit of a skeleton's lengths, from its height.

use super::body::Body;
use super::pair::Pair;
use super::trunk::Trunk;

/// Units that occur in files, with their length in metres. For any height, at most one of them gives a usual
/// height.
const UNITS: [(f64, &str); 7] = [
    (1.0, "metres"),
    (0.3048, "feet"),
    (0.1, "decimetres"),
    (0.01, "centimetres"),
    (0.001, "millimetres"),
    (0.0254, "inches"),
    // CMU files: inches divided by 0.45.
    (0.0254 / 0.45, "inches / 0.45, as CMU's files have"),
];
/// Usual heights, from a child of seven years to a tall man; neighbouring units differ by more than 2.1 / 1.2.
const USUAL_M: std::ops::RangeInclusive<f64> = 1.2..=2.1;
/// Possible heights, from a newborn child to the tallest people (the tallest known was 2.72 m). Several units may
/// fit.
pub const BODY_HEIGHT_M: std::ops::RangeInclusive<f64> = 0.5..=2.5;
/// Proportions of the stature (Drillis and Contini, in D. A. Winter, Biomechanics and Motor Control of Human
/// Movement, figure 4.1): thigh and shank, sole to ankle, base of the skull to the top of the head.
pub(super) const LEG: f64 = 0.491;
const ANKLE: f64 = 0.039;
pub(super) const SKULL: f64 = 0.130;
const ARM: f64 = 0.332;

/// Unit of length of a skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Length of one unit in metres; `None` if no unit gives a plausible height, or several units do equally well.
    pub metres_per_unit: Option<f64>,
    /// Height of the standing body, in the skeleton's unit. It is derived from bone lengths, therefore poses do not
    /// matter.
    pub height: f64,
    /// Reason in plain words.
    pub reason: String,
}

impl Unit {
    pub(super) fn guess(
        body: &Body,
        legs: Option<&Pair>,
        arms: Option<&Pair>,
        trunk: &Trunk,
    ) -> Option<Self> {
        let height = height(body, legs, arms, trunk)?;
        let (metres_per_unit, reason) = of_height(height);
        Some(Self { metres_per_unit, height, reason })
    }
}

/// Returns the unit that gives a usual height, otherwise the only unit that gives a possible height, or `None`; and the
/// reason, with the other possible units.
fn of_height(height: f64) -> (Option<f64>, String) {
    let fits = |range: &std::ops::RangeInclusive<f64>| -> Vec<&(f64, &str)> {
        UNITS.iter().filter(|(metres, _)| range.contains(&(metres * height))).collect()
    };
    let told = |(metres, name): &(f64, &str)| {
        format!("in {name} the body is {:.2} m tall", metres * height)
    };
    if let [unit] = fits(&USUAL_M)[..] {
        // In another unit the body could be a doll: the message mentions this, so that a user can see a wrong choice.
        let others = fits(&BODY_HEIGHT_M).into_iter().filter(|other| *other != unit);
        let reason = others.fold(told(unit), |reason, (metres, name)| {
            format!("{reason}, less usual: {:.2} m in {name}", metres * height)
        });
        return (Some(unit.0), reason);
    }
    match &fits(&BODY_HEIGHT_M)[..] {
        [unit] => (Some(unit.0), told(unit)),
        [] => {
            let reason = format!(
                "the body is {height:.4} units tall: {:.3} m in centimetres, {height:.3} m in metres; no usual unit \
                 makes 0.5 to 2.5 m of it. For a height of 1.70 m a unit is {:.6} m",
                0.01 * height,
                1.70 / height
            );
            (None, reason)
        }
        several => {
            let each: Vec<String> = several.iter().map(|unit| told(unit)).collect();
            (None, format!("{}: each can be", each.join(", ")))
        }
    }
}

/// Returns the height of the standing body, in the skeleton's unit. `None` without a pair of legs or arms. A single
/// limb is not sufficient: joints of robot arms have names of bones too.
fn height(body: &Body, legs: Option<&Pair>, arms: Option<&Pair>, trunk: &Trunk) -> Option<f64> {
    let two = |pair: &&Pair| pair.both().count() == 2;
    let (legs, arms) = (legs.filter(two), arms.filter(two));
    match (legs, trunk.pelvis, trunk.head) {
        (Some(legs), Some(pelvis), Some(head)) => {
            let ancestor = body.common_ancestor(pelvis, head);
            let to_head = body.length(ancestor, head);
            let head = head_length(body, head);
            let shown = 1.0 - ANKLE - if head.is_some() { 0.0 } else { SKULL };
            Some((legs.length() + to_head + head.unwrap_or(0.0)) / shown)
        }
        (Some(legs), ..) => Some(legs.length() / LEG),
        _ => arms.map(|arms| arms.length() / ARM),
    }
}

/// Returns the length from the head's joint to the end of the head, if this end is in the file.
fn head_length(body: &Body, head: usize) -> Option<f64> {
    let ends = body.children[head]
        .iter()
        .filter(|child| body.is_end[**child])
        .map(|child| body.lengths[*child]);
    // Some writers add a stub of one millimetre at the head.
    let long = ends.chain([body.site(head)]).fold(0.0, f64::max);
    (long > 0.02 * body.below[0]).then_some(long)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_height_has_at_most_one_usual_unit() {
        for step in 0..10_000 {
            let height = 0.1 * libm::pow(10.0, f64::from(step) / 2000.0);
            let usual = UNITS.iter().filter(|(metres, _)| USUAL_M.contains(&(metres * height)));
            assert!(usual.count() <= 1, "{height}");
        }
    }

    #[test]
    fn what_no_height_tells_is_left_open() {
        for (height, unit) in [
            (1.7, Some(1.0)),
            (170.0, Some(0.01)),
            (67.0, Some(0.0254)),
            (5.6, Some(0.3048)),
            (0.6, Some(1.0)),
            (45.0, Some(0.0254)),
        ] {
            assert_eq!(of_height(height).0, unit, "{height}");
        }
        let (unit, reason) = of_height(51.0);
        assert_eq!(
            (unit, reason.as_str()),
            (Some(0.0254), "in inches the body is 1.30 m tall, less usual: 0.51 m in centimetres")
        );
        assert_eq!(of_height(170.0).1, "in centimetres the body is 1.70 m tall");
        let (unit, reason) = of_height(40.0);
        assert_eq!(unit, None);
        assert!(
            reason.contains("in inches the body is 1.02 m tall") && reason.contains("each can be"),
            "{reason}"
        );
        let (unit, reason) = of_height(0.07);
        assert!(
            unit.is_none() && reason.contains("no usual unit makes 0.5 to 2.5 m of it"),
            "{reason}"
        );
    }
}
