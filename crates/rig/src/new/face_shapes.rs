//! Solids of the starting face: a head, a jaw, eyes with pupils, lids and brows on a stand.

use crate::description::BodyShape;

const STAND: [f64; 3] = [0.36, 0.4, 0.45];
const SKIN: [f64; 3] = [0.93, 0.78, 0.65];
const LIDS: [f64; 3] = [0.86, 0.66, 0.53];
const LIPS: [f64; 3] = [0.76, 0.42, 0.38];
const WHITE: [f64; 3] = [0.97, 0.97, 0.95];
const DARK: [f64; 3] = [0.12, 0.13, 0.16];
const HAIR: [f64; 3] = [0.35, 0.24, 0.17];

const LEVEL: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
/// Rotations of a cylinder or a capsule from z to y and to x, by a third of a turn.
const UPRIGHT: [f64; 4] = [-0.5, -0.5, -0.5, 0.5];
const ACROSS: [f64; 4] = [0.5, 0.5, 0.5, 0.5];

/// Returns the solids of a body of the face, by the body's name without its side.
pub(super) fn of(body: &str) -> Vec<BodyShape> {
    match body {
        "stand" => vec![
            BodyShape::cylinder(0.07, 0.016).at([0.0, 0.008, 0.0], UPRIGHT).colored(STAND),
            BodyShape::cylinder(0.014, 0.18).at([0.0, 0.106, 0.0], UPRIGHT).colored(STAND),
        ],
        "neck_turn" => {
            vec![BodyShape::cylinder(0.026, 0.02).at([0.0, 0.005, 0.0], UPRIGHT).colored(STAND)]
        }
        "neck_nod" => {
            vec![BodyShape::capsule(0.014, 0.03).at([0.0, 0.0, 0.0], ACROSS).colored(STAND)]
        }
        "head" => vec![
            BodyShape::capsule(0.062, 0.05).at([0.0, 0.11, -0.008], UPRIGHT).colored(SKIN),
            BodyShape::cylinder(0.024, 0.084).at([0.0, 0.025, -0.012], UPRIGHT).colored(SKIN),
            BodyShape::sphere(0.011).at([0.0, 0.078, 0.06], LEVEL).colored(SKIN),
            BodyShape::sphere(0.014).at([0.064, 0.09, -0.005], LEVEL).colored(SKIN),
            BodyShape::sphere(0.014).at([-0.064, 0.09, -0.005], LEVEL).colored(SKIN),
            BodyShape::capsule(0.004, 0.028).at([0.0, 0.056, 0.051], ACROSS).colored(LIPS),
        ],
        // The jaw's joint is in front of the neck; its chin is further in front.
        "jaw" => vec![
            BodyShape::capsule(0.019, 0.034).at([0.0, -0.008, 0.018], ACROSS).colored(SKIN),
            BodyShape::capsule(0.004, 0.026).at([0.0, 0.008, 0.033], ACROSS).colored(LIPS),
        ],
        "eye_nod" => vec![
            BodyShape::sphere(0.016).colored(WHITE),
            BodyShape::sphere(0.0075).at([0.0, 0.0, 0.0105], LEVEL).colored(DARK),
        ],
        // A lid's lower edge is in front of the eye's middle while its angle is zero.
        "lid_upper" => vec![lid(22.0), lid(52.0)],
        "lid_lower" => vec![lid(-22.0), lid(-52.0)],
        "brow" => {
            vec![BodyShape::capsule(0.0045, 0.024).at([0.0; 3], ACROSS).colored(HAIR)]
        }
        _ => Vec::new(),
    }
}

/// Returns a part of a lid at an angle above the eye's middle.
fn lid(degrees: f64) -> BodyShape {
    let (up, forwards) = degrees.to_radians().sin_cos();
    let place = |share: f64| (0.0145 * share * 1e5).round() / 1e5;
    BodyShape::capsule(0.0055, 0.018).at([0.0, place(up), place(forwards)], ACROSS).colored(LIDS)
}
