//! Motions and wrenches.

use super::number::Number;
use super::space::{Matrix, Vector};

/// A motion or a wrench: angular and linear motion of the origin, or moment and force.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// Angular part, or moment.
    pub angular: Vector,
    /// Linear part, or force.
    pub linear: Vector,
}

impl Motion {
    /// Zero motion or wrench.
    pub const ZERO: Self = Self { angular: Vector::ZERO, linear: Vector::ZERO };

    /// Returns the power of a wrench along a motion.
    pub(super) fn dot(&self, wrench: &Self) -> Number {
        self.angular.dot(wrench.angular) + self.linear.dot(wrench.linear)
    }

    /// Returns the motion in rotated axes.
    pub(super) fn turned(&self, rotation: &Matrix) -> Self {
        Self { angular: rotation.turn(self.angular), linear: rotation.turn(self.linear) }
    }

    /// Returns the angular and linear components.
    pub fn components(self) -> [Number; 6] {
        let ([a, b, c], [d, e, f]) = (self.angular.components(), self.linear.components());
        [a, b, c, d, e, f]
    }
}
