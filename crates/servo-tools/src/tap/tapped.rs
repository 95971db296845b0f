//! The outcome of a tap test, and the check whether it is a valid result.

use std::fmt;

use super::act::Recorded;
use super::fit::{Fitted, fit, refit};
use super::plan::Plan;
use super::{Joint, PARTS, Tap};

/// Minimum first swing that can be measured, counts of the encoder.
const LEAST_COUNTS: f64 = 0.2;
/// Maximum damping ratio: above it there is no oscillation to measure.
const MOST_DAMPING_RATIO: f64 = 0.8;
/// Maximum relative standard error of a valid result.
const MOST_ERROR: f64 = 0.08;
/// Minimum number of readings in a period of the oscillation.
const LEAST_READINGS: f64 = 4.0;
/// Maximum deviation of the readings from the model, counts. An error of a millisecond in the times causes a smaller
/// deviation.
const MOST_NOISE_COUNTS: f64 = 1.0;
/// Allowed range of the motor's torque, relative to the torque of its kind.
const TORQUE_RATIOS: [f64; 2] = [0.75, 1.3];

/// The outcome of a tap test.
#[derive(Debug, Clone, PartialEq)]
pub struct Tapped {
    /// Stiffness and damping, fitted to all taps.
    pub fitted: Fitted,
    /// Relative standard errors of stiffness and damping: from the readings, or from the differences between
    /// [`Self::parts`] if those are larger.
    pub errors: [f64; 2],
    /// Separate fits of the [`PARTS`] groups of taps.
    pub parts: Vec<Fitted>,
    /// Number of taps.
    pub taps: usize,
    /// Mean time between readings, s.
    pub reading_s: f64,
    /// Maximum distance from the start position, rad.
    pub farthest_rad: f64,
    /// Stall torque that the motor should have according to its kind, N m.
    pub believed_full_nm: f64,
}

impl Tapped {
    pub(super) fn of(plan: &Plan, recorded: &Recorded, count_rad: f64) -> Self {
        let (fitted, taps) = while_it_pushes(plan, &recorded.taps, count_rad);
        // The groups are sorted by the rest time of the teeth: teeth that still bounced at the step would make the
        // groups differ.
        let mut by_rest = taps.clone();
        by_rest.sort_by(|a, b| a.meet_s.total_cmp(&b.meet_s));
        let parts: Vec<Fitted> = by_rest
            .chunks(taps.len().div_ceil(PARTS).max(1))
            .map(|own| refit(&plan.joint, &fitted, own, count_rad))
            .collect();
        let logs = |of: fn(&Joint) -> f64| parts.iter().map(|part| of(&part.joint).ln()).collect();
        let spreads: [Vec<f64>; 2] =
            [logs(|joint| joint.stiffness_nm_rad), logs(|joint| joint.damping_nm_s)];
        let [mut gaps, mut time_s] = [0.0; 2];
        for tap in &taps {
            gaps += tap.samples.len().saturating_sub(1) as f64;
            let ends = tap.samples.first().zip(tap.samples.last());
            time_s += ends.map_or(0.0, |(first, last)| last[0] - first[0]);
        }
        let [stiffness, damping] = fitted.errors;
        Self {
            errors: [
                stiffness.max(error_of_mean(&spreads[0])),
                damping.max(error_of_mean(&spreads[1])),
            ],
            fitted,
            parts,
            taps: taps.len(),
            reading_s: time_s / gaps.max(1.0),
            farthest_rad: recorded.farthest_rad,
            believed_full_nm: plan.full_nm,
        }
    }

    /// Returns the minimum and maximum of a value over the groups.
    pub fn ends(&self, of: fn(&Joint) -> f64) -> [f64; 2] {
        let all = || self.parts.iter().map(|part| of(&part.joint));
        [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Checks the result. Returns an explanation if the oscillation does not determine stiffness and damping.
    pub(super) fn check(&self) -> Result<(), String> {
        let Fitted { joint, ring_counts, noise_counts, full_nm, .. } = self.fitted;
        let period_s = joint.period_s();
        let ratio = joint.damping_ratio();
        let [rotor, load] = [joint.rotor_kg_m2, joint.load_kg_m2];
        if period_s < LEAST_READINGS * self.reading_s {
            return Err(format!(
                "the shaft rings with {:.0} Hz, and is read {:.0} times a second: too seldom. A higher baud rate, a \
                 shorter Return Delay Time (`sinew servo apply`) or an adapter with less latency helps",
                1.0 / period_s,
                1.0 / self.reading_s
            ));
        }
        if ring_counts < LEAST_COUNTS {
            return Err(format!(
                "the shaft rings by {ring_counts:.2} counts of its encoder, and at least {LEAST_COUNTS} are needed. A \
                 load as heavy as its rotor ({rotor:.5} kg m2; it has {load:.5}) rings most; a larger --strength \
                 helps, too"
            ));
        }
        if ratio > MOST_DAMPING_RATIO {
            return Err(format!(
                "the shaft does not ring: its damping is {ratio:.2} of what is critical, and more than \
                 {MOST_DAMPING_RATIO} cannot be distinguished from a soft gear. A heavier load is damped less"
            ));
        }
        if noise_counts > MOST_NOISE_COUNTS {
            return Err(format!(
                "readings are {noise_counts:.1} counts off the model of rotor, gear and load, where the steps of an \
                 encoder make 0.3: the load shakes by itself, or its other joints do; or replies come too irregularly"
            ));
        }
        let worst = self.errors[0].max(self.errors[1]);
        if worst.is_nan() || worst > MOST_ERROR {
            let percent = 100.0 * MOST_ERROR;
            let found = if worst < 1.0 {
                format!("{:.0} %", 100.0 * worst)
            } else {
                "more than 100 %".to_owned()
            };
            return Err(format!(
                "the taps are not precise enough, or disagree: the standard error of stiffness or damping is {found}, \
                 and a result has {percent:.0} % at most. The ring is {ring_counts:.1} counts of the encoder high. \
                 More --taps help, a larger --strength, and a load of several times its rotor's inertia ({rotor:.5} kg \
                 m2; it has {load:.5}) that nothing else shakes"
            ));
        }
        let torque = full_nm / self.believed_full_nm;
        if !(TORQUE_RATIOS[0]..=TORQUE_RATIOS[1]).contains(&torque) {
            return Err(format!(
                "it speeds up as if its motor had {:.0} % of the torque that its kind has: the inertia of its load is \
                 not {load:.5} kg m2, or its supply is not that of its kind. Stiffness would be wrong by about as \
                 much",
                100.0 * torque
            ));
        }
        Ok(())
    }
}

/// Fits the readings made while the gear pushed. This time depends on the fit, so the fit is repeated.
fn while_it_pushes(plan: &Plan, taps: &[Tap], count_rad: f64) -> (Fitted, Vec<Tap>) {
    let longest_s = taps.iter().filter_map(|tap| tap.samples.last()).map(|last| last[0]);
    let longest_s = longest_s.fold(0.0, f64::max);
    let mut contact_s = plan.joint.contact_s(&plan.push(), longest_s);
    loop {
        let within: Vec<Tap> = taps.iter().map(|tap| tap.until(contact_s)).collect();
        let fitted = fit(&plan.joint, plan.full_nm, &within, count_rad);
        let found_s = fitted.joint.contact_s(&plan.push(), longest_s);
        // The time becomes shorter in each round, by at least one step of the curves.
        if found_s >= contact_s {
            return (fitted, within);
        }
        contact_s = found_s;
    }
}

/// Returns the standard error of the mean; NaN for fewer than two numbers.
fn error_of_mean(numbers: &[f64]) -> f64 {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    let squares: f64 = numbers.iter().map(|number| (number - mean) * (number - mean)).sum();
    (squares / (count - 1.0) / count).sqrt()
}

/// Describes the oscillation and the quality of the readings.
impl fmt::Display for Tapped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Fitted { joint, ring_counts, noise_counts, .. } = self.fitted;
        write!(
            f,
            "it rings with {:.1} Hz, at {:.2} of the critical damping, by {ring_counts:.1} counts of its encoder; \
             readings are {noise_counts:.2} counts off. {} taps, {:.0} readings a second; it moved by {:.0} deg",
            1.0 / joint.period_s(),
            joint.damping_ratio(),
            self.taps,
            1.0 / self.reading_s,
            self.farthest_rad.to_degrees()
        )
    }
}
