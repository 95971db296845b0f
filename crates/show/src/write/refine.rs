//! Finds few knots for a maximum error.

use super::curve::{Curve, Samples, Spans};

/// Maximum error of a group of curves.
#[derive(Debug, Clone, Copy)]
pub(super) enum Bound {
    /// Error of a single curve, rad or m.
    Number(f64),
    /// Error of four curves that are a rotation: its angle, rad.
    Rotation(f64),
}

/// Number of rounds in which spans grow and shrink. Afterwards they only shrink, so that the search ends.
const BALANCING: usize = 30;
const MOST_ROUNDS: usize = 120;
/// Number of rounds without fewer knots, after which the search stops. For a walk and a fight on OP3, Poppy, Open Duck
/// Mini and H1, the result is the same as with all rounds; on an SO-100 it is not.
const PATIENCE: usize = 8;

/// Requirements on the curves of a group.
pub(super) struct Aim<'a> {
    pub(super) bound: Bound,
    /// Step of control values, as a share of the maximum error.
    pub(super) step: f64,
    /// Maximum error of each sample as a share of the bound; empty if the bound applies everywhere.
    pub(super) shares: &'a [f64],
    /// Maximum length of a span, in samples.
    pub(super) longest: i32,
}

/// A curve, its step, and whether it flips.
pub(super) struct Refined {
    pub(super) curve: Curve,
    pub(super) step: f32,
    pub(super) flips: bool,
    /// Knots from the start to the end.
    pub(super) laid: Vec<i32>,
}

struct Candidate {
    curves: Vec<Curve>,
    knots: Vec<Vec<i32>>,
    count: usize,
    round: usize,
}

/// Fits curves to a group of channels within the error bound, or as close as possible. `before`: knots to start from,
/// if there are any; the fit then adds knots where the bound requires them, and removes none.
pub(super) fn refine(group: &[Samples], aim: &Aim<'_>, before: &[Vec<i32>]) -> Vec<Refined> {
    let (largest, of_curve) = match aim.bound {
        Bound::Number(largest) => (largest, largest),
        // For a small angle between two rotations, the distance of their unit quaternions is half of this angle.
        Bound::Rotation(largest) => (largest, largest / 2.0),
    };
    let least_share = aim.shares.iter().copied().fold(1.0, f64::min);
    #[expect(clippy::cast_possible_truncation, reason = "any number near it is as good")]
    let step = (of_curve * least_share * aim.step) as f32;
    let mut spans: Vec<Spans> =
        group.iter().map(|samples| Spans::new(samples, 12.0, aim.longest)).collect();
    spans.iter_mut().zip(before).for_each(|(spans, knots)| spans.begin_with(knots));
    let mut best: Option<Candidate> = None;
    let (mut knots, mut curves, mut errors) = (Vec::new(), Vec::new(), Vec::new());
    // Curves that already fulfil the bound are kept: spans only shrink.
    let first = if before.is_empty() { 0 } else { BALANCING };
    for round in first..MOST_ROUNDS {
        let wanted: Vec<Vec<i32>> =
            group.iter().zip(&spans).map(|(samples, spans)| spans.knots(samples)).collect();
        if wanted != knots {
            knots = wanted;
            let fitted = |(samples, knots): (&Samples, &Vec<i32>)| {
                Curve::new(samples, knots, f64::from(step))
            };
            curves = group.iter().zip(&knots).map(fitted).collect();
            let played: Vec<Vec<f32>> = group
                .iter()
                .zip(&curves)
                .map(|(samples, curve)| curve.played(samples, step))
                .collect();
            errors = shares(group, &played, aim.bound, largest);
            for errors in &mut errors {
                errors.iter_mut().zip(aim.shares).for_each(|(error, share)| *error /= share);
            }
        }
        let count: usize = knots.iter().map(Vec::len).sum();
        let holds = errors.iter().flatten().all(|error| *error <= 1.0);
        if holds && best.as_ref().is_none_or(|best| count < best.count) {
            best = Some(Candidate { curves: curves.clone(), knots: knots.clone(), count, round });
        }
        if best.as_ref().is_some_and(|best| round >= BALANCING || round > best.round + PATIENCE) {
            break;
        }
        for (((spans, knots), errors), samples) in
            spans.iter_mut().zip(&knots).zip(&errors).zip(group)
        {
            balance(&mut spans.wanted, knots, errors, samples.is_loop, round);
        }
    }
    let (curves, knots) = best.map_or((curves, knots), |best| (best.curves, best.knots));
    let refined = |((curve, laid), samples): ((Curve, Vec<i32>), &Samples)| Refined {
        curve,
        step,
        flips: samples.flips,
        laid,
    };
    curves.into_iter().zip(knots).zip(group).map(refined).collect()
}

/// Shortens spans where the error is too large, and lengthens them where it is small. The error of a cubic grows with
/// the fourth power of its span.
fn balance(wanted: &mut [f64], knots: &[i32], errors: &[f64], is_loop: bool, round: usize) {
    const AIM: f64 = 0.9;
    let spans = knots.len() - 1;
    let at = |knot: i32| (knot.unsigned_abs() as usize).min(errors.len());
    for (index, span) in knots.windows(2).enumerate() {
        let (from, to) = (at(span[0]), at(span[1]));
        let error = errors[from..to].iter().fold(1e-9, |a, b| if *b > a { *b } else { a });
        let len = f64::from(span[1] - span[0]);
        let factor = libm::sqrt(libm::sqrt(AIM / error));
        if round < BALANCING {
            for wanted in &mut wanted[from..to] {
                *wanted = (*wanted * factor.clamp(0.6, 1.25)).clamp(1.0, len * 1.6 + 1.0);
            }
        } else if error > 1.0 {
            // A span of minimum length needs shorter neighbours, finally all of them.
            let beside = usize::from(len <= 2.0).max((round - BALANCING) / 4);
            for wanted in &mut wanted[from..to] {
                *wanted = wanted.min(len - 1.0).max(1.0);
            }
            let beside = beside.min(spans / 2);
            for neighbour in index + spans - beside..=index + spans + beside {
                let is_beyond = neighbour < spans || neighbour >= 2 * spans;
                if is_beyond && !is_loop {
                    continue;
                }
                let neighbour = neighbour % spans;
                for wanted in &mut wanted[at(knots[neighbour])..at(knots[neighbour + 1])] {
                    *wanted = (*wanted * factor.clamp(0.5, 0.9)).max(1.0);
                }
            }
        }
    }
}

/// Returns, for each curve, its part of the error at each sample, as a share of the bound.
fn shares(group: &[Samples], played: &[Vec<f32>], bound: Bound, largest: f64) -> Vec<Vec<f64>> {
    let own = |scale: f64| -> Vec<Vec<f64>> {
        group
            .iter()
            .zip(played)
            .map(|(samples, played)| {
                let pairs = samples.values.iter().zip(played);
                pairs.map(|(wanted, played)| (wanted - f64::from(*played)).abs() / scale).collect()
            })
            .collect()
    };
    match bound {
        Bound::Number(_) => own(largest),
        Bound::Rotation(_) => {
            let mut own = own(largest / 2.0);
            let count = own.first().map_or(0, Vec::len);
            for sample in 0..count {
                let wanted: Vec<f64> = group.iter().map(|samples| samples.values[sample]).collect();
                let played: Vec<f64> =
                    played.iter().map(|played| f64::from(played[sample])).collect();
                let error = angle_between(&played, &wanted) / largest;
                // Each curve contributes, and the largest contributions can be reduced.
                let most = own.iter().fold(0.0, |most: f64, own| most.max(own[sample]));
                for own in &mut own {
                    own[sample] =
                        if most > 0.0 { error * (0.5 + 0.5 * own[sample] / most) } else { error };
                    if own[sample] < error * 0.75 && error > 1.0 {
                        own[sample] = own[sample].min(1.0);
                    }
                }
            }
            own
        }
    }
}

/// Returns the angle between two rotations, rad. The quaternions may have any length.
pub(super) fn angle_between(a: &[f64], b: &[f64]) -> f64 {
    // |a b̄ - 1| is exact for small angles, unlike the cosine.
    let length = |q: &[f64]| libm::sqrt(q.iter().map(|x| x * x).sum());
    let (la, lb) = (length(a), length(b));
    let along: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let sign = if along < 0.0 { -1.0 } else { 1.0 };
    let apart =
        libm::sqrt(a.iter().zip(b).map(|(a, b)| a / la - sign * b / lb).map(|x| x * x).sum());
    4.0 * libm::asin((apart / 2.0).min(1.0))
}
