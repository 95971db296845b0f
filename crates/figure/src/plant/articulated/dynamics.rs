//! Forward dynamics by the articulated-body algorithm (Featherstone, Rigid Body Dynamics Algorithms, 2008,
//! chapter 7), O(n).
//!
//! All is in world axes, each body about its own joint. Accelerations are the classical ones of the joints, so no
//! linear velocity of bodies enters, and nothing is turned from body to body.
//!
//! A drive acts on all three turns of a ball joint, so a subtree on one passes nothing on to its parent but a force at
//! the joint, and the inertia that the parent feels there is a 3x3 matrix. Other joints pass on what their bearings
//! carry: three such matrices.

use glam::{DMat3, DVec3};

use super::bounds::Mode;
use super::joint::{Joint, WAYS, Way};
use super::tree::{Held, Link, Tree, World};

/// A body with all that hangs on it, as felt at its joint:
/// `torque = A α + B a + torque_bias`, `force = Bᵀ α + M a + force_bias`,
/// with the body's angular acceleration α and its joint's acceleration a.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Articulated {
    /// A.
    rotational: DMat3,
    /// B.
    coupling: DMat3,
    /// M.
    mass: DMat3,
    torque_bias: DVec3,
    force_bias: DVec3,
    /// α if a is zero.
    free: DVec3,
    /// What a takes from α: `A⁻¹ B`.
    dragged: DMat3,
    /// α.
    pub(super) angular: DVec3,
    /// a, less gravity.
    pub(super) linear: DVec3,
}

/// How the ways of a joint answer to the acceleration of its parent there: `rates = alone - dragged · (α, a)`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Answer {
    alone: [f64; WAYS],
    dragged: [Way; WAYS],
}

impl Tree {
    /// Works out the accelerations that the drives make; friction and the ends of ranges as over `h` seconds.
    pub(super) fn accelerate(&mut self, h: f64) {
        self.pass(h);
        if !self.links.iter().any(|link| link.joint.as_deref().is_some_and(Joint::is_bounded)) {
            return;
        }
        let ways: usize =
            self.links.iter().filter_map(|link| Some(link.joint.as_ref()?.count)).sum();
        // All at once as often as helps, then one by one; it ends long before.
        for round in 0..10 + 4 * ways {
            if !self.agree(h, round < 10) {
                break;
            }
            self.pass(h);
        }
    }

    /// Forward dynamics with the modes as they are.
    fn pass(&mut self, h: f64) {
        for link in &mut self.links {
            link.articulated = link.alone();
        }
        for index in (1..self.links.len()).rev() {
            let (above, below) = self.links.split_at_mut(index);
            let link = &mut below[0];
            let torque = link.world.axes * link.torque_nm;
            if link.joint.is_some() {
                let passed = link.release_ways(torque, h);
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
                    link.follow_ways(parent.angular, at_joint);
                    continue;
                }
                let linear = parent.linear + parent.angular.cross(arm_m) + linear_bias_m_s2;
                link.articulated.follow(linear);
                let relative = link.articulated.angular - parent.angular - angular_bias_rad_s2;
                link.spin_rate_rad_s2 = axes.transpose() * relative;
            }
        }
    }

    /// Gravity is an acceleration of the world upwards.
    fn accelerate_root(&mut self, h: f64) {
        let root = &mut self.links[0];
        let axes = root.world.axes;
        match self.root {
            Held::Fixed => root.articulated.linear = -self.gravity_m_s2,
            Held::Driven => {
                let (mass, force_bias) = root.articulated.release(axes * root.torque_nm);
                let linear = mass.inverse() * (axes * self.root_force_n - force_bias);
                root.articulated.follow(linear);
            }
            Held::ByJoint => {
                let torque = axes * root.torque_nm;
                if root.joint.is_some() {
                    _ = root.release_ways(torque, h);
                    root.follow_ways(DVec3::ZERO, -self.gravity_m_s2);
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

    /// Changes modes that do not agree with the accelerations, all or the first; says whether there was one.
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
    /// The body by itself: Newton's and Euler's equations about the joint.
    fn alone(&self) -> Articulated {
        let World { axes, angular_rad_s: angular, .. } = self.world;
        let rotational = axes * self.rotational_kg_m2 * axes.transpose();
        let first_moment = axes * self.first_moment_kg_m;
        Articulated {
            rotational,
            coupling: skew(first_moment),
            mass: DMat3::from_diagonal(DVec3::splat(self.mass_kg)),
            torque_bias: angular.cross(rotational * angular),
            force_bias: angular.cross(angular.cross(first_moment)),
            ..Articulated::default()
        }
    }

    /// Lets the free ways of the joint move. What is left is felt by the parent at the joint, returned: in terms of the
    /// acceleration that the body would have there if it were fast to the parent.
    fn release_ways(&mut self, torque: DVec3, h: f64) -> Articulated {
        let Some(joint) = self.joint.as_mut() else { return self.articulated };
        let World { axes, angular_bias_rad_s2, linear_bias_m_s2, .. } = self.world;
        let force = axes * joint.force_n;
        let mut bias = Way { angular: angular_bias_rad_s2, linear: linear_bias_m_s2 };
        let mut free = [0; WAYS];
        let mut count = 0;
        for way in 0..joint.count {
            let bounds = joint.bounds(way, &self.in_parent.pose, h);
            if let Some(speed) = bounds.held_speed(joint.modes[way]) {
                joint.rates[way] = (speed - joint.speeds[way]) / h;
                bias = bias.plus(joint.ways[way], joint.rates[way]);
            } else {
                free[count] = way;
                count += 1;
            }
        }
        let free = &free[..count];
        let felt = self.articulated.feel(bias);
        let mut inertia = [[0.0; WAYS]; WAYS];
        let mut pushed = [Way::default(); WAYS];
        let mut efforts = [0.0; WAYS];
        for (row, way) in free.iter().enumerate() {
            let at = joint.ways[*way];
            pushed[row] = self.articulated.push(at);
            for (column, other) in free.iter().enumerate() {
                inertia[row][column] = joint.ways[*other].dot(pushed[row]);
            }
            // Viscous friction is that at the end of the step: stable however large it is.
            inertia[row][row] += joint.rotor + h * joint.damping;
            let bounds = joint.bounds(*way, &self.in_parent.pose, h);
            efforts[row] = at.dot(Way { angular: torque, linear: force })
                - joint.damping * joint.speeds[*way]
                + bounds.braking(joint.modes[*way])
                - at.dot(felt);
        }
        invert(&mut inertia, count);
        let mut passed = self.articulated;
        (passed.torque_bias, passed.force_bias) = (felt.angular, felt.linear);
        let mut answer = Answer::default();
        for (row, way) in free.iter().enumerate() {
            let mut dragged = Way::default();
            let mut alone = 0.0;
            for column in 0..count {
                dragged = dragged.plus(pushed[column], inertia[row][column]);
                alone += inertia[row][column] * efforts[column];
            }
            passed.take(pushed[row], dragged);
            passed.torque_bias += pushed[row].angular * alone;
            passed.force_bias += pushed[row].linear * alone;
            (answer.alone[*way], answer.dragged[*way]) = (alone, dragged);
        }
        joint.answer = answer;
        passed
    }

    /// Moves a body whose ways are released with its parent, which has these accelerations at the joint.
    fn follow_ways(&mut self, angular: DVec3, linear: DVec3) {
        let Some(joint) = self.joint.as_mut() else { return };
        let parent = Way { angular, linear };
        let World { angular_bias_rad_s2, linear_bias_m_s2, .. } = self.world;
        let mut own = Way::default();
        for way in 0..joint.count {
            if matches!(joint.modes[way], Mode::Slide(_)) {
                joint.rates[way] = joint.answer.alone[way] - joint.answer.dragged[way].dot(parent);
            }
            own = own.plus(joint.ways[way], joint.rates[way]);
        }
        self.articulated.angular = angular + angular_bias_rad_s2 + own.angular;
        self.articulated.linear = linear + linear_bias_m_s2 + own.linear;
        let to_body = self.world.axes.transpose();
        // The derivative of components: that of the axes as well.
        self.spin_rate_rad_s2 = to_body * (own.angular + joint.bias_rad_s2());
        self.slide_rate_m_s2 = to_body * own.linear;
    }

    /// Changes modes of the joint's ways that do not agree with what they do, all or the first; says whether there was
    /// one.
    fn agree(&mut self, h: f64, all: bool) -> bool {
        let Some(joint) = self.joint.as_mut().filter(|joint| joint.is_bounded()) else {
            return false;
        };
        let Articulated { angular, linear, torque_bias, force_bias, .. } = self.articulated;
        let moved = self.articulated.push(Way { angular, linear });
        let carried =
            Way { angular: moved.angular + torque_bias, linear: moved.linear + force_bias };
        let axes = self.world.axes;
        let drive = Way { angular: axes * self.torque_nm, linear: axes * joint.force_n };
        let mut changed = false;
        for way in 0..joint.count {
            let speed = joint.speeds[way] + h * joint.rates[way];
            let at = joint.ways[way];
            let (borne, driven) = (at.dot(carried), at.dot(drive));
            let effort = borne + joint.rotor * joint.rates[way] + joint.damping * speed - driven;
            let bounds = joint.bounds(way, &self.in_parent.pose, h);
            let scale = borne.abs() + driven.abs();
            let mode = bounds.next(joint.modes[way], speed, effort, scale);
            if mode != joint.modes[way] {
                joint.modes[way] = mode;
                changed = true;
                if !all {
                    break;
                }
            }
        }
        changed
    }
}

impl Articulated {
    /// Lets the joint turn under its torque. What is left is `force = mass a + force_bias`, returned.
    #[inline]
    fn release(&mut self, torque: DVec3) -> (DMat3, DVec3) {
        let inverse = self.rotational.inverse();
        self.free = inverse * (torque - self.torque_bias);
        self.dragged = inverse * self.coupling;
        let back = self.coupling.transpose();
        (self.mass - back * self.dragged, self.force_bias + back * self.free)
    }

    /// Adds a released child: its force at the end of the arm, and the reaction of its torque.
    #[inline]
    fn carry(&mut self, child: &World, mass: DMat3, force_bias: DVec3, torque: DVec3) {
        let force = mass * child.linear_bias_m_s2 + force_bias;
        let coupling = skew_times(child.arm_m, mass);
        self.mass += mass;
        self.coupling += coupling;
        self.rotational += times_skew_transposed(coupling, child.arm_m);
        self.force_bias += force;
        self.torque_bias += torque + child.arm_m.cross(force);
    }

    /// Adds a child that passes on all that its bearings carry.
    fn carry_all(&mut self, child: &World, passed: &Self) {
        let turned = times_skew_transposed(passed.coupling, child.arm_m);
        let coupling = skew_times(child.arm_m, passed.mass);
        self.mass += passed.mass;
        self.coupling += passed.coupling + coupling;
        self.rotational += passed.rotational
            + turned
            + turned.transpose()
            + times_skew_transposed(coupling, child.arm_m);
        self.force_bias += passed.force_bias;
        self.torque_bias += passed.torque_bias + child.arm_m.cross(passed.force_bias);
    }

    /// Moves a released body with its joint.
    #[inline]
    fn follow(&mut self, linear: DVec3) {
        self.linear = linear;
        self.angular = self.free - self.dragged * linear;
    }

    /// Torque and force that an acceleration takes.
    fn push(&self, by: Way) -> Way {
        Way {
            angular: self.rotational * by.angular + self.coupling * by.linear,
            linear: self.coupling.transpose() * by.angular + self.mass * by.linear,
        }
    }

    /// The same with the biases.
    fn feel(&self, by: Way) -> Way {
        let Way { angular, linear } = self.push(by);
        Way { angular: angular + self.torque_bias, linear: linear + self.force_bias }
    }

    /// Takes the product of two columns off.
    fn take(&mut self, a: Way, b: Way) {
        let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
        self.rotational -= outer(a.angular, b.angular);
        self.coupling -= outer(a.angular, b.linear);
        self.mass -= outer(a.linear, b.linear);
    }
}

impl Way {
    fn dot(self, other: Self) -> f64 {
        self.angular.dot(other.angular) + self.linear.dot(other.linear)
    }

    fn plus(self, other: Self, factor: f64) -> Self {
        Self {
            angular: self.angular + other.angular * factor,
            linear: self.linear + other.linear * factor,
        }
    }
}

/// Inverts the leading part of a symmetric, positive definite matrix in place: Gauss and Jordan, which needs no pivots
/// for such.
pub(super) fn invert(m: &mut [[f64; WAYS]; WAYS], count: usize) {
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

/// The matrix of `v ×`.
pub(super) fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}

/// `skew(v) m`, without the products by zero.
#[inline]
fn skew_times(v: DVec3, m: DMat3) -> DMat3 {
    DMat3::from_cols(v.cross(m.x_axis), v.cross(m.y_axis), v.cross(m.z_axis))
}

/// `m skew(v)ᵀ`, without the products by zero.
#[inline]
fn times_skew_transposed(m: DMat3, v: DVec3) -> DMat3 {
    DMat3::from_cols(
        m.z_axis * v.y - m.y_axis * v.z,
        m.x_axis * v.z - m.z_axis * v.x,
        m.y_axis * v.x - m.x_axis * v.y,
    )
}
