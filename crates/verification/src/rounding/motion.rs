//! Motions and wrenches.

use super::number::Number;
use super::space::{Matrix, Vector};

/// A motion or a wrench: of the angle and of the origin, or moment and force.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// Angular part, or moment.
    pub angular: Vector,
    /// Linear part, or force.
    pub linear: Vector,
}

impl Motion {
    /// None.
    pub const ZERO: Self = Self { angular: Vector::ZERO, linear: Vector::ZERO };

    /// Power of a wrench along a motion.
    pub(super) fn dot(&self, wrench: &Self) -> Number {
        self.angular.dot(wrench.angular) + self.linear.dot(wrench.linear)
    }

    /// In the axes that a rotation leads to.
    pub(super) fn turned(&self, rotation: &Matrix) -> Self {
        Self { angular: rotation.turn(self.angular), linear: rotation.turn(self.linear) }
    }

    /// Angular and linear numbers.
    pub fn components(self) -> [Number; 6] {
        let ([a, b, c], [d, e, f]) = (self.angular.components(), self.linear.components());
        [a, b, c, d, e, f]
    }
}
