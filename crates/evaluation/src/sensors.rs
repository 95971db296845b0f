//! The sensors of a run: noise and quantization.

use std::f32::consts::TAU;

use glam::DVec3;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::{Transform, math};
use sinew_figure::plant::Pose;
use sinew_host_util::random::{Random, Subject};
use sinew_rig::mechanism::{JointModel, Link};

use super::disturbance::Disturbance;

/// The sensors of a run.
pub(super) struct Sensors {
    noise_rad: f64,
    noise_m: f64,
    /// Quantization step of the sensors; `None` if they do not quantize.
    step_rad: Option<f32>,
    random: Random,
}

impl Sensors {
    /// Creates the sensors. `stream` distinguishes the clips: every method receives the same noise for one clip.
    pub(super) fn new(disturbance: &Disturbance, stream: u64) -> Self {
        // The number of steps is a power of two, which is exact in f32.
        let steps = (1_u32 << disturbance.sensor_bits) as f32;
        Self {
            noise_rad: disturbance.sensor_noise_rad,
            noise_m: disturbance.sensor_noise_m,
            step_rad: (disturbance.sensor_bits > 0).then(|| TAU / steps),
            random: Random::numbered(disturbance.seed, stream, Subject::Noise),
        }
    }

    /// Replaces the joints' true poses with the readings of the sensors.
    ///
    /// A ball joint and the root have sensors about three axes; a hinge axis or a slide has one sensor.
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

/// Returns the component of a rotation in body axes that the sensors of a joint can measure.
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

/// Quantizes the rotation of a joint in its parent's frame.
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
