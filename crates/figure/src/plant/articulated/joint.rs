//! Joints of any kind in reduced coordinates: their state, their dofs, and the integration of the state.
//!
//! A ball joint without rotor, friction and range needs none of this; see `dynamics.rs`.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::bounds::{Bounds, Mode};
use super::spatial::{InParent, MAX_DOFS, MotionAxis, World};
use crate::plant::{JointModel, Link as Given, Pose};

/// The response of a joint's dofs to the acceleration of the parent at the joint: `rates = alone - dragged · (α, a)`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct DofResponse {
    pub(super) alone: [f64; MAX_DOFS],
    pub(super) dragged: [MotionAxis; MAX_DOFS],
}

/// A joint of any kind, and its state.
#[derive(Debug, Clone)]
pub(super) struct Joint {
    kind: JointModel,
    /// Pose of the joint frame in the parent's frame.
    placement: Pose,
    /// Inertia that the rotor adds along each dof.
    pub(super) rotor: f64,
    /// Coulomb friction along each dof.
    pub(super) friction: f64,
    /// Viscous friction along each dof.
    pub(super) damping: f64,
    /// Lower and upper limit of each coordinate; infinite if there is no limit.
    ranges: [[f64; 2]; 2],
    /// Angles or distance of a joint of one or two axes.
    coordinates: [f64; 2],
    /// Speeds along the dofs.
    pub(super) speeds: [f64; MAX_DOFS],
    /// Force of the drive on the body, body axes.
    pub(super) force_n: DVec3,

    pub(super) motion_axes: [MotionAxis; MAX_DOFS],
    /// Number of dofs.
    pub(super) count: usize,
    pub(super) modes: [Mode; MAX_DOFS],
    /// Accelerations along the dofs.
    pub(super) rates: [f64; MAX_DOFS],
    pub(super) response: DofResponse,
}

/// Returns the coordinates of a joint along its axes. Poses do not count turns: each angle is the value nearest to
/// the middle of its range.
fn coordinates(given: &Given, in_joint: &Pose) -> [f64; 2] {
    let mut coordinates = given.joint.along(in_joint);
    if let JointModel::Revolute(_) | JointModel::Universal(_) = given.joint {
        for (angle, [least, most]) in coordinates.iter_mut().zip(&given.ranges) {
            let turns = (0.5 * (least + most) - *angle) / TAU;
            if turns.is_finite() {
                *angle += TAU * turns.round();
            }
        }
    }
    coordinates
}

impl Joint {
    /// Creates the joint of a body; `None` for a ball joint that turns freely.
    pub(super) fn new(given: &Given, state: &InParent) -> Option<Self> {
        let free = given.rotor_inertia == 0.0
            && given.friction == 0.0
            && given.damping == 0.0
            && given.ranges.is_empty();
        if given.joint == JointModel::Spherical && free {
            return None;
        }
        let placement = Pose { rotation: given.rotation, position_m: given.position_m };
        let mut ranges = [[f64::NEG_INFINITY, f64::INFINITY]; 2];
        for (range, given) in ranges.iter_mut().zip(&given.ranges) {
            *range = *given;
        }
        let mut joint = Self {
            kind: given.joint,
            placement,
            rotor: given.rotor_inertia,
            friction: given.friction,
            damping: given.damping,
            ranges,
            coordinates: coordinates(given, &placement.inside(&state.pose)),
            speeds: [0.0; MAX_DOFS],
            force_n: DVec3::ZERO,
            motion_axes: [MotionAxis::default(); MAX_DOFS],
            count: given.joint.kind().dof_count(),
            modes: [Mode::Slide(0.0); MAX_DOFS],
            rates: [0.0; MAX_DOFS],
            response: DofResponse::default(),
        };
        let in_body = joint.axes_in_body(&state.pose);
        let in_parent = joint.slides_in_parent();
        for (dof, speed) in joint.speeds.iter_mut().take(joint.count).enumerate() {
            *speed = in_body[dof].dot(state.spin_rad_s) + in_parent[dof].dot(state.slide_m_s);
        }
        for (mode, speed) in joint.modes.iter_mut().zip(joint.speeds) {
            *mode = Mode::of_speed(joint.friction, speed);
        }
        Some(joint)
    }

    /// Returns the axes of the rotational dofs in the body's frame; zero for translational dofs.
    fn axes_in_body(&self, in_parent: &Pose) -> [DVec3; MAX_DOFS] {
        let mut axes = [DVec3::ZERO; MAX_DOFS];
        match self.kind {
            JointModel::Fixed | JointModel::Prismatic(_) => {}
            JointModel::Revolute(axis) => axes[0] = axis,
            JointModel::Universal([first, second]) => {
                axes[0] = in_parent.rotation.conjugate() * (self.placement.rotation * first);
                axes[1] = second;
            }
            JointModel::Free => axes[..3].copy_from_slice(&DVec3::AXES),
            JointModel::Spherical if !self.is_near_end(in_parent) => {
                axes[..3].copy_from_slice(&DVec3::AXES);
            }
            JointModel::Spherical => {
                // The first axis is that of the turn towards the end of the range.
                let (axis, _) = self.swing(in_parent);
                let (second, third) = axis.any_orthonormal_pair();
                axes[..3].copy_from_slice(&[axis, second, third]);
            }
        }
        axes
    }

    /// Returns the directions of the translational dofs in the parent's frame; zero for rotational dofs.
    fn slides_in_parent(&self) -> [DVec3; MAX_DOFS] {
        let mut slides = [DVec3::ZERO; MAX_DOFS];
        match self.kind {
            JointModel::Prismatic(axis) => slides[0] = self.placement.rotation * axis,
            JointModel::Free => slides[3..].copy_from_slice(&DVec3::AXES),
            _ => {}
        }
        slides
    }

    /// Returns whether a ball joint may reach the end of its range in a step. Otherwise its friction acts along
    /// the axes of the body, like the friction of three drives.
    fn is_near_end(&self, in_parent: &Pose) -> bool {
        /// Longest time step of any control.
        const STEP_S: f64 = 0.1;
        /// Margin larger than the angle that acceleration can add within a step.
        const MARGIN_RAD: f64 = 0.1;
        let [_, end] = self.ranges[0];
        // The length is the same for any three orthogonal axes.
        let speed_rad_s = DVec3::from_slice(&self.speeds[..3]).length();
        end.is_finite() && self.swing(in_parent).1 + STEP_S * speed_rad_s + MARGIN_RAD >= end
    }

    /// Returns axis and angle of a ball joint's rotation from its placement.
    fn swing(&self, in_parent: &Pose) -> (DVec3, f64) {
        let turn = self.placement.rotation.conjugate() * in_parent.rotation;
        let turn = if turn.w < 0.0 { -turn } else { turn };
        let angle_rad = 2.0 * libm::atan2(turn.xyz().length(), turn.w);
        (turn.xyz().normalize_or(DVec3::X), angle_rad)
    }

    /// Returns whether friction or the end of a range may hold the joint.
    pub(super) fn is_bounded(&self) -> bool {
        self.friction > 0.0 || self.ranges.iter().flatten().any(|end| end.is_finite())
    }

    /// Returns the bounds that may hold a dof, for a step of `h` seconds.
    pub(super) fn bounds(&self, dof: usize, in_parent: &Pose, h: f64) -> Bounds {
        // A ball joint's turns perpendicular to the turn that leads to its end also lead a little beyond the end,
        // of second order in the step. Without the correction they would accumulate.
        const BACK_RAD_S: f64 = 1.0;
        let none = [f64::NEG_INFINITY, f64::INFINITY];
        let back = if self.kind == JointModel::Spherical { BACK_RAD_S } else { 0.0 };
        let (range, at) = match self.kind {
            JointModel::Spherical if dof == 0 && self.is_near_end(in_parent) => {
                ([f64::NEG_INFINITY, self.ranges[0][1]], self.swing(in_parent).1)
            }
            JointModel::Revolute(_) | JointModel::Prismatic(_) | JointModel::Universal(_) => {
                (self.ranges[dof], self.coordinates[dof])
            }
            _ => (none, 0.0),
        };
        Bounds::new(range, at, self.friction, h, back)
    }

    /// Updates the motion axes from the poses of the body and its parent in the world.
    pub(super) fn update_motion_axes(
        &mut self,
        in_parent: &InParent,
        parent: &World,
        body: &World,
    ) {
        let (axes, slides) = (self.axes_in_body(&in_parent.pose), self.slides_in_parent());
        if self.kind == JointModel::Spherical {
            // The axes change from step to step, but the spin does not.
            let spin = in_parent.spin_rad_s;
            for (speed, axis) in self.speeds.iter_mut().zip(axes).take(3) {
                *speed = axis.dot(spin);
            }
        }
        for (motion, (axis, slide)) in self.motion_axes.iter_mut().zip(axes.into_iter().zip(slides))
        {
            *motion = MotionAxis { angular: body.axes * axis, linear: parent.axes * slide };
        }
    }

    /// Returns the acceleration of the body that results from the motion of its own dofs, without the parent's
    /// rotation.
    pub(super) fn bias_rad_s2(&self) -> DVec3 {
        match self.kind {
            // The first axis rotates the second.
            JointModel::Universal(_) => {
                let [first, second, ..] = self.motion_axes;
                first.angular.cross(second.angular) * (self.speeds[0] * self.speeds[1])
            }
            _ => DVec3::ZERO,
        }
    }

    /// Integrates by semi-implicit Euler over `h` seconds: speeds first.
    pub(super) fn advance(&mut self, h: f64, in_parent: &mut InParent) {
        let axes = self.axes_in_body(&in_parent.pose);
        for (speed, rate) in self.speeds.iter_mut().zip(self.rates).take(self.count) {
            *speed += h * rate;
        }
        match self.kind {
            JointModel::Fixed => {}
            JointModel::Spherical | JointModel::Free => {
                let turning = axes.iter().zip(self.speeds).take(3);
                in_parent.spin_rad_s = turning.map(|(axis, speed)| *axis * speed).sum();
                let turn = DQuat::from_scaled_axis(h * in_parent.spin_rad_s);
                in_parent.pose.rotation = (in_parent.pose.rotation * turn).normalize();
                if self.kind == JointModel::Free {
                    in_parent.slide_m_s = DVec3::from_slice(&self.speeds[3..]);
                    in_parent.pose.position_m += h * in_parent.slide_m_s;
                }
            }
            JointModel::Revolute(_) | JointModel::Prismatic(_) | JointModel::Universal(_) => {
                for (coordinate, speed) in self.coordinates.iter_mut().zip(self.speeds) {
                    *coordinate += h * speed;
                }
                *in_parent = self.in_parent();
            }
        }
    }

    /// Returns the pose and velocity of the body relative to its parent, for a joint of one or two axes.
    pub(super) fn in_parent(&self) -> InParent {
        let in_joint = self.kind.motion(&self.coordinates);
        let pose = self.placement.child(in_joint.position_m, in_joint.rotation);
        let moving = |axes: [DVec3; MAX_DOFS]| -> DVec3 {
            axes.iter().zip(self.speeds).map(|(axis, speed)| *axis * speed).sum()
        };
        InParent {
            pose,
            spin_rad_s: moving(self.axes_in_body(&pose)),
            slide_m_s: moving(self.slides_in_parent()),
        }
    }
}
