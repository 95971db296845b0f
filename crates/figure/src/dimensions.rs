//! Scale factors for figures whose dimensions differ from the clip's.

use serde::{Deserialize, Serialize};
use sinew_host_util::random::{Random, Subject};

use super::body::{BODIES, Body};

/// Factors on the figure's dimensions. The clip keeps its own dimensions. Factors multiply: the length of a left
/// arm is multiplied by `scale · left_arm` and by a random factor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Dimensions {
    /// Factor of all bodies.
    pub scale: f64,
    /// Factor of pelvis, abdomen, thorax and the shoulder parts.
    pub trunk: f64,
    /// Factor of the head.
    pub head: f64,
    /// Factor of upper arm, forearm and hand of the left side.
    pub left_arm: f64,
    /// Factor of upper arm, forearm and hand of the right side.
    pub right_arm: f64,
    /// Factor of thigh, shank and foot of the left side.
    pub left_leg: f64,
    /// Factor of thigh, shank and foot of the right side.
    pub right_leg: f64,
    /// Half-width of each body's random factor, which is uniform in `1 ± random`. At least 0 and below 1.
    pub random: f64,
    /// Seed of the random factors.
    pub seed: u64,
}

impl Default for Dimensions {
    fn default() -> Self {
        Self {
            scale: 1.0,
            trunk: 1.0,
            head: 1.0,
            left_arm: 1.0,
            right_arm: 1.0,
            left_leg: 1.0,
            right_leg: 1.0,
            random: 0.0,
            seed: 0,
        }
    }
}

impl Dimensions {
    /// Smallest and largest sensible factor.
    pub const RANGE: core::ops::RangeInclusive<f64> = 0.1..=10.0;

    /// Returns factors that scale all of the clip's dimensions by `scale`.
    pub fn uniform(scale: f64) -> Self {
        Self { scale, ..Self::default() }
    }

    /// Returns the factor on each body.
    pub fn factors(&self) -> Vec<f64> {
        let mut random = Random::new(self.seed, Subject::Dimensions);
        let factor = |body: &Body| {
            let part = match body.name {
                "pelvis" | "abdomen" | "thorax" | "clavicle_l" | "clavicle_r" => self.trunk,
                "head" => self.head,
                "upper_arm_l" | "forearm_l" | "hand_l" => self.left_arm,
                "upper_arm_r" | "forearm_r" | "hand_r" => self.right_arm,
                "thigh_l" | "shank_l" | "foot_l" => self.left_leg,
                _ => self.right_leg,
            };
            self.scale * part * random.between(1.0 - self.random, 1.0 + self.random)
        };
        BODIES.iter().map(factor).collect()
    }

    /// Returns the first invalid value, as (key, expected range, value); `None` if all values are valid.
    pub fn fault(&self) -> Option<(&'static str, &'static str, f64)> {
        let factors = [
            ("scale", self.scale),
            ("trunk", self.trunk),
            ("head", self.head),
            ("left_arm", self.left_arm),
            ("right_arm", self.right_arm),
            ("left_leg", self.left_leg),
            ("right_leg", self.right_leg),
        ];
        factors
            .into_iter()
            .find(|(_, factor)| !Self::RANGE.contains(factor))
            .map(|(key, factor)| (key, "a factor from 0.1 to 10", factor))
            .or_else(|| {
                (!(0.0..1.0).contains(&self.random)).then_some((
                    "random",
                    "a fraction from 0 to below 1",
                    self.random,
                ))
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_body_has_the_factors_of_its_part() {
        let dimensions = Dimensions { left_arm: 1.2, trunk: 0.9, ..Dimensions::uniform(1.1) };
        for (body, factor) in BODIES.iter().zip(dimensions.factors()) {
            let expected = match body.name {
                "upper_arm_l" | "forearm_l" | "hand_l" => 1.1 * 1.2,
                "pelvis" | "abdomen" | "thorax" | "clavicle_l" | "clavicle_r" => 1.1 * 0.9,
                _ => 1.1,
            };
            assert!((factor - expected).abs() < 1e-15, "{}", body.name);
        }
    }

    #[test]
    fn random_factors_are_within_their_bounds_and_of_their_seed() {
        let of_seed = |seed| Dimensions { random: 0.2, seed, ..Dimensions::default() }.factors();
        let bits = |seed| of_seed(seed).into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(3), bits(3));
        assert_ne!(bits(3), bits(4));
        assert!(of_seed(3).iter().all(|factor| (0.8..1.2).contains(factor)));
    }

    #[test]
    fn impossible_factors_are_named() {
        let fault = |dimensions: Dimensions| dimensions.fault().map(|(key, ..)| key);
        assert_eq!(Dimensions::default().fault(), None);
        assert_eq!(fault(Dimensions::uniform(f64::NAN)), Some("scale"));
        assert_eq!(fault(Dimensions { head: 0.0, ..Dimensions::default() }), Some("head"));
        assert_eq!(fault(Dimensions { random: 1.0, ..Dimensions::default() }), Some("random"));
    }
}
