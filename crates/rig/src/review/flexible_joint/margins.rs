//! Stability margins of a loop.

use std::f64::consts::PI;

use serde::Serialize;

use super::complex::Complex;
use super::control::{ControlLoop, OpenLoop};
use super::plant::FlexibleJoint;

/// Number of frequencies at which the loop is evaluated, from [`LEAST_RAD_S`] to half the control rate: 2 to 3 %
/// apart.
const FREQUENCIES: usize = 300;
/// Lowest frequency, rad/s. No loop of a joint has its crossover below it.
const LEAST_RAD_S: f64 = 0.3;
/// Number of bisection steps, for a frequency or a delay.
const HALVINGS: usize = 24;

/// Margins of a stable loop. Each margin holds if only its own quantity changes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margins {
    /// Phase margin in either direction, deg.
    pub phase_deg: f64,
    /// Largest stable factor on the torque; `None` if no larger factor is unstable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
    /// Smallest stable factor on the torque; `None` if no smaller factor is unstable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain_down: Option<f64>,
    /// Largest stable additional delay, s; `None` if no delay is unstable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
}

/// Whether a loop is stable, with its margins.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stability {
    /// Growth rate of the mode that grows fastest or decays slowest, 1/s; negative if all modes decay.
    pub growth_per_s: f64,
    /// Margins; `None` if the loop is unstable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margins: Option<Margins>,
}

impl Stability {
    /// Returns the worse of both, value by value.
    #[must_use]
    pub fn least(self, other: Self) -> Self {
        let some = |least: fn(f64, f64) -> f64, [a, b]: [Option<f64>; 2]| match (a, b) {
            (Some(a), Some(b)) => Some(least(a, b)),
            (a, b) => a.or(b),
        };
        let margins = self.margins.zip(other.margins).map(|(a, b)| Margins {
            phase_deg: a.phase_deg.min(b.phase_deg),
            gain: some(f64::min, [a.gain, b.gain]),
            gain_down: some(f64::max, [a.gain_down, b.gain_down]),
            delay_s: some(f64::min, [a.delay_s, b.delay_s]),
        });
        Self { growth_per_s: self.growth_per_s.max(other.growth_per_s), margins }
    }
}

impl ControlLoop {
    /// Returns the growth rate of a joint's oscillation under this loop, 1/s, from its largest pole; negative if it
    /// decays.
    pub fn growth_per_s(&self, joint: &FlexibleJoint) -> f64 {
        growth_per_s(&OpenLoop::new(joint, self), self)
    }

    /// Returns whether the loop is stable on a joint, with its margins.
    pub fn stability(&self, joint: &FlexibleJoint) -> Stability {
        let open = OpenLoop::new(joint, self);
        let growth_per_s = growth_per_s(&open, self);
        let margins = (growth_per_s < 0.0).then(|| self.margins(joint, &open));
        Stability { growth_per_s, margins }
    }

    fn margins(&self, joint: &FlexibleJoint, open: &OpenLoop) -> Margins {
        let mut margins = Margins { phase_deg: 180.0, gain: None, gain_down: None, delay_s: None };
        let mut take_gain = |ratio: Complex| {
            let factor = 1.0 / ratio.size();
            let slot = if factor > 1.0 { &mut margins.gain } else { &mut margins.gain_down };
            let nearer = slot.is_none_or(|known| (factor - 1.0).abs() < (known - 1.0).abs());
            if nearer {
                *slot = Some(factor);
            }
        };
        let most = PI;
        let least = (LEAST_RAD_S * self.dt_s).min(0.1);
        let ratio = libm::pow(most / least, 1.0 / (FREQUENCIES - 1) as f64);
        let mut phases: Vec<(f64, f64)> = Vec::new();
        let mut before: Option<(f64, Complex)> = None;
        let mut angle = least;
        for index in 0..FREQUENCIES {
            if index + 1 == FREQUENCIES {
                angle = most;
            }
            let now = open.response(angle);
            if let Some((angle_before, last)) = before {
                let ends = [angle_before, angle];
                if (last.size() > 1.0) != (now.size() > 1.0) {
                    let at = crossing(ends, |angle| open.response(angle).size() - 1.0);
                    // Phase above -180 deg, which is the phase that may still be lost.
                    let left = PI + open.response(at).angle_rad();
                    phases.push((at, left));
                }
                if (last.im > 0.0) != (now.im > 0.0) && last.re.min(now.re) < 0.0 {
                    let at = crossing(ends, |angle| open.response(angle).im);
                    let there = open.response(at);
                    if there.re < 0.0 {
                        take_gain(there);
                    }
                }
            }
            before = Some((angle, now));
            angle *= ratio;
        }
        let late = phases.iter().map(|(at, left)| left / at).fold(f64::INFINITY, f64::min);
        for (_, left) in &phases {
            margins.phase_deg = margins.phase_deg.min(left.min(2.0 * PI - left).to_degrees());
        }
        margins.delay_s = late.is_finite().then(|| self.delay_s(joint, late * self.dt_s));
        margins
    }

    /// Refines the delay margin that follows from the phase margin. The phase margin assumes sines, but torques are
    /// held constant for a tick.
    fn delay_s(&self, joint: &FlexibleJoint, by_phase_s: f64) -> f64 {
        let late = |late_s: f64| {
            let late = Self { late_s: self.late_s + late_s, ..*self };
            late.growth_per_s(joint)
        };
        let ends = [0.7 * by_phase_s, 1.4 * by_phase_s];
        if late(ends[0]) < 0.0 && late(ends[1]) > 0.0 { crossing(ends, late) } else { by_phase_s }
    }
}

fn growth_per_s(open: &OpenLoop, control: &ControlLoop) -> f64 {
    libm::log(open.closed(1.0).spectral_radius()) / control.dt_s
}

/// Finds the place where a function changes its sign.
fn crossing([mut low, mut high]: [f64; 2], of: impl Fn(f64) -> f64) -> f64 {
    let low_is_positive = of(low) > 0.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if (of(middle) > 0.0) == low_is_positive {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
