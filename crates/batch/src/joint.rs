//! Motions of joints at all instants, from coordinates in the order of `sinew_core::coordinates`.

use glam::{Mat3, Quat, Vec3};
use sinew_core::{Body, JointKind, Twist, math};

use crate::LANES;
use crate::lanes::{Matrices, Twists, Vectors};
use crate::turn::{cosine_of_root, near_unit, sine_over_angle};

/// A number for each instant.
pub(crate) type Numbers = crate::lanes::Numbers<LANES>;

/// Motion of a joint in all lanes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion<const L: usize> {
    /// Rotation from the body's axes to its parent's axes.
    pub(crate) rotation: Matrices<L>,
    /// Position of the joint in its parent's frame.
    pub(crate) arm: Vectors<L>,
    /// Velocity and acceleration, in body axes.
    pub(crate) velocity: Twists<L>,
    pub(crate) acceleration: Twists<L>,
}

/// Coordinates of a joint at all instants: positions, speeds, accelerations.
pub(crate) type Coordinates<'a> = [&'a [Numbers]; 3];

impl Motion<LANES> {
    /// Returns the motion of a joint at rest. Motions of joints that only turn keep its arm.
    pub(crate) fn at_rest(body: &Body) -> Self {
        let joint = if slides(body.joint) { JointKind::Fixed } else { body.joint };
        let q: &[f32] =
            if joint == JointKind::Spherical { &[0.0, 0.0, 0.0, 1.0] } else { &[0.0; 2] };
        let still = [0.0; 3];
        let q = &q[..joint.coordinate_count()];
        let state = joint.state(body.placement, q, &still[..joint.dof_count()]).unwrap_or_default();
        let mut rotation = Matrices::ZERO;
        for lane in 0..LANES {
            rotation.set(lane, Mat3::from_quat(math::unit(state.pose.rotation)));
        }
        Self {
            rotation,
            arm: Vectors::all(state.pose.translation_m),
            velocity: Twists::ZERO,
            acceleration: Twists::ZERO,
        }
    }

    /// Sets the motion from coordinates that the core accepts.
    #[inline(always)]
    pub(crate) fn set(&mut self, body: &Body, coordinates: Coordinates<'_>) {
        match (body.joint, coordinates) {
            (JointKind::Fixed, _) => {}
            (JointKind::Revolute { axis }, [[angles], [speeds], [accelerations]]) => {
                self.rotate_about(axis, angles, body.placement.rotation);
                for lane in 0..LANES {
                    // The core adds to zero, which converts -0 to 0.
                    self.velocity.angular.set(lane, Vec3::ZERO + axis * speeds[lane]);
                    self.acceleration.angular.set(lane, Vec3::ZERO + axis * accelerations[lane]);
                }
            }
            (JointKind::Spherical, [[x, y, z, w], [wx, wy, wz], [ax, ay, az]]) => {
                self.rotate_by([x, y, z, w], body.placement.rotation);
                for lane in 0..LANES {
                    let [w, a] = [[wx, wy, wz], [ax, ay, az]]
                        .map(|[x, y, z]| Vec3::ZERO + Vec3::new(x[lane], y[lane], z[lane]));
                    self.velocity.angular.set(lane, w);
                    self.acceleration.angular.set(lane, a);
                }
            }
            _ => self.set_one_by_one(body, coordinates),
        }
    }

    /// Sets the rotations of a hinge.
    #[inline(always)]
    fn rotate_about(&mut self, axis: Vec3, angles: &Numbers, placement: Quat) {
        let mut is_usual = true;
        for lane in 0..LANES {
            let half = axis * angles[lane] * 0.5;
            let squared = half.dot(half);
            let v = half * sine_over_angle(squared);
            let turned = Quat::from_xyzw(v.x, v.y, v.z, cosine_of_root(squared));
            let (rotation, is_near) = near_unit(placement * turned);
            self.rotation.set(lane, Mat3::from_quat(rotation));
            is_usual &= (squared <= EIGHTH * EIGHTH) & is_near;
        }
        if !is_usual {
            self.rotate_farther_about(axis, angles, placement);
        }
    }

    /// Sets the rotations of a hinge if some angles are more than a quarter of a turn.
    #[inline(always)]
    fn rotate_farther_about(&mut self, axis: Vec3, angles: &Numbers, placement: Quat) {
        let mut is_usual = true;
        for lane in 0..LANES {
            let half = axis * angles[lane] * 0.5;
            let squared = half.dot(half);
            let angle = squared.sqrt();
            // The angle is not negative, and far below the largest i32.
            #[expect(clippy::cast_possible_truncation, reason = "rounds to whole quarters")]
            let quarters = (angle * (2.0 / math::PI) + 0.5) as i32;
            let k = quarters as f32;
            let rest = ((angle - k * 1.570_312_5) - k * 4.837_513e-4) - k * 7.549_79e-8;
            let of_rest = rest * rest;
            let (sine, cosine) = (rest * sine_over_angle(of_rest), cosine_of_root(of_rest));
            let (s, c) = if quarters & 1 == 0 { (sine, cosine) } else { (cosine, sine) };
            let s = if quarters & 2 == 0 { s } else { -s };
            let c = if (quarters + 1) & 2 == 0 { c } else { -c };
            let is_small = squared <= EIGHTH * EIGHTH;
            let scale = if is_small { sine_over_angle(squared) } else { s / angle };
            let w = if is_small { cosine_of_root(squared) } else { c };
            let v = half * scale;
            let (rotation, is_near) = near_unit(placement * Quat::from_xyzw(v.x, v.y, v.z, w));
            self.rotation.set(lane, Mat3::from_quat(rotation));
            is_usual &= (angle < FARTHEST) & is_near;
        }
        if !is_usual {
            for lane in 0..LANES {
                let rotation = placement * math::exp(axis * angles[lane]);
                self.rotation.set(lane, Mat3::from_quat(math::unit(rotation)));
            }
        }
    }

    /// Sets the rotations of a ball joint.
    #[inline(always)]
    fn rotate_by(&mut self, [x, y, z, w]: [&Numbers; 4], placement: Quat) {
        let mut is_usual = true;
        for lane in 0..LANES {
            let (turned, is_unit) = near_unit(Quat::from_xyzw(x[lane], y[lane], z[lane], w[lane]));
            let (rotation, is_near) = near_unit(placement * turned);
            self.rotation.set(lane, Mat3::from_quat(rotation));
            is_usual &= is_unit & is_near;
        }
        if !is_usual {
            for lane in 0..LANES {
                let turned = math::unit(Quat::from_xyzw(x[lane], y[lane], z[lane], w[lane]));
                self.rotation.set(lane, Mat3::from_quat(math::unit(placement * turned)));
            }
        }
    }

    /// Sets the motion of a joint of any kind, one instant after the other.
    #[inline(never)]
    fn set_one_by_one(&mut self, body: &Body, [q, qd, qdd]: Coordinates<'_>) {
        for lane in 0..LANES {
            let [q, qd, qdd] = [of_lane(q, lane), of_lane(qd, lane), of_lane(qdd, lane)];
            let (nq, nv) = (body.joint.coordinate_count(), body.joint.dof_count());
            let state = body.joint.state(body.placement, &q[..nq], &qd[..nv]).unwrap_or_default();
            let in_joint = in_joint(body, state.pose.rotation);
            let columns = body.joint.motion_subspace(in_joint);
            let along = columns
                .iter()
                .zip(qdd)
                .fold(Twist::ZERO, |sum, (column, number)| sum + *column * number);
            let acceleration = along + body.joint.bias_acceleration(in_joint, state.velocity);
            self.rotation.set(lane, Mat3::from_quat(math::unit(state.pose.rotation)));
            self.arm.set(lane, state.pose.translation_m);
            for (of_all, twist) in
                [(&mut self.velocity, state.velocity), (&mut self.acceleration, acceleration)]
            {
                of_all.set(lane, twist);
            }
        }
    }
}

/// Returns the coordinates of one instant, at most seven, followed by zeros.
pub(crate) fn of_lane(coordinates: &[Numbers], lane: usize) -> [f32; 7] {
    let mut of_lane = [0.0; 7];
    for (slot, of_all) in of_lane.iter_mut().zip(coordinates) {
        *slot = of_all[lane];
    }
    of_lane
}

/// Returns the rotation of a body in the joint frame if the joint's axes depend on it, otherwise the identity.
pub(crate) fn in_joint(body: &Body, rotation: Quat) -> Quat {
    if matches!(body.joint, JointKind::Universal { .. }) {
        body.placement.rotation.conjugate() * rotation
    } else {
        Quat::IDENTITY
    }
}

/// Returns whether a joint can translate.
pub(crate) fn slides(joint: JointKind) -> bool {
    matches!(joint, JointKind::Prismatic { .. } | JointKind::Free)
}

/// An eighth of a turn, rad: half of the largest angle for which `math::exp` uses a polynomial.
const EIGHTH: f32 = 0.25 * math::PI;

/// Angle from which `math::sin_cos` uses the remainder of a division, rad.
const FARTHEST: f32 = 8192.0;
