//! Differences between a rig and the controller's model of it: wrong masses, noisy sensors, weak and late drives.

use serde::{Deserialize, Serialize};
use sinew_core::control::TorqueLimit;
use sinew_host_util::random::{Random, Subject};
use sinew_rig::mechanism::{JointModel, Link, Mechanism};

use super::capacity::MAX_LATENCY_STEPS;
use super::controller::narrow;

/// Disturbances that the controller does not know. The default has none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbance {
    /// Half-width of the random mass error: mass and inertia of every body of the plant are those in the controller's
    /// model times a random factor from `1 - masses` to `1 + masses`. Below 1.
    pub masses: f64,
    /// Seed of the masses and of the noise.
    pub seed: u64,
    /// Standard deviation of the measured joint rotations about each axis, in rad.
    pub sensor_noise_rad: f64,
    /// Standard deviation of the measured position of the root along each axis, in m.
    pub sensor_noise_m: f64,
    /// Resolution of the joints' sensors in bits per turn, 1 to 24; 0 for no quantization. Each component of a
    /// joint's rotation vector is rounded to it.
    pub sensor_bits: u32,
    /// Maximum torque of a joint's drive, in N m. The root's drive is not limited.
    pub torque_limit_nm: f64,
    /// Maximum sum of the torques of all drives, except the root's, in N m.
    pub supply_nm: f64,
    /// Latency of torques, in steps. Before the first torque has arrived, the drives already apply it.
    pub latency_steps: usize,
}

impl Default for Disturbance {
    fn default() -> Self {
        Self {
            masses: 0.0,
            seed: 0,
            sensor_noise_rad: 0.0,
            sensor_noise_m: 0.0,
            sensor_bits: 0,
            torque_limit_nm: f64::INFINITY,
            supply_nm: f64::INFINITY,
            latency_steps: 0,
        }
    }
}

impl Disturbance {
    /// Finds the first invalid value: its key, what is expected, and the value.
    pub(super) fn find_fault(&self) -> Option<(&'static str, &'static str, f64)> {
        // A range does not contain NaN.
        if !(0.0..1.0).contains(&self.masses) {
            return Some(("masses", "a fraction from 0 to below 1", self.masses));
        }
        // TOML, the format of setups, has no larger integers.
        if i64::try_from(self.seed).is_err() {
            return Some(("seed", "0 to 9223372036854775807", self.seed as f64));
        }
        if !(0.0..=1.0).contains(&self.sensor_noise_rad) {
            return Some(("sensor_noise_rad", "an angle from 0 to 1 rad", self.sensor_noise_rad));
        }
        if !(0.0..=1.0).contains(&self.sensor_noise_m) {
            return Some(("sensor_noise_m", "a length from 0 to 1 m", self.sensor_noise_m));
        }
        if self.sensor_bits > 24 {
            return Some(("sensor_bits", "0 to 24 bits", f64::from(self.sensor_bits)));
        }
        for (key, limit_nm) in
            [("torque_limit_nm", self.torque_limit_nm), ("supply_nm", self.supply_nm)]
        {
            // In the core's f32, a tiny limit would round to zero.
            if limit_nm.is_nan() || narrow(limit_nm) <= 0.0 {
                return Some((key, "a torque above 0 N m in f32 (inf for none)", limit_nm));
            }
        }
        if self.latency_steps > MAX_LATENCY_STEPS {
            return Some(("latency_steps", "0 to 100 steps", self.latency_steps as f64));
        }
        None
    }

    /// Returns the rig as it was built, with varied masses. The factors depend only on the seed and the allowed
    /// variation, so all motions have the same rig.
    pub(super) fn build(&self, mechanism: &Mechanism) -> Mechanism {
        let mut random = Random::new(self.seed, Subject::Masses);
        let mut built = mechanism.clone();
        for link in &mut built.bodies {
            let factor = random.between(1.0 - self.masses, 1.0 + self.masses);
            link.mass_kg *= factor;
            link.inertia_kg_m2 *= factor;
        }
        built
    }

    /// Returns the limits of the joints' drives: the disturbance's limit, or the rig's own if that is smaller. The
    /// root's drive has no limit.
    pub(super) fn torque_limits(&self, links: &[Link]) -> Vec<TorqueLimit> {
        let of_link = |link: &Link| {
            if link.parent.is_none() {
                return TorqueLimit::NONE;
            }
            let (torque_nm, force_n) = match link.joint {
                JointModel::Prismatic(_) => (self.torque_limit_nm, link.effort),
                _ => (self.torque_limit_nm.min(link.effort), f64::INFINITY),
            };
            let limit = TorqueLimit::new(narrow(torque_nm), narrow(force_n));
            limit.expect("checked to be above 0")
        };
        links.iter().map(of_link).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Setup;
    use sinew_figure::fixture;

    fn refused(disturbance: Disturbance) -> String {
        Setup { disturbance, ..Setup::default() }.check().unwrap_err().to_string()
    }

    #[test]
    fn a_seed_that_toml_cannot_hold_is_refused() {
        let most = i64::MAX.unsigned_abs();
        let refused = refused(Disturbance { seed: most + 1, ..Disturbance::default() });
        assert!(refused.contains("disturbance.seed"), "{refused}");
        let disturbance = Disturbance { seed: most, ..Disturbance::default() };
        let setup = Setup { disturbance, ..Setup::default() };
        setup.check().unwrap();
        assert_eq!(setup.differences(), [format!("disturbance.seed = {most}")]);
    }

    #[test]
    fn a_torque_limit_that_is_none_in_f32_is_refused() {
        let tiny = |torque_limit_nm| Disturbance { torque_limit_nm, ..Disturbance::default() };
        for none in [1e-60, 0.0, -1.0, f64::NAN] {
            let refused = refused(tiny(none));
            assert!(refused.contains("disturbance.torque_limit_nm"), "{refused}");
        }
        assert_eq!(tiny(1e-30).find_fault(), None);
        let _ = tiny(1e-30).torque_limits(&fixture::mechanism().bodies);
    }
}
