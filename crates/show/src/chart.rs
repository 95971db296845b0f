//! Converts channels to joint coordinates.
//!
//! A rotation is stored as a quaternion p of any length: the joint's rotation is p / |p|. Four numbers for three dofs
//! avoid poles, wrap-around and segments: the curve may turn any number of times. In body axes:
//!
//! - ω = 2 Im(p̄ ṗ) / |p|²
//! - ω̇ = 2 Im(p̄ p̈) / |p|² - 2 (p · ṗ) / |p|² ω

use core::slice::IterMut;

use glam::{Quat, Vec3};
use sinew_core::math;

use crate::joint::Joint;
use crate::span::Jet;

/// Minimum squared length of p. Written shows have a length of 1 within their error.
const SHORTEST_SQUARED: f32 = 0.01;

/// A writer of coordinates, joint after joint. Numbers that do not fit are left out.
pub(crate) struct Coordinates<'a> {
    q: IterMut<'a, f32>,
    qd: IterMut<'a, f32>,
    qdd: IterMut<'a, f32>,
}

impl<'a> Coordinates<'a> {
    pub(crate) fn new(q: &'a mut [f32], qd: &'a mut [f32], qdd: &'a mut [f32]) -> Self {
        Self { q: q.iter_mut(), qd: qd.iter_mut(), qdd: qdd.iter_mut() }
    }

    /// Writes the coordinates of the next joint. `channel` returns the jets of the joint's channels, one after the
    /// other, per second.
    #[inline]
    pub(crate) fn put(&mut self, joint: Joint, mut channel: impl FnMut() -> Jet) {
        if !joint.turns_freely() {
            for _ in 0..joint.coordinate_count() {
                let [p, v, a] = channel();
                put(&mut self.q, [p]);
                put(&mut self.qd, [v]);
                put(&mut self.qdd, [a]);
            }
            return;
        }
        let [p, p1, p2] = transposed([channel(), channel(), channel(), channel()])
            .map(|[x, y, z, w]| Quat::from_xyzw(x, y, z, w));
        let (rotation, speed, acceleration) = turning(p, p1, p2);
        put(&mut self.q, rotation.to_array());
        put(&mut self.qd, speed.to_array());
        put(&mut self.qdd, acceleration.to_array());
        if joint == Joint::Free {
            let [p, p1, p2] = transposed([channel(), channel(), channel(), [0.0; 3]])
                .map(|[x, y, z, _]| Vec3::new(x, y, z));
            let to_body = rotation.conjugate();
            put(&mut self.q, p.to_array());
            put(&mut self.qd, math::rotate(to_body, p1).to_array());
            put(&mut self.qdd, math::rotate(to_body, p2).to_array());
        }
    }
}

fn put<const K: usize>(slots: &mut IterMut<'_, f32>, numbers: [f32; K]) {
    for number in numbers {
        if let Some(slot) = slots.next() {
            *slot = number;
        }
    }
}

/// Returns the rotation of p, with its angular velocity and acceleration, in body axes.
fn turning(p: Quat, p1: Quat, p2: Quat) -> (Quat, Vec3, Vec3) {
    let squared = p.dot(p);
    if squared < SHORTEST_SQUARED {
        return (Quat::IDENTITY, Vec3::ZERO, Vec3::ZERO);
    }
    let conjugate = p.conjugate();
    let factor = 2.0 / squared;
    let speed = (conjugate * p1).xyz() * factor;
    let acceleration = (conjugate * p2).xyz() * factor - speed * (factor * p.dot(p1));
    (p * (1.0 / math::sqrt(squared)), speed, acceleration)
}

/// Writes the jets of coordinates with the velocity `qd` and acceleration `qdd`: the inverse of [`Coordinates::put`],
/// with |p| = 1.
pub(crate) fn jets(joint: Joint, q: &[f32], qd: &[f32], qdd: &[f32], out: &mut [Jet]) {
    match (joint, q, qd, qdd) {
        (
            Joint::Spherical | Joint::Free,
            &[x, y, z, w, ref position @ ..],
            &[wx, wy, wz, ref linear @ ..],
            &[ax, ay, az, ref linear_acceleration @ ..],
        ) => {
            let rotation = math::unit(Quat::from_xyzw(x, y, z, w));
            let (speed, acceleration) = (Vec3::new(wx, wy, wz), Vec3::new(ax, ay, az));
            let pure = |v: Vec3, w: f32| Quat::from_xyzw(v.x, v.y, v.z, w);
            let p1 = rotation * pure(speed * 0.5, 0.0);
            let p2 = rotation * pure(acceleration * 0.5, -0.25 * speed.length_squared());
            let (of_rotation, of_position) = out.split_at_mut(out.len().min(4));
            fill([rotation, p1, p2].map(|q| q.to_array()), of_rotation);
            if let (&[px, py, pz], &[vx, vy, vz], &[bx, by, bz]) =
                (position, linear, linear_acceleration)
            {
                let v = math::rotate(rotation, Vec3::new(vx, vy, vz));
                let b = math::rotate(rotation, Vec3::new(bx, by, bz));
                fill([[px, py, pz], v.to_array(), b.to_array()], of_position);
            }
        }
        _ => {
            for (slot, ((q, qd), qdd)) in out.iter_mut().zip(q.iter().zip(qd).zip(qdd)) {
                *slot = [*q, *qd, *qdd];
            }
        }
    }
}

/// Writes jets from positions, speeds and accelerations.
fn fill<const K: usize>([p, v, a]: [[f32; K]; 3], out: &mut [Jet]) {
    for (slot, ((p, v), a)) in out.iter_mut().zip(p.into_iter().zip(v).zip(a)) {
        *slot = [p, v, a];
    }
}

/// Returns positions, speeds and accelerations, each of four channels.
fn transposed(jets: [Jet; 4]) -> [[f32; 4]; 3] {
    let [[x, y, z], [x1, y1, z1], [x2, y2, z2], [x3, y3, z3]] = jets;
    [[x, x1, x2, x3], [y, y1, y2, y3], [z, z1, z2, z3]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    /// Compares speeds and accelerations with f64 differences of the rotation p / |p| itself, and of the position.
    #[test]
    #[expect(clippy::indexing_slicing, clippy::cast_possible_truncation, reason = "a test")]
    fn speeds_and_accelerations_are_derivatives() {
        let mut random = 7u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(random >> 8) / f64::from(1u32 << 23) - 1.0
        };
        for _ in 0..500 {
            // Value, speed and half the acceleration of seven channels, in numbers that f32 represents.
            let powers: [[f64; 3]; 7] =
                [0; 7].map(|_| [next(), 3.0 * next(), 20.0 * next()].map(|x| f64::from(x as f32)));
            let at = |t: f64| powers.map(|[p, v, a]| p + t * (v + t * a));
            let rotation = |t: f64| {
                let [x, y, z, w, ..] = at(t);
                DQuat::from_xyzw(x, y, z, w).normalize()
            };
            let [x, y, z, w, ..] = at(0.0);
            let length = DQuat::from_xyzw(x, y, z, w).length();
            if length < 0.5 {
                continue;
            }
            let h = 1e-5;
            let turned = |t: f64| (rotation(t - h).conjugate() * rotation(t + h)).xyz() / h;
            let (mut q, mut qd, mut qdd) = ([0.0; 7], [0.0; 6], [0.0; 6]);
            let mut jets = powers.iter().map(|[p, v, a]| [*p as f32, *v as f32, 2.0 * *a as f32]);
            Coordinates::new(&mut q, &mut qd, &mut qdd)
                .put(Joint::Free, || jets.next().unwrap_or_default());
            let vector = |v: &[f32]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
            let speed = turned(0.0);
            let acceleration = (turned(h) - turned(-h)) / (2.0 * h);
            let size = 1.0 + speed.length() + speed.length_squared() + acceleration.length();
            // Tolerance: f32 rounding, and the error of f64 differences over 1e-5 s.
            assert!((vector(&qd) - speed).length() < 1e-5 * size, "{} {speed}", vector(&qd));
            assert!(
                (vector(&qdd) - acceleration).length() < 2e-5 * size,
                "{} {acceleration}",
                vector(&qdd)
            );
            let to_body = rotation(0.0).conjugate();
            let linear = |power: usize, factor: f64| {
                to_body * DVec3::new(powers[4][power], powers[5][power], powers[6][power]) * factor
            };
            assert!((vector(&qd[3..]) - linear(1, 1.0)).length() < 1e-5);
            assert!((vector(&qdd[3..]) - linear(2, 2.0)).length() < 1e-4);
            // The inverse conversion.
            let mut back = [Jet::default(); 7];
            super::jets(Joint::Free, &q, &qd, &qdd, &mut back);
            let mut jets = back.into_iter();
            let (mut q2, mut qd2, mut qdd2) = ([0.0; 7], [0.0; 6], [0.0; 6]);
            Coordinates::new(&mut q2, &mut qd2, &mut qdd2)
                .put(Joint::Free, || jets.next().unwrap_or_default());
            for (a, b) in q.iter().chain(&qd).chain(&qdd).zip(q2.iter().chain(&qd2).chain(&qdd2)) {
                assert!(f64::from((a - b).abs()) < 1e-5 * size, "{a} {b}");
            }
        }
    }
}
