//! How far a body is from where it should be.

use glam::DQuat;

use crate::plant::Pose;

/// How far a body is from where it should be, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Off {
    /// Angle of the turn between the two, in [0, π] rad.
    pub angular_rad: f64,
    /// Distance of the two places of its joint, in metres.
    pub linear_m: f64,
}

impl Off {
    /// Those of all bodies: poses in the world.
    pub fn of_all(desired: &[Pose], measured: &[Pose]) -> impl Iterator<Item = Self> {
        desired.iter().zip(measured).map(|(desired, measured)| Self {
            angular_rad: angle_between_rad(desired.rotation, measured.rotation),
            linear_m: (desired.position_m - measured.position_m).length(),
        })
    }
}

/// Angle in [0, π] of the rotation that takes one orientation to the other.
#[inline]
pub(super) fn angle_between_rad(a: DQuat, b: DQuat) -> f64 {
    let turn = a * b.conjugate();
    2.0 * angle_rad(turn.xyz().length(), turn.w.abs())
}

/// The angle in [0, π/2] of a sine and a cosine: `libm::atan2` to the bit, its polynomial for small angles in line.
/// Most errors are small, and a call would wait for one after the other.
#[inline]
fn angle_rad(sine: f64, cosine: f64) -> f64 {
    /// Of the powers of the ratio's square, from the first.
    const SERIES: [f64; 11] = [
        0.333_333_333_333_329_3,
        -0.199_999_999_998_764_83,
        0.142_857_142_725_034_66,
        -0.111_111_104_054_623_56,
        0.090_908_871_334_365_07,
        -0.076_918_762_050_448_3,
        0.066_610_731_373_875_31,
        -0.058_335_701_337_905_735,
        0.049_768_779_946_159_324,
        -0.036_531_572_744_216_916,
        0.016_285_820_115_365_782,
    ];
    let ratio = sine / cosine;
    if ratio < 0.4375 {
        let z = ratio * ratio;
        let w = z * z;
        let [a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10] = SERIES;
        let odd = z * (a0 + w * (a2 + w * (a4 + w * (a6 + w * (a8 + w * a10)))));
        let even = w * (a1 + w * (a3 + w * (a5 + w * (a7 + w * a9))));
        ratio - ratio * (odd + even)
    } else {
        libm::atan2(sine, cosine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_libm_to_the_bit() {
        let same = |sine: f64, cosine: f64| {
            let expected = libm::atan2(sine, cosine);
            assert_eq!(angle_rad(sine, cosine).to_bits(), expected.to_bits(), "{sine} {cosine}");
        };
        for step in 0..200_000 {
            let angle = f64::from(step) * 1e-5;
            same(libm::sin(angle), libm::cos(angle).abs());
            same(libm::exp2(-angle * 600.0), 1.0);
        }
        for [sine, cosine] in [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [7.0, 16.0], [1.0, f64::NAN]] {
            same(sine, cosine);
        }
    }
}
