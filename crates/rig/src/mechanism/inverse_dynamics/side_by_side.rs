//! The core's inverse dynamics of several instants side by side. Each instant gets the operations of the core in the
//! core's order, so that the results are equal bit by bit. This takes a third of the time. A fit of a motion spends
//! most of its time here.

use std::array::from_fn;
use std::ops::Range;

use glam::{Quat, Vec3};
use sinew_core::{Body, GRAVITY_M_S2, JointKind, RotationalInertia, Twist, math};

use super::lanes::{LANES, Lanes, Matrices, Quaternions, Vectors};

/// Largest number that the core accepts.
const LARGEST: f32 = 1e6;

/// Motion and wrench of a body at all instants.
#[derive(Debug, Clone, Copy)]
struct Moving {
    /// Rotation from the body's axes to its parent's axes.
    rotation: Matrices,
    /// Position of the joint in its parent's frame.
    arm: Vectors,
    /// Angular part of the joint's acceleration, from which the moment on the rotor is computed.
    turning: Vectors,
    sliding: Vectors,
    /// Motion of the body, in its axes: see `sinew_core::dynamics::BodyMotion`.
    angular_velocity: Vectors,
    angular_acceleration: Vectors,
    linear_acceleration: Vectors,
    moment: Vectors,
    force: Vectors,
}

impl Moving {
    const STILL: Self = Self {
        rotation: Matrices::ZERO,
        arm: Vectors::ZERO,
        turning: Vectors::ZERO,
        sliding: Vectors::ZERO,
        angular_velocity: Vectors::ZERO,
        angular_acceleration: Vectors::ZERO,
        linear_acceleration: Vectors::ZERO,
        moment: Vectors::ZERO,
        force: Vectors::ZERO,
    };
}

/// Motion of a joint at all instants.
struct Joint {
    rotation: Quaternions,
    arm: Vectors,
    velocity: [Vectors; 2],
    acceleration: [Vectors; 2],
}

/// Buffers for the bodies of a tree, and the places of their coordinates.
#[derive(Debug)]
pub(super) struct SideBySide {
    moving: Vec<Moving>,
    /// Ranges of each body in `q` and in `qd`.
    ranges: Vec<[Range<usize>; 2]>,
    efforts: Vec<[f32; LANES]>,
}

impl SideBySide {
    pub(super) fn new(bodies: &[Body]) -> Self {
        let mut ends = [0, 0];
        let ranges: Vec<[Range<usize>; 2]> = bodies
            .iter()
            .map(|body| {
                let [q, qd] = ends;
                ends = [q + body.joint.coordinate_count(), qd + body.joint.dof_count()];
                [q..ends[0], qd..ends[1]]
            })
            .collect();
        Self {
            moving: vec![Moving::STILL; bodies.len()],
            ranges,
            efforts: vec![[0.0; LANES]; ends[1]],
        }
    }

    /// Returns whether the core certainly accepts these positions, speeds and accelerations. The result may be
    /// false for some values that the core accepts.
    pub(super) fn takes(&self, bodies: &[Body], motion: [&[[f32; LANES]]; 3]) -> bool {
        let [q, _, _] = motion;
        let is_unit = |(body, [of_q, of_qd]): (&Body, &[Range<usize>; 2])| {
            let of_joint = &q[of_q.clone()];
            of_joint.len() < 4
                || (0..LANES).all(|lane| {
                    let of_joint: Vec<f32> = of_joint.iter().map(|lanes| lanes[lane]).collect();
                    let still = vec![0.0; of_qd.len()];
                    body.joint.state(body.placement, &of_joint, &still).is_ok()
                })
        };
        let [nq, nv] = self.ranges.last().map_or([0; 2], |ends| ends.each_ref().map(|end| end.end));
        motion.map(<[_]>::len) == [nq, nv, nv]
            && motion.iter().all(|numbers| {
                numbers.iter().all(|lanes| lanes.map(f32::abs).iter().all(|x| *x <= LARGEST))
            })
            && bodies.iter().zip(&self.ranges).all(is_unit)
    }

    /// Returns efforts for positions, speeds and accelerations that the core accepts: see
    /// `sinew_core::coordinates`.
    pub(super) fn efforts(
        &mut self,
        bodies: &[Body],
        [q, qd, qdd]: [&[[f32; LANES]]; 3],
    ) -> &[[f32; LANES]] {
        let world = Moving { linear_acceleration: Vectors::all(-GRAVITY_M_S2), ..Moving::STILL };
        for (index, (body, [of_q, of_qd])) in bodies.iter().zip(&self.ranges).enumerate() {
            let joint = Joint::of(body, &q[of_q.clone()], &qd[of_qd.clone()], &qdd[of_qd.clone()]);
            let parent = body.parent.map_or(&world, |parent| &self.moving[parent]);
            self.moving[index] = outward(parent, body, &joint);
        }
        for (body, moving) in bodies.iter().zip(&mut self.moving) {
            newton_euler(body, moving);
        }
        for (index, body) in bodies.iter().enumerate().rev() {
            let Moving { rotation, arm, turning, sliding, moment, force, .. } = self.moving[index];
            if let Some(parent) = body.parent {
                let parent = &mut self.moving[parent];
                let force = rotation.turn(force);
                parent.moment = parent.moment + rotation.turn(moment).plus_cross(arm, force);
                parent.force = parent.force + force;
            }
            let (mut moment, mut force) = (moment, force);
            if body.rotor_inertia > 0.0 {
                let rotor = Lanes::all(body.rotor_inertia);
                moment = moment + turning * rotor;
                if slides(body.joint) {
                    force = force + sliding * rotor;
                }
            }
            let [of_q, of_qd] = &self.ranges[index];
            let out = &mut self.efforts[of_qd.clone()];
            if let JointKind::Revolute { axis } = body.joint {
                out[0] = (Lanes::ZERO + Vectors::all(axis).dot(moment)).0;
            } else {
                along_columns(body, &q[of_q.clone()], [moment, force], out);
            }
        }
        &self.efforts
    }
}

fn slides(joint: JointKind) -> bool {
    matches!(joint, JointKind::Prismatic { .. } | JointKind::Free)
}

impl Joint {
    /// Computes the motion from coordinates in the order of `JointTargets::set_coordinates`.
    #[inline]
    fn of(body: &Body, q: &[[f32; LANES]], qd: &[[f32; LANES]], qdd: &[[f32; LANES]]) -> Self {
        let (JointKind::Revolute { axis }, [angles], [speeds], [accelerations]) =
            (body.joint, q, qd, qdd)
        else {
            return Self::of_columns(body, q, qd, qdd);
        };
        let turned = Quaternions::about(axis, Lanes(*angles));
        // The core adds to zero, which converts -0 to 0.
        let along = |numbers: &[f32; LANES]| {
            let Vectors { x, y, z } = Vectors::all(axis) * Lanes(*numbers);
            Vectors { x: Lanes::ZERO + x, y: Lanes::ZERO + y, z: Lanes::ZERO + z }
        };
        Self {
            rotation: turned.behind(body.placement.rotation).unit(),
            arm: Vectors::all(body.placement.translation_m),
            velocity: [along(speeds), Vectors::ZERO],
            acceleration: [along(accelerations), Vectors::ZERO],
        }
    }

    /// Computes the motion of a joint of any kind, one instant after the other.
    fn of_columns(
        body: &Body,
        q: &[[f32; LANES]],
        qd: &[[f32; LANES]],
        qdd: &[[f32; LANES]],
    ) -> Self {
        if q.is_empty() {
            // A fixed joint.
            let state = body.joint.state(body.placement, &[], &[]).unwrap_or_default();
            return Self {
                rotation: Quaternions::of([math::unit(state.pose.rotation); LANES]),
                arm: Vectors::all(state.pose.translation_m),
                velocity: [Vectors::ZERO; 2],
                acceleration: [Vectors::ZERO; 2],
            };
        }
        let lane = |numbers: &[[f32; LANES]], lane: usize| -> Vec<f32> {
            numbers.iter().map(|of_lanes| of_lanes[lane]).collect()
        };
        let states = from_fn(|k| {
            body.joint.state(body.placement, &lane(q, k), &lane(qd, k)).unwrap_or_default()
        });
        let accelerations: [Twist; LANES] = from_fn(|k| {
            let in_joint = in_joint(body, states[k].pose.rotation);
            let columns = body.joint.motion_subspace(in_joint);
            let along = columns
                .iter()
                .zip(lane(qdd, k))
                .fold(Twist::ZERO, |sum, (column, number)| sum + *column * number);
            along + body.joint.bias_acceleration(in_joint, states[k].velocity)
        });
        let [turning, sliding]: [fn(&Twist) -> Vec3; 2] =
            [|twist| twist.angular, |twist| twist.linear];
        let vectors = |twists: [Twist; LANES]| {
            [turning, sliding].map(|part| Vectors::of(from_fn(|k| part(&twists[k]))))
        };
        Self {
            rotation: Quaternions::of(from_fn(|k| math::unit(states[k].pose.rotation))),
            arm: Vectors::of(states.map(|state| state.pose.translation_m)),
            velocity: vectors(states.map(|state| state.velocity)),
            acceleration: vectors(accelerations),
        }
    }
}

/// Returns the rotation of a body in the joint frame if the joint's axes depend on it, otherwise the identity.
fn in_joint(body: &Body, rotation: Quat) -> Quat {
    if matches!(body.joint, JointKind::Universal { .. }) {
        body.placement.rotation.conjugate() * rotation
    } else {
        Quat::IDENTITY
    }
}

/// Computes the motion of a body from that of its parent and its joint.
#[inline]
fn outward(parent: &Moving, body: &Body, joint: &Joint) -> Moving {
    let rotation = Matrices::of(joint.rotation);
    let (arm, [w, v]) = (joint.arm, joint.velocity);
    let [turning, sliding] = joint.acceleration;
    let carried_velocity = rotation.turn_back(parent.angular_velocity);
    let around = parent.angular_velocity.cross(arm);
    let carried_acceleration = parent.linear_acceleration
        + parent.angular_acceleration.cross(arm)
        + parent.angular_velocity.cross(around);
    let mut linear_acceleration = rotation.turn_back(carried_acceleration);
    if slides(body.joint) {
        linear_acceleration = linear_acceleration + (carried_velocity.cross(v + v) + sliding);
    }
    Moving {
        rotation,
        arm,
        turning,
        sliding,
        angular_velocity: carried_velocity + w,
        angular_acceleration: rotation.turn_back(parent.angular_acceleration)
            + turning
            + carried_velocity.cross(w),
        linear_acceleration,
        ..Moving::STILL
    }
}

/// Sets the wrench about the body's origin that its motion needs.
#[inline]
fn newton_euler(body: &Body, moving: &mut Moving) {
    let inertia = &body.inertia;
    let (w, alpha) = (moving.angular_velocity, moving.angular_acceleration);
    let to_center = Vectors::all(inertia.center_of_mass_m);
    let around = w.cross(to_center);
    let of_center = moving.linear_acceleration.plus_cross(alpha, to_center).plus_cross(w, around);
    moving.force = of_center * Lanes::all(inertia.mass_kg);
    let spin = times(&inertia.rotational_kg_m2, w);
    let about_center = times(&inertia.rotational_kg_m2, alpha).plus_cross(w, spin);
    moving.moment = about_center.plus_cross(to_center, moving.force);
}

/// Multiplies a symmetric matrix by vectors.
#[inline]
fn times(inertia: &RotationalInertia, v: Vectors) -> Vectors {
    let RotationalInertia { xx, xy, xz, yy, yz, zz } = *inertia;
    let [xx, xy, xz, yy, yz, zz] = [xx, xy, xz, yy, yz, zz].map(Lanes::all);
    Vectors {
        x: xx * v.x + xy * v.y + xz * v.z,
        y: xy * v.x + yy * v.y + yz * v.z,
        z: xz * v.x + yz * v.y + zz * v.z,
    }
}

/// Projects a moment and a force onto the axes of a joint of any kind, one instant after the other.
fn along_columns(
    body: &Body,
    q: &[[f32; LANES]],
    [moment, force]: [Vectors; 2],
    out: &mut [[f32; LANES]],
) {
    for lane in 0..LANES {
        let [moment, force] =
            [moment, force].map(|v| Vec3::new(v.x.0[lane], v.y.0[lane], v.z.0[lane]));
        if body.joint == JointKind::Spherical {
            // The core adds to zero, which converts -0 to 0.
            let along = Vec3::ZERO + moment;
            out.iter_mut().zip(along.to_array()).for_each(|(out, along)| out[lane] = along);
            continue;
        }
        let q: Vec<f32> = q.iter().map(|of_lanes| of_lanes[lane]).collect();
        let still = [0.0; 6];
        let state = body.joint.state(body.placement, &q, &still[..out.len()]).unwrap_or_default();
        let columns = body.joint.motion_subspace(in_joint(body, math::unit(state.pose.rotation)));
        for (out, column) in out.iter_mut().zip(&columns) {
            out[lane] = column.angular.dot(moment) + column.linear.dot(force);
        }
    }
}
