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
            let mut ratios = [0.0; LANES];
            for lane in 0..LANES {
                sines[lane] = sines[lane].sqrt();
                ratios[lane] = sines[lane] / cosines[lane];
            }
            let mut angles = arctangents(&ratios);
            for angle in &mut angles {
                *angle *= 2.0;
            }
            // Excludes NaN: of invalid rotations, and of 0 / 0.
            if !ratios.iter().all(|ratio| *ratio >= 0.0) {
                for lane in 0..LANES {
                    angles[lane] = 2.0 * libm::atan2(sines[lane], cosines[lane]);
                }
            }
            out.copy_from_slice(&angles[..out.len()]);
        }
    }
}

/// A part of the arctangent's domain, up to a limit: there `atan(x)` is the arctangent of a fraction plus a constant.
struct Part {
    limit: f64,
    /// Numerator and denominator of the fraction: factor of x, and constant.
    above: [f64; 2],
    below: [f64; 2],
    /// Two numbers whose sum is the constant. The second is below the precision of the first.
    sum: [f64; 2],
}

/// The parts of `libm::atan`, from the upper end.
const PARTS: [Part; 4] = [
    Part {
        limit: 2.4375,
        above: [1.0, -1.5],
        below: [1.5, 1.0],
        sum: [0.982_793_723_247_329, 1.390_331_103_123_099_8e-17],
    },
    Part {
        limit: 1.1875,
        above: [1.0, -1.0],
        below: [1.0, 1.0],
        sum: [FRAC_PI_4, 3.061_616_997_868_383e-17],
    },
    Part {
        limit: 0.6875,
        above: [2.0, -1.0],
        below: [1.0, 2.0],
        sum: [0.463_647_609_000_806_1, 2.269_877_745_296_168_7e-17],
    },
    Part { limit: 0.4375, above: [1.0, 0.0], below: [0.0, 1.0], sum: [0.0, 0.0] },
];

/// Computes `libm::atan` of numbers from 0 to infinity: the same operations, with selections in place of branches. The
/// compiler turns only short loops into vector instructions.
#[inline(always)]
fn arctangents(numbers: &[f64; LANES]) -> [f64; LANES] {
    // From 2.4375: the arctangent of the reciprocal, subtracted from π/2, which is the sum of these numbers.
    let (mut above, mut below) = ([-1.0; LANES], *numbers);
    let (mut high, mut low) = ([FRAC_PI_2; LANES], [6.123_233_995_736_766e-17; LANES]);
    for Part { limit, above: [a, b], below: [c, d], sum } in PARTS {
        for lane in 0..LANES {
            let x = numbers[lane];
            // All ones or zero. The compiler would turn a conditional expression into a branch.
            let mask = u64::from(x < limit).wrapping_neg();
            let select = |part: f64, other: f64| {
                f64::from_bits(part.to_bits() & mask | other.to_bits() & !mask)
            };
            above[lane] = select(a * x + b, above[lane]);
            below[lane] = select(c * x + d, below[lane]);
            (high[lane], low[lane]) = (select(sum[0], high[lane]), select(sum[1], low[lane]));
        }
    }
    let mut angles = [0.0; LANES];
    for lane in 0..LANES {
        let t = above[lane] / below[lane];
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
        angles[lane] = high[lane] - ((t * (odd + even) - low[lane]) - t);
    }
    angles
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
