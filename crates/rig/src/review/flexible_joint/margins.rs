//! How much a loop bears before it swings by itself.

use std::f64::consts::PI;

use serde::Serialize;

use super::complex::Complex;
use super::control::{ControlLoop, OpenLoop};
use super::plant::FlexibleJoint;

/// Frequencies at which the loop is looked at, from [`LEAST_RAD_S`] to half the rate: 2 to 3 % apart.
const FREQUENCIES: usize = 300;
/// No loop of a joint crosses below this.
const LEAST_RAD_S: f64 = 0.3;
/// Halvings of an interval between two frequencies, or of a delay.
const HALVINGS: usize = 24;

/// Margins of a stable loop, each by itself. Frequencies are those at which it would swing then.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margins {
    /// Phase either way, deg.
    pub phase_deg: f64,
    /// Factor on the torque, upwards; none if it bears any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
    /// Factor on the torque, downwards; none if it bears any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain_down: Option<f64>,
    /// Delay, s; none if it bears any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
}

/// Whether a loop is stable, and by how much.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stability {
    /// How the slowest part grows, 1/s: negative if it decays.
    pub growth_per_s: f64,
    /// None if it grows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margins: Option<Margins>,
}

impl Stability {
    /// The lesser of both, number by number.
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
    /// How a swing of a joint under this loop grows, 1/s: by its largest pole. Negative if it decays.
    pub fn growth_per_s(&self, joint: &FlexibleJoint) -> f64 {
        growth_per_s(&OpenLoop::new(joint, self), self)
    }

    /// Whether the loop is stable round a joint, and by how much.
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
                    // Above -180 deg: what phase may still be lost.
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

    /// The delay that the loop bears, from what its phase says: that is of a sine, and torques are held.
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

/// Where a number changes its sign.
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
