//! The pose of a linear drive.

use super::matrix::Matrix;
use super::numbers::{Numbers, collect};
use super::pose::{DrivePose, Tangent};
use super::rotation_vector::{RightJacobian, within_half_a_turn};
use crate::limited::LimitReason;

impl Matrix {
    pub(super) fn at_joints(&self, q: &[f32]) -> DrivePose<'_> {
        let (joints, reason) = self.within(collect(q.iter().copied()));
        let turned: Numbers =
            collect(joints.iter().zip(&self.offset).map(|(q, offset)| q - offset));
        let servos = self.servos_of(&turned);
        DrivePose { tangent: self.tangent(&joints), joints, servos, reason }
    }

    pub(super) fn at_servos(&self, s: &[f32]) -> DrivePose<'_> {
        let turned = self.joints_of(s);
        let wanted = collect(turned.iter().zip(&self.offset).map(|(q, offset)| q + offset));
        let (joints, reason) = self.within(wanted);
        let servos = collect(s.iter().copied());
        DrivePose { tangent: self.tangent(&joints), joints, servos, reason }
    }

    fn within(&self, joints: Numbers) -> (Numbers, Option<LimitReason>) {
        if self.is_ball() { within_half_a_turn(joints) } else { (joints, None) }
    }

    fn tangent(&self, joints: &[f32]) -> Tangent<'_> {
        if self.is_ball() {
            Tangent::Ball(self, RightJacobian::at(joints))
        } else {
            Tangent::Matrix(self)
        }
    }
}
