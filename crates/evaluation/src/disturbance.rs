//! What the controller does not know of its rig: wrong masses, noisy sensors, weak and late drives.

use std::collections::VecDeque;
use std::f32::consts::TAU;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use sinew_core::control::TorqueLimit;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::{Transform, Wrench, math};
use sinew_figure::plant::Pose;
use sinew_host_util::random::{Random, Subject};
use sinew_rig::mechanism::{JointModel, Link, Mechanism};

use super::controller::narrow;

/// The most steps that a torque can come late.
pub const LATENCY_MOST: usize = 100;

/// What the controller does not know of its rig. The default is nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbance {
    /// Every body of the plant weighs a random `1 ± masses` of what the controller believes; below 1.
    pub masses: f64,
    /// Seed of the masses and of the noise.
    pub seed: u64,
    /// Standard deviation of the measured joint rotations about each axis, in rad.
    pub sensor_noise_rad: f64,
    /// Standard deviation of the measured position of the root along each axis, in m.
    pub sensor_noise_m: f64,
    /// Resolution of the joints' sensors in bits of a turn, 1 to 24; 0 for sensors without steps. Each
    /// component of a joint's rotation vector is rounded to it.
    pub sensor_bits: u32,
    /// The most that the drive of a joint gives, in N m; the root's drive is not limited.
    pub torque_limit_nm: f64,
    /// What the drives of all joints but the root's have together: the sum of their torques, in N m.
    pub supply_nm: f64,
    /// Steps that a torque comes late. Until the first arrives, the first is held.
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
    /// What cannot be, as (key, what is expected, value).
    pub(super) fn fault(&self) -> Option<(&'static str, &'static str, f64)> {
        // A range has no NaN.
        if !(0.0..1.0).contains(&self.masses) {
            return Some(("masses", "a fraction from 0 to below 1", self.masses));
        }
        // TOML, in which setups are written, has no larger integers.
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
            // In f32, the core's, a tiny limit is none at all.
            if limit_nm.is_nan() || narrow(limit_nm) <= 0.0 {
                return Some((key, "a torque above 0 N m in f32 (inf for none)", limit_nm));
            }
        }
        if self.latency_steps > LATENCY_MOST {
            return Some(("latency_steps", "0 to 100 steps", self.latency_steps as f64));
        }
        None
    }

    /// The rig as it was built: the same for every motion of a seed.
    pub(super) fn built(&self, mechanism: &Mechanism) -> Mechanism {
        let mut random = Random::new(self.seed, Subject::Masses);
        let mut built = mechanism.clone();
        for link in &mut built.bodies {
            let factor = random.between(1.0 - self.masses, 1.0 + self.masses);
            link.mass_kg *= factor;
            link.inertia_kg_m2 *= factor;
        }
        built
    }

    /// The limits of the joints' drives: this one's, or the rig's own if that is smaller. The root's drive has none.
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

/// The sensors of a run.
pub(super) struct Sensors {
    noise_rad: f64,
    noise_m: f64,
    /// What the sensors' steps are multiples of; none if they have no steps.
    step_rad: Option<f32>,
    random: Random,
}

impl Sensors {
    /// `stream` tells the clips apart: every method meets the same noise on the same clip.
    pub(super) fn new(disturbance: &Disturbance, stream: u64) -> Self {
        // Powers of two: exact.
        let steps = (1_u32 << disturbance.sensor_bits) as f32;
        Self {
            noise_rad: disturbance.sensor_noise_rad,
            noise_m: disturbance.sensor_noise_m,
            step_rad: (disturbance.sensor_bits > 0).then(|| TAU / steps),
            random: Random::numbered(disturbance.seed, stream, Subject::Noise),
        }
    }

    /// What the sensors tell, in place of the joints' true poses.
    ///
    /// A ball joint and the root have sensors about three axes; an axis or a slide has one of its own.
    pub(super) fn read(&mut self, links: &[Link], joints: &mut [Transform]) {
        if self.noise_rad > 0.0 {
            for (link, joint) in links.iter().zip(&mut *joints) {
                let turn =
                    turn_of_joint(link, joint, (self.random.normal3() * self.noise_rad).as_vec3());
                joint.rotation = (joint.rotation * math::exp(turn)).normalize();
            }
        }
        if self.noise_m > 0.0 {
            for (link, joint) in links.iter().zip(&mut *joints) {
                let way_m = match (link.parent, link.joint) {
                    (None, _) => (self.random.normal3() * self.noise_m).as_vec3(),
                    (_, JointModel::Prismatic(axis)) => {
                        let noise_m = self.random.normal3().x * self.noise_m;
                        (link.rotation * axis * noise_m).as_vec3()
                    }
                    _ => continue,
                };
                joint.translation_m += way_m;
            }
        }
        if let Some(step_rad) = self.step_rad {
            for (link, joint) in links.iter().zip(joints) {
                joint.rotation = in_steps(link, joint.rotation, step_rad);
            }
        }
    }
}

/// What of a turn in body axes the sensors of a joint can tell.
fn turn_of_joint(link: &Link, joint: &Transform, turn: Vec3) -> Vec3 {
    let along = |axis: Vec3| axis * axis.dot(turn);
    match (link.parent, link.joint) {
        (None, _) | (_, JointModel::Spherical | JointModel::Free) => turn,
        (_, JointModel::Fixed | JointModel::Prismatic(_)) => Vec3::ZERO,
        (_, JointModel::Revolute(axis)) => along(axis.as_vec3()),
        (_, JointModel::Universal([first, second])) => {
            let first = joint.rotation.conjugate() * (link.rotation * first).as_vec3();
            along(first) + along(second.as_vec3())
        }
    }
}

/// A rotation of a joint in its parent's frame as sensors with steps tell it.
fn in_steps(link: &Link, rotation: Quat, step_rad: f32) -> Quat {
    match (link.parent, link.joint) {
        (None, _) | (_, JointModel::Spherical | JointModel::Free) => {
            let steps = (math::log(rotation) / step_rad).map(f32::round_ties_even);
            math::exp(steps * step_rad)
        }
        (_, JointModel::Fixed | JointModel::Prismatic(_)) => rotation,
        (_, JointModel::Revolute(_) | JointModel::Universal(_)) => {
            let step_rad = f64::from(step_rad);
            let in_joint = link.rotation.conjugate() * rotation.as_dquat();
            let in_joint = Pose { rotation: in_joint, position_m: DVec3::ZERO };
            let angles_rad = link
                .joint
                .along(&in_joint)
                .map(|angle_rad| (angle_rad / step_rad).round_ties_even() * step_rad);
            (link.rotation * link.joint.motion(&angles_rad).rotation).as_quat().normalize()
        }
    }
}

/// The way of the torques to the drives: a queue of as many steps as they come late. They are in body axes: that is
/// where a motor keeps them while its body turns.
pub(super) struct DelayLine {
    steps: usize,
    waiting: VecDeque<Vec<Wrench>>,
}

impl DelayLine {
    pub(super) fn new(steps: usize) -> Self {
        Self { steps, waiting: VecDeque::with_capacity(steps + 1) }
    }

    /// Sends off what is wanted now; returns what arrives now.
    pub(super) fn pass(&mut self, wanted: impl Iterator<Item = Wrench>) -> &[Wrench] {
        let mut slot = if self.waiting.len() > self.steps {
            self.waiting.pop_front().unwrap_or_default()
        } else {
            Vec::new()
        };
        slot.clear();
        slot.extend(wanted);
        self.waiting.push_back(slot);
        &self.waiting[0]
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
        assert_eq!(tiny(1e-30).fault(), None);
        let _ = tiny(1e-30).torque_limits(&fixture::mechanism().bodies);
    }

    #[test]
    fn torques_arrive_late_and_the_first_is_held() {
        let arrivals = |steps: usize| {
            let mut line = DelayLine::new(steps);
            [1_u8, 2, 3, 4, 5].map(|n| {
                let wrench = Wrench::new(Vec3::X * f32::from(n), Vec3::ZERO);
                line.pass([wrench].into_iter())[0].moment_nm.x.to_bits()
            })
        };
        let bits = |numbers: [u8; 5]| numbers.map(|n| f32::from(n).to_bits());
        assert_eq!(arrivals(0), bits([1, 2, 3, 4, 5]));
        assert_eq!(arrivals(1), bits([1, 1, 2, 3, 4]));
        assert_eq!(arrivals(3), bits([1, 1, 1, 1, 2]));
    }
}
