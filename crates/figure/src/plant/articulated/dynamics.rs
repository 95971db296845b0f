//! Forward dynamics by the articulated-body algorithm (Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter
//! 7), O(n).
//!
//! All quantities are in world axes, each body's about its own joint. Accelerations are the classical
//! accelerations of the joints: the bodies' linear velocities are not needed, and nothing is rotated between
//! bodies.
//!
//! A drive acts on all three rotations of a ball joint. A subtree on a ball joint therefore transmits only a force
//! at the joint to its parent, and the inertia that the parent feels there is a 3x3 matrix. Other joints also
//! transmit the loads on their bearings: three 3x3 matrices.

use glam::DVec3;

use super::articulated_body::Articulated;
use super::bounds::Mode;
use super::joint::{DofResponse, Joint};
use super::spatial::{MAX_DOFS, MotionAxis, World};
use super::tree::{Link, RootMount, Tree};

impl Tree {
    /// Computes the accelerations under the drives, with friction and range ends as they act over `h` seconds.
    pub(super) fn accelerate(&mut self, h: f64) {
        self.pass(h);
        if !self.links.iter().any(|link| link.joint.as_deref().is_some_and(Joint::is_bounded)) {
            return;
        }
        let dofs: usize =
            self.links.iter().filter_map(|link| Some(link.joint.as_ref()?.count)).sum();
        // In the first ten rounds all contradicting modes are changed at once, later only one in each round. The loop
        // ends long before the limit.
        for round in 0..10 + 4 * dofs {
            if !self.agree(h, round < 10) {
                break;
            }
            self.pass(h);
        }
    }

    /// Runs forward dynamics with the present modes.
    fn pass(&mut self, h: f64) {
        for link in &mut self.links {
            link.articulated = Articulated::of_body(
                &link.world,
                link.mass_kg,
                link.first_moment_kg_m,
                link.rotational_kg_m2,
            );
        }
        for index in (1..self.links.len()).rev() {
            let (above, below) = self.links.split_at_mut(index);
            let link = &mut below[0];
            let torque = link.world.axes * link.torque_nm;
            if link.joint.is_some() {
                let passed = link.release_dofs(torque, h);
                if let Some(parent) = link.parent {
                    above[parent].articulated.carry_all(&link.world, &passed);
                }
                continue;
            }
            let (mass, force_bias) = link.articulated.release(torque);
            if let Some(parent) = link.parent {
                above[parent].articulated.carry(&link.world, mass, force_bias, torque);
            }
        }
        self.accelerate_root(h);
        for index in 1..self.links.len() {
            let (above, below) = self.links.split_at_mut(index);
            let link = &mut below[0];
            let World { axes, arm_m, angular_bias_rad_s2, linear_bias_m_s2, .. } = link.world;
            if let Some(parent) = link.parent {
                let parent = &above[parent].articulated;
                if link.joint.is_some() {
                    let at_joint = parent.linear + parent.angular.cross(arm_m);
                    link.follow_dofs(parent.angular, at_joint);
                    continue;
                }
                let linear = parent.linear + parent.angular.cross(arm_m) + linear_bias_m_s2;
                link.articulated.follow(linear);
                let relative = link.articulated.angular - parent.angular - angular_bias_rad_s2;
                link.spin_rate_rad_s2 = axes.transpose() * relative;
            }
        }
    }

    /// Computes the acceleration of the root. Gravity is modelled as an upward acceleration of the world.
    fn accelerate_root(&mut self, h: f64) {
        let root = &mut self.links[0];
        let axes = root.world.axes;
        match self.root {
            RootMount::Fixed => root.articulated.linear = -self.gravity_m_s2,
            RootMount::Driven => {
                let (mass, force_bias) = root.articulated.release(axes * root.torque_nm);
                let linear = mass.inverse() * (axes * self.root_force_n - force_bias);
                root.articulated.follow(linear);
            }
            RootMount::ByJoint => {
                let torque = axes * root.torque_nm;
                if root.joint.is_some() {
                    _ = root.release_dofs(torque, h);
                    root.follow_dofs(DVec3::ZERO, -self.gravity_m_s2);
                } else {
                    _ = root.articulated.release(torque);
                    root.articulated.follow(-self.gravity_m_s2);
                }
            }
        }
        if root.joint.is_none() {
            root.spin_rate_rad_s2 = axes.transpose() * root.articulated.angular;
        }
        self.root_acceleration_m_s2 = root.articulated.linear + self.gravity_m_s2;
    }

    /// Changes the modes that contradict the accelerations: all of them, or only the first. Returns whether a mode
    /// was changed.
    pub(super) fn agree(&mut self, h: f64, all: bool) -> bool {
        let mut changed = false;
        for link in &mut self.links {
            changed |= link.agree(h, all);
            if changed && !all {
                break;
            }
        }
        changed
    }
}

impl Link {
    /// Eliminates the free dofs of the joint. Returns the articulated inertia that the parent feels at the joint,
    /// in terms of the acceleration that the body would have there if it were rigidly attached to the parent.
    fn release_dofs(&mut self, torque: DVec3, h: f64) -> Articulated {
        let Some(joint) = self.joint.as_mut() else { return self.articulated };
        let World { axes, angular_bias_rad_s2, linear_bias_m_s2, .. } = self.world;
        let force = axes * joint.force_n;
        let mut bias = MotionAxis { angular: angular_bias_rad_s2, linear: linear_bias_m_s2 };
        let mut free = [0; MAX_DOFS];
        let mut count = 0;
        for dof in 0..joint.count {
            let bounds = joint.bounds(dof, &self.in_parent.pose, h);
            if let Some(speed) = bounds.held_speed(joint.modes[dof]) {
                joint.rates[dof] = (speed - joint.speeds[dof]) / h;
                bias = bias.plus(joint.motion_axes[dof], joint.rates[dof]);
            } else {
                free[count] = dof;
                count += 1;
            }
        }
        let free = &free[..count];
        let felt = self.articulated.feel(bias);
        let mut inertia = [[0.0; MAX_DOFS]; MAX_DOFS];
        let mut pushed = [MotionAxis::default(); MAX_DOFS];
        let mut efforts = [0.0; MAX_DOFS];
        for (row, dof) in free.iter().enumerate() {
            let at = joint.motion_axes[*dof];
            pushed[row] = self.articulated.push(at);
            for (column, other) in free.iter().enumerate() {
                inertia[row][column] = joint.motion_axes[*other].dot(pushed[row]);
            }
            // The viscous friction is computed at the end of the step, which is stable for any coefficient.
            inertia[row][row] += joint.rotor + h * joint.damping;
            let bounds = joint.bounds(*dof, &self.in_parent.pose, h);
            efforts[row] = at.dot(MotionAxis { angular: torque, linear: force })
                - joint.damping * joint.speeds[*dof]
                + bounds.braking(joint.modes[*dof])
                - at.dot(felt);
        }
        invert(&mut inertia, count);
        let mut passed = self.articulated;
        (passed.torque_bias, passed.force_bias) = (felt.angular, felt.linear);
        let mut response = DofResponse::default();
        for (row, dof) in free.iter().enumerate() {
            let mut dragged = MotionAxis::default();
            let mut alone = 0.0;
            for column in 0..count {
                dragged = dragged.plus(pushed[column], inertia[row][column]);
                alone += inertia[row][column] * efforts[column];
            }
            passed.take(pushed[row], dragged);
            passed.torque_bias += pushed[row].angular * alone;
            passed.force_bias += pushed[row].linear * alone;
            (response.alone[*dof], response.dragged[*dof]) = (alone, dragged);
        }
        joint.response = response;
        passed
    }

    /// Computes the acceleration of a body with released dofs, from its parent's accelerations at the joint.
    fn follow_dofs(&mut self, angular: DVec3, linear: DVec3) {
        let Some(joint) = self.joint.as_mut() else { return };
        let parent = MotionAxis { angular, linear };
        let World { angular_bias_rad_s2, linear_bias_m_s2, .. } = self.world;
        let mut own = MotionAxis::default();
        for dof in 0..joint.count {
            if matches!(joint.modes[dof], Mode::Slide(_)) {
                joint.rates[dof] =
                    joint.response.alone[dof] - joint.response.dragged[dof].dot(parent);
            }
            own = own.plus(joint.motion_axes[dof], joint.rates[dof]);
        }
        self.articulated.angular = angular + angular_bias_rad_s2 + own.angular;
        self.articulated.linear = linear + linear_bias_m_s2 + own.linear;
        let to_body = self.world.axes.transpose();
        // The derivative of the components in body axes includes that of the axes.
        self.spin_rate_rad_s2 = to_body * (own.angular + joint.bias_rad_s2());
        self.slide_rate_m_s2 = to_body * own.linear;
    }

    /// Changes the modes of the joint's dofs that contradict their motion: all of them, or only the first. Returns
    /// whether a mode was changed.
    fn agree(&mut self, h: f64, all: bool) -> bool {
        let Some(joint) = self.joint.as_mut().filter(|joint| joint.is_bounded()) else {
            return false;
        };
        let Articulated { angular, linear, torque_bias, force_bias, .. } = self.articulated;
        let moved = self.articulated.push(MotionAxis { angular, linear });
        let carried =
            MotionAxis { angular: moved.angular + torque_bias, linear: moved.linear + force_bias };
        let axes = self.world.axes;
        let drive = MotionAxis { angular: axes * self.torque_nm, linear: axes * joint.force_n };
        let mut changed = false;
        for dof in 0..joint.count {
            let speed = joint.speeds[dof] + h * joint.rates[dof];
            let at = joint.motion_axes[dof];
            let (borne, driven) = (at.dot(carried), at.dot(drive));
            let effort = borne + joint.rotor * joint.rates[dof] + joint.damping * speed - driven;
            let bounds = joint.bounds(dof, &self.in_parent.pose, h);
            let scale = borne.abs() + driven.abs();
            let mode = bounds.next(joint.modes[dof], speed, effort, scale);
            if mode != joint.modes[dof] {
                joint.modes[dof] = mode;
                changed = true;
                if !all {
                    break;
                }
            }
        }
        changed
    }
}

/// Inverts the leading part of a symmetric, positive definite matrix in place by Gauss-Jordan elimination. A
/// matrix of this kind needs no pivoting.
pub(super) fn invert(m: &mut [[f64; MAX_DOFS]; MAX_DOFS], count: usize) {
    for pivot in 0..count {
        let factor = 1.0 / m[pivot][pivot];
        m[pivot][pivot] = 1.0;
        for slot in m[pivot].iter_mut().take(count) {
            *slot *= factor;
        }
        let pivot_row = m[pivot];
        for row in (0..count).filter(|row| *row != pivot) {
            let factor = std::mem::take(&mut m[row][pivot]);
            for (slot, of_pivot) in m[row].iter_mut().zip(pivot_row).take(count) {
                *slot -= factor * of_pivot;
            }
        }
    }
}
