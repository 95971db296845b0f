//! The elliptical column of the upper trunk cut in three: the thorax between two shoulder parts.
//!
//! The paper's figure needs clavicle bodies, but the paper does not say where it cuts. This module cuts at two
//! sagittal planes half-way between the middle and the sides. A shoulder part then has 19.6 % of the upper trunk's
//! mass (2.3 kg of a man of 73 kg): shoulder blade, collar bone and the muscles about them. The three parts
//! together have the mass, the centre of mass and the inertia of the whole.

use libm::{acos, sin};

/// Position of the cut, as a fraction of the distance from the middle of the trunk to its side.
const CUT: f64 = 0.5;

/// The unit disc cut at [`CUT`] and -[`CUT`]. An ellipse becomes this disc after scaling.
#[derive(Debug, Clone, Copy)]
pub(super) struct CutDisc {
    /// Share of the area in one outer part.
    pub share: f64,
    /// Distance of an outer part's centre of area from the middle.
    pub center: f64,
    /// Mean squares over an outer part of its two coordinates, across the cut and along it.
    pub outer: [f64; 2],
    /// Mean squares over the middle part of its two coordinates, across the cut and along it.
    pub middle: [f64; 2],
}

/// Mean square of either coordinate over the whole disc.
pub(super) const WHOLE: f64 = 0.25;

impl CutDisc {
    pub(super) fn new() -> Self {
        // With x = cos θ all integrals are elementary.
        let angle = acos(CUT);
        let sine = sin(angle);
        let (sine_2, sine_4) = (sin(2.0 * angle), sin(4.0 * angle));
        let area = angle - sine * CUT;
        let center = 2.0 / 3.0 * sine * sine * sine / area;
        let across = (angle / 4.0 - sine_4 / 16.0) / area;
        let along = (2.0 / 3.0) * (3.0 * angle / 8.0 - sine_2 / 4.0 + sine_4 / 32.0) / area;
        let share = area / core::f64::consts::PI;
        let rest = 1.0 - 2.0 * share;
        let middle = [across, along].map(|outer| (WHOLE - 2.0 * share * outer) / rest);
        Self { share, center, outer: [across, along], middle }
    }

    /// Returns the share of the area in the middle part.
    pub(super) fn middle_share(&self) -> f64 {
        1.0 - 2.0 * self.share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The expected values are from numerical quadrature of the disc: area share 0.195501, centre 0.705020.
    #[test]
    fn the_outer_part_is_that_of_quadrature() {
        let disc = CutDisc::new();
        assert!((disc.share - 0.195_501).abs() < 1e-6);
        assert!((disc.center - 0.705_020).abs() < 1e-6);
    }
}
