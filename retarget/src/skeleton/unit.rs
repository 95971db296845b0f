//! The unit of a skeleton's lengths, by its height.

use super::body::Body;
use super::pair::Pair;
use super::trunk::Trunk;

/// Units that files are in, each with its length in metres. No two of them make one skeleton's height believable.
const UNITS: [(f64, &str); 6] = [
    (1.0, "metres"),
    (0.1, "decimetres"),
    (0.01, "centimetres"),
    (0.001, "millimetres"),
    (0.0254, "inches"),
    // CMU: inches after division by 0.45.
    (0.0254 / 0.45, "inches / 0.45, as CMU's files have"),
];
/// From a child to a tall man.
const BELIEVABLE_M: std::ops::RangeInclusive<f64> = 1.2..=2.1;
/// Parts of the stature (Drillis and Contini, in D. A. Winter, Biomechanics and Motor Control of Human Movement,
/// figure 4.1): thigh and shank, sole to ankle, base of the skull to the vertex.
pub(super) const LEG: f64 = 0.491;
const ANKLE: f64 = 0.039;
pub(super) const SKULL: f64 = 0.130;
const ARM: f64 = 0.332;

/// What unit of length a skeleton is in.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Length of one unit in metres; `None` where no unit makes the height believable.
    pub metres_per_unit: Option<f64>,
    /// Height of the standing body, in the skeleton's unit: from the lengths of its bones, so poses do not matter.
    pub height: f64,
    /// Why, in plain words.
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
        let found = UNITS.iter().find(|(metres, _)| BELIEVABLE_M.contains(&(metres * height)));
        let reason = match found {
            Some((metres, name)) => format!("in {name} the body is {:.2} m tall", metres * height),
            None => format!(
                "the body is {height:.4} units tall: {:.3} m in centimetres, {:.3} m in metres; no usual unit makes \
                 1.2 to 2.1 m of it. For a height of 1.70 m a unit is {:.6} m",
                0.01 * height,
                height,
                1.70 / height
            ),
        };
        Some(Self { metres_per_unit: found.map(|(metres, _)| *metres), height, reason })
    }
}

/// Height of the standing body, in the skeleton's unit.
fn height(body: &Body, legs: Option<&Pair>, arms: Option<&Pair>, trunk: &Trunk) -> Option<f64> {
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

/// From the head's joint to its end, if the file tells it.
fn head_length(body: &Body, head: usize) -> Option<f64> {
    let ends = body.children[head]
        .iter()
        .filter(|child| body.is_end[**child])
        .map(|child| body.lengths[*child]);
    // Some writers put a stub of a millimetre there.
    let long = ends.chain([body.site(head)]).fold(0.0, f64::max);
    (long > 0.02 * body.below[0]).then_some(long)
}
