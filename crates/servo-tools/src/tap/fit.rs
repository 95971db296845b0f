//! Stiffness and damping out of recorded taps, by least squares.

use super::response::{Joint, Response};

/// One tap: where the shaft was, round a step of torque.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tap {
    /// Time since the tap was sent, s, and position in the direction of the tap, rad.
    pub samples: Vec<[f64; 2]>,
    /// When steps of torque were sent, s, and by how much each, as parts of the full torque.
    pub steps: Vec<[f64; 2]>,
}

/// What a fit came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted {
    /// Rotor, load and gear.
    pub joint: Joint,
    /// Standard errors of stiffness and damping, as parts of each.
    pub errors: [f64; 2],
    /// First swing of the shaft beside the way of a rigid gear, counts of the encoder.
    pub ring_counts: f64,
    /// Deviation of readings from the fit, counts.
    pub noise_counts: f64,
}

/// When a step may have come after it was sent, s: the packet, the servo's own tick, and the age of its readings.
const DELAY_S: [f64; 2] = [-2e-3, 6e-3];
/// How far the drag may be from what is believed, as a logarithm.
const DRAG_SPREAD: f64 = 0.05;
/// Factors on what is believed of stiffness and of damping, for a first look.
const COARSE: [f64; 5] = [0.2, 0.45, 1.0, 2.2, 5.0];

/// Fits stiffness, damping and drag. `believed` has the inertias, and what is known of the rest.
pub(super) fn fit(believed: &Joint, taps: &[Tap], count_rad: f64) -> Fitted {
    let cost = |logs: [f64; 3]| {
        let off = logs[2] / DRAG_SPREAD;
        cost(&joint(believed, logs), taps).0 + count_rad * count_rad / 12.0 * off * off
    };
    let mut best = ([0.0; 3], f64::INFINITY);
    for stiffness in COARSE {
        for damping in COARSE {
            let logs = [stiffness.ln(), damping.ln(), 0.0];
            let cost = cost(logs);
            if cost < best.1 {
                best = (logs, cost);
            }
        }
    }
    let logs = nelder_mead(best.0, 0.2, &cost);
    let least = cost(logs);
    let fitted = joint(believed, logs);
    let (_, steps_nm) = self::cost(&fitted, taps);
    let readings: usize = taps.iter().map(|tap| tap.samples.len()).sum();
    let free = (readings as f64 - 4.0 * taps.len() as f64 - 3.0).max(1.0);
    let variance = least / free;
    let tap_part = taps.first().and_then(|tap| tap.steps.last()).map_or(0.0, |step| step[1]);
    let step_nm = tap_part * steps_nm.iter().sum::<f64>() / steps_nm.len().max(1) as f64;
    Fitted {
        joint: fitted,
        errors: errors(logs, least, variance, &cost),
        ring_counts: (step_nm * fitted.ring_rad_nm() / count_rad).abs(),
        noise_counts: variance.sqrt() / count_rad,
    }
}

fn joint(believed: &Joint, [stiffness, damping, drag]: [f64; 3]) -> Joint {
    Joint {
        stiffness_nm_rad: believed.stiffness_nm_rad * stiffness.exp(),
        damping_nm_s: believed.damping_nm_s * damping.exp(),
        drag_nm_s: believed.drag_nm_s * drag.exp(),
        ..*believed
    }
}

/// Returns the sum of squares that is left, and each tap's step, N m.
fn cost(joint: &Joint, taps: &[Tap]) -> (f64, Vec<f64>) {
    let last = |tap: &Tap| tap.samples.last().map_or(0.0, |[time, _]| *time);
    let first = |tap: &Tap| tap.steps.first().map_or(0.0, |[time, _]| *time);
    let until_s =
        taps.iter().map(|tap| last(tap) - first(tap)).fold(0.0, f64::max) - DELAY_S[0];
    let response = joint.response(until_s);
    let mut sum = 0.0;
    let mut steps = Vec::new();
    for tap in taps {
        let (left, step) = best_delay(tap, &response);
        sum += left;
        steps.push(step);
    }
    (sum, steps)
}

/// Fits a tap at the delay that suits it best: in steps of 0.5 ms, then by thirds.
fn best_delay(tap: &Tap, response: &Response) -> (f64, f64) {
    let coarse_s = 5e-4;
    let at = |delay_s| one(tap, response, delay_s);
    let mut best = (f64::INFINITY, 0.0);
    let mut delay_s = DELAY_S[0];
    while delay_s <= DELAY_S[1] {
        let (left, _) = at(delay_s);
        if left < best.0 {
            best = (left, delay_s);
        }
        delay_s += coarse_s;
    }
    let [mut low, mut high] = [best.1 - coarse_s, best.1 + coarse_s];
    for _ in 0..6 {
        let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if at(a).0 < at(b).0 { high = b } else { low = a }
    }
    at(0.5 * (low + high))
}

/// Fits place, speed and step of a tap; what is left, and the step.
fn one(tap: &Tap, response: &Response, delay_s: f64) -> (f64, f64) {
    let mut matrix = [[0.0_f64; 4]; 3];
    let mut square = 0.0;
    let origin = tap.samples.first().map_or(0.0, |[_, position]| *position);
    for [time, position] in &tap.samples {
        let position = position - origin;
        let wound: f64 = tap
            .steps
            .iter()
            .map(|[at, part]| part * response.at(time - at - delay_s))
            .sum();
        // Columns of about one size.
        let row = [1.0, time * 50.0, wound * 1e2];
        for (at, sums) in row.iter().zip(&mut matrix) {
            for (other, sum) in row.iter().chain([&position]).zip(sums.iter_mut()) {
                *sum += at * other;
            }
        }
        square += position * position;
    }
    let right = matrix.map(|row| row[3]);
    let Some(found) = solve(matrix) else { return (f64::INFINITY, 0.0) };
    let explained: f64 = found.iter().zip(right).map(|(x, b)| x * b).sum();
    ((square - explained).max(0.0), found[2] * 1e2)
}

/// Solves equations by elimination; the last column is the right side.
fn solve<const N: usize, const M: usize>(mut matrix: [[f64; M]; N]) -> Option<[f64; N]> {
    for column in 0..N {
        let pivot = matrix[column];
        if pivot[column].abs() < 1e-300 {
            return None;
        }
        for (index, row) in matrix.iter_mut().enumerate() {
            if index != column {
                let factor = row[column] / pivot[column];
                row.iter_mut().zip(pivot).for_each(|(x, y)| *x -= factor * y);
            }
        }
    }
    Some(std::array::from_fn(|at| matrix[at][M - 1] / matrix[at][at]))
}

/// Standard errors of the first two logarithms, by the curvature of the cost.
fn errors(
    at: [f64; 3],
    least: f64,
    variance: f64,
    cost: &impl Fn([f64; 3]) -> f64,
) -> [f64; 2] {
    let h = 0.05;
    let moved = |by: [f64; 3]| cost([at[0] + by[0], at[1] + by[1], at[2] + by[2]]);
    let unit = |axis: usize, by: f64| {
        let mut to = [0.0; 3];
        to[axis] = by;
        to
    };
    let mut curvature = [[0.0; 4]; 3];
    for i in 0..3 {
        for j in 0..3 {
            curvature[i][j] = if i == j {
                (moved(unit(i, h)) - 2.0 * least + moved(unit(i, -h))) / (h * h)
            } else {
                let both = |a: f64, b: f64| {
                    let mut to = unit(i, a);
                    to[j] = b;
                    moved(to)
                };
                (both(h, h) - both(h, -h) - both(-h, h) + both(-h, -h)) / (4.0 * h * h)
            };
        }
    }
    [0, 1].map(|axis| {
        let mut matrix = curvature;
        matrix[axis][3] = 1.0;
        let inverse = solve(matrix).map_or(f64::INFINITY, |column| column[axis]);
        if inverse > 0.0 { (2.0 * variance * inverse).sqrt() } else { f64::INFINITY }
    })
}

/// The least of a function of three numbers: Nelder and Mead.
fn nelder_mead(start: [f64; 3], size: f64, cost: &impl Fn([f64; 3]) -> f64) -> [f64; 3] {
    let mut simplex: Vec<([f64; 3], f64)> = vec![(start, cost(start))];
    for axis in 0..3 {
        let mut to = start;
        to[axis] += size;
        simplex.push((to, cost(to)));
    }
    for _ in 0..120 {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let spread = (0..3)
            .map(|axis| (simplex[3].0[axis] - simplex[0].0[axis]).abs())
            .fold(0.0, f64::max);
        if spread < 1e-3 {
            break;
        }
        let middle: [f64; 3] = std::array::from_fn(|axis| {
            simplex[..3].iter().map(|(to, _)| to[axis]).sum::<f64>() / 3.0
        });
        let worst = simplex[3];
        let along = |by: f64| {
            let to: [f64; 3] =
                std::array::from_fn(|axis| middle[axis] + by * (worst.0[axis] - middle[axis]));
            (to, cost(to))
        };
        let reflected = along(-1.0);
        if reflected.1 < simplex[0].1 {
            let further = along(-2.0);
            simplex[3] = if further.1 < reflected.1 { further } else { reflected };
        } else if reflected.1 < simplex[2].1 {
            simplex[3] = reflected;
        } else {
            let inside = along(if reflected.1 < worst.1 { -0.5 } else { 0.5 });
            if inside.1 < worst.1.min(reflected.1) {
                simplex[3] = inside;
            } else {
                let first = simplex[0].0;
                for vertex in &mut simplex[1..] {
                    let to: [f64; 3] =
                        std::array::from_fn(|axis| 0.5 * (first[axis] + vertex.0[axis]));
                    *vertex = (to, cost(to));
                }
            }
        }
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0].0
}
