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

use super::articulated_body::{Articulated, ArticulatedLanes};
use super::bounds::Mode;
use super::joint::{DofResponse, Joint};
use super::spatial::{MAX_DOFS, MotionAxis, World};
use super::tree::{Link, RootMount, Tree};

impl<const L: usize> Tree<L> {
    /// Computes the accelerations under the drives, with friction and range ends as they act over `h` seconds.
    #[inline(always)]
    pub(super) fn accelerate(&mut self, h: f64) {
        self.pass(h);
        if self.links.iter().any(|link| link.joints().iter().any(Joint::is_bounded)) {
            self.settle(h);
        }
    }

    /// Repeats forward dynamics until all modes agree with the accelerations. A mechanism whose modes agree is not
    /// changed by the repetitions for the others.
    #[inline(never)]
    fn settle(&mut self, h: f64) {
        let dofs: usize =
            self.links.iter().filter_map(|link| Some(link.joints().first()?.count)).sum();
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
    #[inline(always)]
    fn pass(&mut self, h: f64) {
        for link in &mut self.links {
            for lane in 0..L {
                let alone = Articulated::of_body(
                    &link.world.at(lane),
                    link.mass_kg[lane],
                    link.first_moment_kg_m.at(lane),
                    link.rotational_kg_m2.at(lane),
                );
                link.articulated.set(lane, &alone);
            }
        }
        for index in (1..self.links.len()).rev() {
            let (above, below) = self.links.split_at_mut(index);
            let link = &mut below[0];
            let Some(parent) = link.parent else { continue };
            let mut shares = ArticulatedLanes::ZERO;
            if link.joints.is_some() {
                for lane in 0..L {
                    let passed = link.release_dofs(lane, h);
                    shares.set(lane, &passed.share_of_all(&link.world.at(lane)));
                }
            } else {
                let Link { articulated, world, torque_nm, released, .. } = link;
                articulated.release(released, &mut shares, world, torque_nm);
            }
            above[parent].articulated.add(&shares);
        }
        self.accelerate_root(h);
        for index in 1..self.links.len() {
            let (above, below) = self.links.split_at_mut(index);
            let link = &mut below[0];
            let Some(parent) = link.parent else { continue };
            // A copy, which overlaps nothing.
            let parent = above[parent].acceleration;
            if link.joints.is_some() {
                for lane in 0..L {
                    let MotionAxis { angular, linear } = parent.at(lane);
                    let linear = linear + angular.cross(link.world.arm_m.at(lane));
                    link.follow_dofs(lane, MotionAxis { angular, linear });
                }
                continue;
            }
            for lane in 0..L {
                let World { axes, arm_m, angular_bias_rad_s2, linear_bias_m_s2, .. } =
                    link.world.at(lane);
                let parent = parent.at(lane);
                let linear = parent.linear + parent.angular.cross(arm_m) + linear_bias_m_s2;
                let angular = link.released.follow(lane, linear);
                link.acceleration.set(lane, MotionAxis { angular, linear });
                let relative = angular - parent.angular - angular_bias_rad_s2;
                link.spin_rate_rad_s2.set(lane, axes.transpose() * relative);
            }
        }
    }

    /// Computes the acceleration of the root. Gravity is modelled as an upward acceleration of the world.
    #[inline(always)]
    fn accelerate_root(&mut self, h: f64) {
        let root = &mut self.links[0];
        let up = -self.gravity_m_s2;
        if root.joints.is_some() {
            for lane in 0..L {
                _ = root.release_dofs(lane, h);
                root.follow_dofs(lane, MotionAxis { angular: DVec3::ZERO, linear: up });
            }
        } else {
            for lane in 0..L {
                let axes = root.world.axes.at(lane);
                let torque = axes * root.torque_nm.at(lane);
                let (angular, linear) = match self.root {
                    RootMount::Fixed => (DVec3::ZERO, up),
                    RootMount::Driven => {
                        let released = root.articulated.at(lane).release(torque);
                        let force = axes * self.root_force_n.at(lane) - released.force_bias;
                        let linear = released.mass.inverse() * force;
                        (released.follow(linear), linear)
                    }
                    RootMount::ByJoint => {
                        (root.articulated.at(lane).release(torque).follow(up), up)
                    }
                };
                root.acceleration.set(lane, MotionAxis { angular, linear });
                root.spin_rate_rad_s2.set(lane, axes.transpose() * angular);
            }
        }
        for lane in 0..L {
            let linear = root.acceleration.at(lane).linear;
            self.root_acceleration_m_s2.set(lane, linear + self.gravity_m_s2);
        }
    }

    /// Changes the modes that contradict the accelerations, in each mechanism all of them, or only the first. Returns
    /// whether a mode was changed.
    pub(super) fn agree(&mut self, h: f64, all: bool) -> bool {
        let mut changed = [false; L];
        for link in &mut self.links {
            for (lane, changed) in changed.iter_mut().enumerate() {
                if all || !*changed {
                    *changed |= link.agree(lane, h, all);
                }
            }
        }
        changed.contains(&true)
    }
}

impl<const L: usize> Link<L> {
    /// Eliminates the free dofs of the joint. Returns the articulated inertia that the parent feels at the joint,
    /// in terms of the acceleration that the body would have there if it were rigidly attached to the parent.
    fn release_dofs(&mut self, lane: usize, h: f64) -> Articulated {
        let articulated = self.articulated.at(lane);
        let in_parent = self.in_parent.at(lane).pose;
        let World { axes, angular_bias_rad_s2, linear_bias_m_s2, .. } = self.world.at(lane);
        let torque = axes * self.torque_nm.at(lane);
        let Some(joint) = self.joint_mut(lane) else { return articulated };
        let force = axes * joint.force_n;
        let mut bias = MotionAxis { angular: angular_bias_rad_s2, linear: linear_bias_m_s2 };
        let mut free = [0; MAX_DOFS];
        let mut count = 0;
        for dof in 0..joint.count {
            let bounds = joint.bounds(dof, &in_parent, h);
            if let Some(speed) = bounds.held_speed(joint.modes[dof]) {
                joint.rates[dof] = (speed - joint.speeds[dof]) / h;
                bias = bias.plus(joint.motion_axes[dof], joint.rates[dof]);
            } else {
                free[count] = dof;
                count += 1;
            }
        }
        let free = &free[..count];
        let felt = articulated.feel(bias);
        let mut inertia = [[0.0; MAX_DOFS]; MAX_DOFS];
        let mut pushed = [MotionAxis::default(); MAX_DOFS];
        let mut efforts = [0.0; MAX_DOFS];
        for (row, dof) in free.iter().enumerate() {
            let at = joint.motion_axes[*dof];
            pushed[row] = articulated.push(at);
            for (column, other) in free.iter().enumerate() {
                inertia[row][column] = joint.motion_axes[*other].dot(pushed[row]);
            }
            // The viscous friction is computed at the end of the step, which is stable for any coefficient.
            inertia[row][row] += joint.rotor + h * joint.damping;
            let bounds = joint.bounds(*dof, &in_parent, h);
            efforts[row] = at.dot(MotionAxis { angular: torque, linear: force })
                - joint.damping * joint.speeds[*dof]
                + bounds.braking(joint.modes[*dof])
                - at.dot(felt);
        }
        invert(&mut inertia, count);
        let mut passed = articulated;
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
    fn follow_dofs(&mut self, lane: usize, parent: MotionAxis) {
        let World { axes, angular_bias_rad_s2, linear_bias_m_s2, .. } = self.world.at(lane);
        let Some(joint) = self.joint_mut(lane) else { return };
        let mut own = MotionAxis::default();
        for dof in 0..joint.count {
            if matches!(joint.modes[dof], Mode::Slide(_)) {
                joint.rates[dof] =
                    joint.response.alone[dof] - joint.response.dragged[dof].dot(parent);
            }
            own = own.plus(joint.motion_axes[dof], joint.rates[dof]);
        }
        let to_body = axes.transpose();
        // The derivative of the components in body axes includes that of the axes.
        let spin_rate_rad_s2 = to_body * (own.angular + joint.bias_rad_s2());
        let acceleration = MotionAxis {
            angular: parent.angular + angular_bias_rad_s2 + own.angular,
            linear: parent.linear + linear_bias_m_s2 + own.linear,
        };
        self.acceleration.set(lane, acceleration);
        self.spin_rate_rad_s2.set(lane, spin_rate_rad_s2);
        self.slide_rate_m_s2.set(lane, to_body * own.linear);
    }

    /// Changes the modes of the joint's dofs that contradict their motion: all of them, or only the first. Returns
    /// whether a mode was changed.
    fn agree(&mut self, lane: usize, h: f64, all: bool) -> bool {
        let carried = self.articulated.at(lane).feel(self.acceleration.at(lane));
        let in_parent = self.in_parent.at(lane).pose;
        let axes = self.world.axes.at(lane);
        let torque = axes * self.torque_nm.at(lane);
        let Some(joint) = self.joint_mut(lane).filter(|joint| joint.is_bounded()) else {
            return false;
        };
        let drive = MotionAxis { angular: torque, linear: axes * joint.force_n };
        let mut changed = false;
        for dof in 0..joint.count {
            let speed = joint.speeds[dof] + h * joint.rates[dof];
            let at = joint.motion_axes[dof];
            let (borne, driven) = (at.dot(carried), at.dot(drive));
            let effort = borne + joint.rotor * joint.rates[dof] + joint.damping * speed - driven;
            let bounds = joint.bounds(dof, &in_parent, h);
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
