//! Angles of many rotations at once, in vector instructions, with the bits of `libm::atan2`.

#![expect(clippy::inline_always, reason = "see `sinew_batch::Work::run`")]

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::DQuat;
use sinew_batch::{Work, widest};

/// Number of angles that are computed at once.
const LANES: usize = 8;

/// Writes the angles in [0, π] of rotations to `out`, in rad: `2 atan2(|v|, |w|)` of the quaternion (v, w).
pub fn angles_rad(rotations: &[DQuat], out: &mut Vec<f64>) {
    out.clear();
    out.resize(rotations.len(), 0.0);
    widest(Angles { rotations, out });
}

struct Angles<'a> {
    rotations: &'a [DQuat],
    out: &'a mut [f64],
}

impl Work for Angles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { rotations, out } = self;
        for (rotations, out) in rotations.chunks(LANES).zip(out.chunks_mut(LANES)) {
            let [mut sines, mut cosines] = [[0.0; LANES], [1.0; LANES]];
            for ((sine, cosine), q) in sines.iter_mut().zip(&mut cosines).zip(rotations) {
                (*sine, *cosine) = (q.x * q.x + q.y * q.y + q.z * q.z, q.w.abs());
            }
            let mut angles = [0.0; LANES];
            let mut are_usual = true;
            for ((angle, sine), cosine) in angles.iter_mut().zip(&mut sines).zip(&cosines) {
                *sine = sine.sqrt();
                let ratio = *sine / *cosine;
                *angle = 2.0 * arctangent(ratio);
                // Excludes NaN: of invalid rotations, and of 0 / 0.
                are_usual &= ratio >= 0.0;
            }
            if !are_usual {
                for ((angle, sine), cosine) in angles.iter_mut().zip(&sines).zip(&cosines) {
                    *angle = 2.0 * libm::atan2(*sine, *cosine);
                }
            }
            out.copy_from_slice(&angles[..out.len()]);
        }
    }
}

/// Computes `libm::atan` of a number from 0 to infinity: the same operations, with selections in place of branches.
#[inline(always)]
fn arctangent(x: f64) -> f64 {
    let parts = [
        (x < 2.4375, x - 1.5, 1.0 + 1.5 * x, 0.982_793_723_247_329, 1.390_331_103_123_099_8e-17),
        (x < 1.1875, x - 1.0, x + 1.0, FRAC_PI_4, 3.061_616_997_868_383e-17),
        (x < 0.6875, 2.0 * x - 1.0, 2.0 + x, 0.463_647_609_000_806_1, 2.269_877_745_296_168_7e-17),
        (x < 0.4375, x, 1.0, 0.0, 0.0),
    ];
    // From 2.4375: the arctangent of the reciprocal, subtracted from π/2, which is the sum of these numbers.
    let (mut above, mut below) = (-1.0, x);
    let (mut high, mut low) = (FRAC_PI_2, 6.123_233_995_736_766e-17);
    for (is_part, of_above, of_below, of_high, of_low) in parts {
        // All ones or zero. The compiler would turn a conditional expression into a branch.
        let mask = u64::from(is_part).wrapping_neg();
        let select =
            |part: f64, other: f64| f64::from_bits(part.to_bits() & mask | other.to_bits() & !mask);
        (above, below) = (select(of_above, above), select(of_below, below));
        (high, low) = (select(of_high, high), select(of_low, low));
    }
    let t = above / below;
    let z = t * t;
    let w = z * z;
    let odd = z
        * (0.333_333_333_333_329_3
            + w * (0.142_857_142_725_034_66
                + w * (0.090_908_871_334_365_07
                    + w * (0.066_610_731_373_875_31
                        + w * (0.049_768_779_946_159_324 + w * 0.016_285_820_115_365_782)))));
    let even = w
        * (-0.199_999_999_998_764_83
            + w * (-0.111_111_104_054_623_56
                + w * (-0.076_918_762_050_448_3
                    + w * (-0.058_335_701_337_905_735 + w * -0.036_531_572_744_216_916))));
    high - ((t * (odd + even) - low) - t)
}

#[cfg(test)]
mod tests {
    use sinew_host_util::random::{Random, Subject};

    use super::*;

    fn of_libm(q: DQuat) -> f64 {
        2.0 * libm::atan2(q.xyz().length(), q.w.abs())
    }

    #[test]
    fn angles_have_the_bits_of_libm() {
        let mut random = Random::new(1, Subject::Noise);
        let mut rotations = vec![
            DQuat::IDENTITY,
            -DQuat::IDENTITY,
            DQuat::from_xyzw(0.0, 1.0, 0.0, 0.0),
            DQuat::from_xyzw(1e-200, 0.0, 0.0, -1.0),
            DQuat::from_xyzw(0.6, 0.0, 0.0, 1e-300),
        ];
        // Ratios at the limits of the arctangent's parts.
        for limit in [0.4375_f64, 0.6875, 1.0, 1.1875, 2.4375, 2.0_f64.powi(-27)] {
            rotations.extend(
                [limit.next_down(), limit, limit.next_up()]
                    .map(|ratio| DQuat::from_xyzw(0.0, 0.0, ratio, -1.0)),
            );
        }
        for round in 0..100_000 {
            let v = random.normal3() * 2.0_f64.powi(-(round % 60));
            let w = random.normal3().x * 2.0_f64.powi(-(round % 7) * 10);
            rotations.push(DQuat::from_xyzw(v.x, v.y, v.z, w));
        }
        let mut found = Vec::new();
        angles_rad(&rotations, &mut found);
        assert_eq!(found.len(), rotations.len());
        for (found, q) in found.iter().zip(&rotations) {
            assert_eq!(found.to_bits(), of_libm(*q).to_bits(), "{q}: {found}");
        }
        // A rotation that is none does not change the others.
        for none in
            [DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), DQuat::from_xyzw(f64::NAN, 0.0, 0.0, 1.0)]
        {
            angles_rad(&[rotations[2], none, rotations[9]], &mut found);
            let expected = [rotations[2], none, rotations[9]].map(of_libm);
            assert!(
                found
                    .iter()
                    .zip(expected)
                    .all(|(x, y)| x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan())
            );
        }
    }
}
