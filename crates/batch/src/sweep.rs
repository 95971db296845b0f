//! The passes of the recursive Newton-Euler algorithm in all lanes: see `sinew_core::dynamics::inverse_dynamics`.

use glam::Vec3;
use sinew_core::{RotationalInertia, math::plus_cross};

use crate::joint::Motion;
use crate::lanes::{Inertias, Vectors};

/// Motion of a body in its axes, and the wrench about its origin, in all lanes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moving<const L: usize> {
    angular_velocity: Vectors<L>,
    angular_acceleration: Vectors<L>,
    /// Acceleration of the body's origin, minus gravity.
    linear_acceleration: Vectors<L>,
    pub(crate) moment: Vectors<L>,
    pub(crate) force: Vectors<L>,
}

impl<const L: usize> Moving<L> {
    /// Returns a body at rest that falls with this acceleration.
    pub(crate) const fn falling(gravity_m_s2: Vec3) -> Self {
        let up = Vec3::new(-gravity_m_s2.x, -gravity_m_s2.y, -gravity_m_s2.z);
        Self {
            angular_velocity: Vectors::ZERO,
            angular_acceleration: Vectors::ZERO,
            linear_acceleration: Vectors::all(up),
            moment: Vectors::ZERO,
            force: Vectors::ZERO,
        }
    }

    /// Computes the motion of a body from that of its parent and its joint, and the wrench that this motion needs.
    #[inline(always)]
    pub(crate) fn follow(
        &mut self,
        parent: &Self,
        joint: &Motion<L>,
        slides: bool,
        inertias: &impl Inertias,
    ) {
        for lane in 0..L {
            let to_body = joint.rotation.at(lane).transpose();
            let arm = joint.arm.at(lane);
            let w = joint.velocity.angular.at(lane);
            let of_parent = parent.angular_velocity.at(lane);
            let alpha = parent.angular_acceleration.at(lane);
            let carried_velocity = to_body * of_parent;
            let around = of_parent.cross(arm);
            let carried_acceleration =
                parent.linear_acceleration.at(lane) + alpha.cross(arm) + of_parent.cross(around);
            let turning = joint.acceleration.angular.at(lane);
            let alpha = to_body * alpha + turning + carried_velocity.cross(w);
            self.angular_velocity.set(lane, carried_velocity + w);
            self.angular_acceleration.set(lane, alpha);
            self.linear_acceleration.set(lane, to_body * carried_acceleration);
        }
        if slides {
            for lane in 0..L {
                let carried_velocity =
                    joint.rotation.at(lane).transpose() * parent.angular_velocity.at(lane);
                let [v, sliding] =
                    [&joint.velocity.linear, &joint.acceleration.linear].map(|part| part.at(lane));
                let more = carried_velocity.cross(v + v) + sliding;
                self.linear_acceleration.set(lane, self.linear_acceleration.at(lane) + more);
            }
        }
        for lane in 0..L {
            let inertia = inertias.of_lane(lane);
            let to_center = inertia.center_of_mass_m;
            let w = self.angular_velocity.at(lane);
            let alpha = self.angular_acceleration.at(lane);
            let around = w.cross(to_center);
            let of_origin = self.linear_acceleration.at(lane);
            let of_center = plus_cross(plus_cross(of_origin, alpha, to_center), w, around);
            let force = of_center * inertia.mass_kg;
            let spin = times(&inertia.rotational_kg_m2, w);
            let about_center = plus_cross(times(&inertia.rotational_kg_m2, alpha), w, spin);
            self.force.set(lane, force);
            self.moment.set(lane, plus_cross(about_center, to_center, force));
        }
    }

    /// Adds the wrench that a child's joint transmits.
    #[inline(always)]
    pub(crate) fn carry(&mut self, child: &Self, joint: &Motion<L>) {
        for lane in 0..L {
            let to_parent = joint.rotation.at(lane);
            let force = to_parent * child.force.at(lane);
            let moment = to_parent * child.moment.at(lane);
            let moment = plus_cross(moment, joint.arm.at(lane), force);
            self.moment.set(lane, self.moment.at(lane) + moment);
            self.force.set(lane, self.force.at(lane) + force);
        }
    }

    /// Adds the wrench that accelerates the rotor of the joint's drive.
    #[inline(always)]
    pub(crate) fn add_rotor(&mut self, joint: &Motion<L>, slides: bool, rotor_inertia: f32) {
        for lane in 0..L {
            let turning = joint.acceleration.angular.at(lane) * rotor_inertia;
            self.moment.set(lane, self.moment.at(lane) + turning);
        }
        if slides {
            for lane in 0..L {
                let sliding = joint.acceleration.linear.at(lane) * rotor_inertia;
                self.force.set(lane, self.force.at(lane) + sliding);
            }
        }
    }
}

/// Multiplies a symmetric matrix by a vector.
#[inline(always)]
fn times(inertia: &RotationalInertia, v: Vec3) -> Vec3 {
    let RotationalInertia { xx, xy, xz, yy, yz, zz } = *inertia;
    Vec3::new(
        xx * v.x + xy * v.y + xz * v.z,
        xy * v.x + yy * v.y + yz * v.z,
        xz * v.x + yz * v.y + zz * v.z,
    )
}
