//! Seeded random numbers that are equal on every machine and with every version of the libraries.

use glam::DVec3;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng;

/// A stream of random numbers.
///
/// PCG XSL RR 128/64 is a published algorithm, and the conversions below are written out instead of taken from a
/// library of distributions. An upgrade of a library can thus not change a clip or a result.
#[derive(Debug, Clone)]
pub struct Random(Pcg64);

/// The purpose of a stream. Each purpose has its own stream, so that more draws for one do not change another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// Order, timing and strength of the strikes.
    Script = 1,
    /// Steps between the strikes.
    Footwork = 2,
    /// Sway and breath.
    Sway = 3,
    /// Sensor noise.
    Noise = 4,
    /// Missing samples.
    Gaps = 5,
    /// Errors of a rig's masses.
    Masses = 6,
    /// Lengths of a figure's bones.
    Dimensions = 7,
    /// First parameters of a network.
    Network = 8,
    /// Order of training samples.
    Batches = 9,
    /// Examples that are shown.
    Examples = 10,
    /// Pairs of poses.
    Pairs = 11,
    /// Choice of the recordings that are compared.
    Draws = 12,
    /// Results that chance alone would give.
    Chance = 13,
    /// Targets of a rig's joints in an exercise.
    Exercise = 14,
}

impl Random {
    /// Creates the stream of a seed for one subject.
    pub fn new(seed: u64, subject: Subject) -> Self {
        Self::numbered(seed, 0, subject)
    }

    /// Creates stream `number` of a seed for one subject.
    pub fn numbered(seed: u64, number: u64, subject: Subject) -> Self {
        let state = u128::from(number) << 64 | u128::from(seed);
        Self(Pcg64::new(state, subject as u128))
    }

    /// Returns a number that is uniform in `[0, 1)`, on a grid of 2^-53.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1_u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * STEP
    }

    /// Returns a number that is uniform in `[low, high)`.
    #[inline]
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns a number that is uniform in `0..count`; the bias is below `count / 2^64`.
    pub fn below(&mut self, count: usize) -> usize {
        let wide = u128::from(self.0.next_u64()) * count as u128;
        #[expect(clippy::cast_possible_truncation, reason = "below `count`, which is a usize")]
        let index = (wide >> 64) as usize;
        index
    }

    /// Returns normally distributed components with mean 0 and standard deviation 1 (Box and Muller 1958).
    pub fn normal3(&mut self) -> DVec3 {
        DVec3::new(self.normal(), self.normal(), self.normal())
    }

    fn normal(&mut self) -> f64 {
        // `1 - unit` is in (0, 1]: the logarithm is finite.
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        radius * libm::cos(core::f64::consts::TAU * self.unit())
    }

    /// Shuffles in place (Fisher and Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subjects_of_one_seed_are_different_streams() {
        let mut script = Random::new(1, Subject::Script);
        let mut noise = Random::new(1, Subject::Noise);
        assert!((0..8).any(|_| script.unit().to_bits() != noise.unit().to_bits()));
    }

    #[test]
    fn normal_has_mean_zero_and_variance_one() {
        let mut random = Random::new(7, Subject::Noise);
        let draws: Vec<DVec3> = (0..20_000).map(|_| random.normal3()).collect();
        let count = draws.len() as f64;
        let mean = draws.iter().sum::<DVec3>() / count;
        let variance = draws.iter().map(|draw| draw * draw).sum::<DVec3>() / count;
        // Four standard errors: 4 / sqrt(n) and 4 sqrt(2 / n).
        assert!(mean.abs().max_element() < 0.028, "{mean}");
        assert!((variance - 1.0).abs().max_element() < 0.04, "{variance}");
    }
}
