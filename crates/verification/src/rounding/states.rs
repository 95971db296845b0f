//! States of bodies and joints, and their differences: state errors.

use super::motion::Motion;
use super::number::Number;
use super::space::{Rotation, Vector};

/// State of a joint relative to its parent.
#[derive(Debug, Clone, Copy)]
pub struct Joint {
    /// Rotation of the body in the parent.
    pub rotation: Rotation,
    /// Vector from the parent's origin to the body's, parent axes.
    pub arm: Vector,
    /// Velocity of the body relative to the parent, body axes.
    pub velocity: Motion,
}

impl Joint {
    /// Creates a state from the core's, whose f32 numbers are exact.
    pub fn known(state: &sinew_core::JointState) -> Self {
        let of = Vector::known;
        Self {
            rotation: Rotation::known(state.pose.rotation),
            arm: of(state.pose.translation_m),
            velocity: Motion {
                angular: of(state.velocity.angular),
                linear: of(state.velocity.linear),
            },
        }
    }

    /// Returns the joint in the same pose, at rest.
    #[must_use]
    pub fn still(&self) -> Self {
        Self { velocity: Motion::ZERO, ..*self }
    }

    /// Returns the state of the joint's body as seen from the parent, in the parent's axes.
    #[must_use]
    pub fn in_parent(&self) -> State {
        State {
            rotation: self.rotation,
            position: self.arm,
            velocity: turned(self.rotation, self.velocity),
        }
    }
}

/// State of a body.
#[derive(Debug, Clone, Copy)]
pub struct State {
    /// Orientation of the body.
    pub rotation: Rotation,
    /// Position of the body's origin, m.
    pub position: Vector,
    /// Velocity, in the axes from which the body is seen.
    pub velocity: Motion,
}

fn turned(rotation: Rotation, motion: Motion) -> Motion {
    Motion { angular: rotation.turn(motion.angular), linear: rotation.turn(motion.linear) }
}

impl State {
    /// Returns the state of the world itself.
    pub fn world() -> Self {
        Self { rotation: Rotation::identity(), position: Vector::ZERO, velocity: Motion::ZERO }
    }

    /// Returns the state of a child body.
    #[must_use]
    pub fn child(&self, joint: &Joint) -> Self {
        let arm = self.rotation.turn(joint.arm);
        let rotation = self.rotation.after(joint.rotation);
        let relative = turned(rotation, joint.velocity);
        Self {
            rotation,
            position: self.position + arm,
            velocity: Motion {
                angular: self.velocity.angular + relative.angular,
                linear: self.velocity.linear.plus_cross(self.velocity.angular, arm)
                    + relative.linear,
            },
        }
    }

    /// Returns the state as seen from another body.
    #[must_use]
    pub fn seen_from(&self, reference: &Self) -> Self {
        let back = reference.rotation.inverse();
        let arm = self.position - reference.position;
        let carried = reference.velocity.angular.cross(arm);
        let (of_body, of_reference) = (self.velocity, reference.velocity);
        Self {
            rotation: back.after(self.rotation),
            position: back.turn(arm),
            velocity: Motion {
                angular: back.turn(of_body.angular - of_reference.angular),
                linear: back.turn(of_body.linear - of_reference.linear - carried),
            },
        }
    }

    /// Returns the state as that of a joint of this parent.
    #[must_use]
    pub fn joint(&self, parent: &Self) -> Joint {
        let seen = self.seen_from(parent);
        let velocity = turned(seen.rotation.inverse(), seen.velocity);
        Joint { rotation: seen.rotation, arm: seen.position, velocity }
    }
}

/// A state error.
#[derive(Debug, Clone, Copy)]
pub struct Difference {
    /// Rotation error as a rotation vector.
    pub angular: Vector,
    /// Position error, m.
    pub linear: Vector,
    /// Error of the angular velocity, rad/s.
    pub angular_rate: Vector,
    /// Error of the linear velocity, m/s.
    pub linear_rate: Vector,
}

impl Difference {
    /// Returns the difference of two states.
    pub fn between(desired: &State, measured: &State) -> Self {
        Self::to_rotation(desired.rotation, desired, measured)
    }

    fn to_rotation(rotation: Rotation, desired: &State, measured: &State) -> Self {
        Self {
            angular: rotation.after(measured.rotation.inverse()).log(),
            linear: desired.position - measured.position,
            angular_rate: desired.velocity.angular - measured.velocity.angular,
            linear_rate: desired.velocity.linear - measured.velocity.linear,
        }
    }
}

/// Angle below which an angle and its sine differ by less than a rounding of f32.
const SMALL: f64 = 1e-4;

/// Linear Compensation of a body with one goal.
#[derive(Debug, Clone, Copy)]
pub struct Compensated {
    /// State error of the body.
    pub difference: Difference,
    /// Sine of the angle between the directions to the goal.
    pub sine: Number,
}

impl Compensated {
    /// Computes the compensation for a goal whose vector from the desired origin is `arm`.
    pub fn new(arm: Vector, beta: Number, desired: &State, measured: &State) -> Self {
        let world = Difference::between(desired, measured);
        let way = world.linear + arm;
        let axis = arm.cross(way);
        let (sine, cosine) = (axis.length(), arm.dot(way));
        let lengths = (arm.dot(arm) * way.dot(way)).sqrt();
        // A small angle equals its sine, also if both are zero.
        let turned = if cosine.exact() > 0.0 && sine.exact() < SMALL * lengths.exact() {
            axis * (beta / lengths)
        } else {
            axis * (beta * sine.function_with(cosine, f64::atan2) / sine)
        };
        let turn = Rotation::exp(turned);
        let turned = turn.after(desired.rotation);
        let rate = arm.cross(world.linear_rate) * (beta / arm.dot(arm));
        let mut difference = Difference::to_rotation(turned, desired, measured);
        difference.angular_rate = difference.angular_rate + rate;
        Self { difference, sine: sine / lengths }
    }
}
