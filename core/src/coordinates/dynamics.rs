//! Dynamics of a tree in the coordinates of its joints: numbers in, numbers out.

use glam::Vec3;

use super::error::{CoordinatesError, check_count, check_numbers};
use super::tree::{check_positions, check_state, for_each_state, take, write_components};
use crate::controller::GRAVITY_M_S2;
use crate::dynamics::{
    ArticulatedBody, BodyMotion, CompositeBody, forward_dynamics, inverse_dynamics, mass_matrix,
};
use crate::joint::JointKind;
use crate::state::JointState;
use crate::transform::{Twist, Wrench};
use crate::tree::{Body, Tree};

/// Dynamics in the coordinates of the joints.
///
/// Each function reads and writes slices of numbers, in the form that [`coordinates`](crate::coordinates)
/// describes: `q` with nq numbers (rad, m, or a unit quaternion), `qd`, `qdd` and `tau` with nv (rad/s and m/s,
/// rad/s² and m/s², N m and N). The stack contains scratch memory and the joint states: 136 bytes for each body of
/// the capacity `N` for inverse dynamics and gravity, 424 for forward dynamics, at most 216 for the mass matrix. On a
/// Cortex-M4, trees of 16 bodies take 2.8 kB, 7.1 kB and 3.2 kB in all, in this order. Gravity is [`GRAVITY_M_S2`]:
/// 9.81 m/s² along -y of the base. [`Tree::under_gravity`] sets another gravity.
///
/// Results are finite unless a result or an intermediate number is too large for f32.
impl<const N: usize> Tree<N> {
    /// Writes the efforts `tau` that make the accelerations `qdd` in the state `q`, `qd`:
    /// `tau = H(q) qdd + C(q, qd) + G(q)`. O(n).
    ///
    /// Uses recursive Newton-Euler: see [`dynamics::inverse_dynamics`](crate::dynamics::inverse_dynamics).
    ///
    /// # Errors
    /// [`CoordinatesError`], and nothing is written, if a slice does not fit the tree, a number is NaN or outside -1e6
    /// to 1e6, or a quaternion is not unit.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, Tree, glam::Vec3};
    /// // 2 kg on a level arm of 0.5 m: 9.81 N m hold them, and 0.5 kg m² times 4 rad/s² accelerate them.
    /// let weight = Inertia::of_box(2.0, Vec3::X * 0.5, Vec3::ZERO);
    /// let arm = Tree::<1>::from_bodies(&[Body::revolute(None, Vec3::Z, Vec3::ZERO, weight)])?;
    /// let mut tau = [0.0];
    /// arm.inverse_dynamics(&[0.0], &[0.0], &[4.0], &mut tau)?;
    /// assert!((tau[0] - 11.81).abs() < 1e-5);
    /// // And back.
    /// let mut qdd = [0.0];
    /// arm.forward_dynamics(&[0.0], &[0.0], &tau, &mut qdd)?;
    /// assert!((qdd[0] - 4.0).abs() < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn inverse_dynamics(
        &self,
        q: &[f32],
        qd: &[f32],
        qdd: &[f32],
        tau: &mut [f32],
    ) -> Result<(), CoordinatesError> {
        self.under_gravity(GRAVITY_M_S2).inverse_dynamics(q, qd, qdd, tau)
    }

    /// Writes the accelerations `qdd` that the efforts `tau` make in the state `q`, `qd`. O(n).
    ///
    /// Uses the articulated-body algorithm: see [`dynamics::forward_dynamics`](crate::dynamics::forward_dynamics),
    /// which also explains dofs without inertia. Factors of the mass matrix would instead need nv² numbers on the
    /// stack and O(nv³) operations.
    ///
    /// # Errors
    /// [`CoordinatesError`], as [`Self::inverse_dynamics`].
    pub fn forward_dynamics(
        &self,
        q: &[f32],
        qd: &[f32],
        tau: &[f32],
        qdd: &mut [f32],
    ) -> Result<(), CoordinatesError> {
        self.under_gravity(GRAVITY_M_S2).forward_dynamics(q, qd, tau, qdd)
    }

    /// Writes the efforts `tau` that hold the tree at rest in the pose `q`: `G(q)`. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`], as [`Self::inverse_dynamics`].
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, Tree, glam::Vec3};
    /// let weight = Inertia::of_box(2.0, Vec3::X * 0.5, Vec3::ZERO);
    /// let arm = Tree::<1>::from_bodies(&[Body::revolute(None, Vec3::Z, Vec3::ZERO, weight)])?;
    /// let mut tau = [0.0];
    /// arm.gravity(&[0.0], &mut tau)?;
    /// assert!((tau[0] - 9.81).abs() < 1e-5);
    /// // With z up the axis is vertical, and the bearings carry the weight.
    /// arm.under_gravity(Vec3::Z * -9.81).gravity(&[0.0], &mut tau)?;
    /// assert_eq!(tau, [0.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn gravity(&self, q: &[f32], tau: &mut [f32]) -> Result<(), CoordinatesError> {
        self.under_gravity(GRAVITY_M_S2).gravity(q, tau)
    }

    /// Writes the joint-space mass matrix `H(q)`, in full, row by row (`H` is symmetric to the last bit): nv² numbers
    /// in kg m² between turns, kg between slides, kg m between turns and slides. O(n · depth + nv²).
    ///
    /// Uses the composite-rigid-body algorithm: see [`dynamics::mass_matrix`](crate::dynamics::mass_matrix).
    ///
    /// # Errors
    /// [`CoordinatesError`], as [`Self::inverse_dynamics`]; [`CoordinatesError::Count`] also if `matrix` does not
    /// have nv² items.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, Tree, glam::Vec3};
    /// // A double pendulum of two weights of 1 kg on arms of 0.5 m, in a line.
    /// let weight = Inertia::of_box(1.0, Vec3::X * 0.5, Vec3::ZERO);
    /// let link = |x| Body::revolute(None, Vec3::Z, Vec3::X * x, weight);
    /// let pendulum = Tree::<2>::serial_chain(&[0.0, 0.5].map(link))?;
    /// let mut matrix = [0.0; 4];
    /// pendulum.mass_matrix(&[0.0; 2], &mut matrix)?;
    /// assert_eq!(matrix, [0.25 + 1.0, 0.5, 0.5, 0.25]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn mass_matrix(&self, q: &[f32], matrix: &mut [f32]) -> Result<(), CoordinatesError> {
        let bodies = self.bodies();
        check_positions(bodies, q)?;
        let size = self.dof_count();
        check_count("matrix", size.saturating_mul(size), matrix.len())?;
        let joints = joints::<N>(bodies, q, &[]);
        mass_matrix(bodies, &joints, &mut [CompositeBody::default(); N], matrix);
        Ok(())
    }

    /// Returns the dynamics under another gravity, in m/s² and the axes of the base. O(1).
    ///
    /// Results are not finite if a component of gravity is not finite.
    pub fn under_gravity(&self, gravity_m_s2: Vec3) -> UnderGravity<'_, N> {
        UnderGravity { tree: self, gravity_m_s2 }
    }
}

/// A tree with its own gravity, from [`Tree::under_gravity`].
///
/// ```
/// use sinew_core::{Body, Inertia, Tree, glam::Vec3};
/// let weight = Inertia::of_box(2.0, Vec3::X * 0.5, Vec3::ZERO);
/// let arm = Tree::<1>::from_bodies(&[Body::revolute(None, Vec3::Y, Vec3::ZERO, weight)])?;
/// // z is up: the weight falls, and the arm turns at 9.81 / 0.5.
/// let mut qdd = [0.0];
/// arm.under_gravity(Vec3::Z * -9.81).forward_dynamics(&[0.0], &[0.0], &[0.0], &mut qdd)?;
/// assert!((qdd[0] - 19.62).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnderGravity<'t, const N: usize> {
    tree: &'t Tree<N>,
    gravity_m_s2: Vec3,
}

impl<const N: usize> UnderGravity<'_, N> {
    /// Writes the efforts of a motion, as [`Tree::inverse_dynamics`]. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`], as [`Tree::inverse_dynamics`].
    pub fn inverse_dynamics(
        &self,
        q: &[f32],
        qd: &[f32],
        qdd: &[f32],
        tau: &mut [f32],
    ) -> Result<(), CoordinatesError> {
        let bodies = self.tree.bodies();
        check_state(bodies, q, qd)?;
        check_numbers("qdd", bodies, JointKind::dof_count, qdd)?;
        check_count("tau", self.tree.dof_count(), tau.len())?;
        self.write_efforts(q, qd, qdd, tau);
        Ok(())
    }

    /// Writes the accelerations that efforts make, as [`Tree::forward_dynamics`]. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`], as [`Tree::inverse_dynamics`].
    pub fn forward_dynamics(
        &self,
        q: &[f32],
        qd: &[f32],
        tau: &[f32],
        qdd: &mut [f32],
    ) -> Result<(), CoordinatesError> {
        let bodies = self.tree.bodies();
        check_state(bodies, q, qd)?;
        check_numbers("tau", bodies, JointKind::dof_count, tau)?;
        check_count("qdd", self.tree.dof_count(), qdd.len())?;
        let joints = joints::<N>(bodies, q, qd);
        let mut drives = [Wrench::ZERO; N];
        let mut rest = tau;
        for ((body, joint), slot) in bodies.iter().zip(&joints).zip(&mut drives) {
            let of_joint = take(&mut rest, body.joint.dof_count());
            let in_joint = body.rotation_in_joint(joint.pose.rotation);
            let Twist { angular, linear } = body.joint.twist_along(in_joint, of_joint);
            *slot = Wrench::new(angular, linear);
        }
        let mut accelerations = [Twist::ZERO; N];
        forward_dynamics(
            bodies,
            &joints,
            &drives,
            self.gravity_m_s2,
            &[],
            &mut [ArticulatedBody::default(); N],
            &mut accelerations,
        );
        write_components(bodies, &joints, accelerations.into_iter(), qdd);
        Ok(())
    }

    /// Writes the efforts that hold the tree, as [`Tree::gravity`]. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`], as [`Tree::inverse_dynamics`].
    pub fn gravity(&self, q: &[f32], tau: &mut [f32]) -> Result<(), CoordinatesError> {
        check_positions(self.tree.bodies(), q)?;
        check_count("tau", self.tree.dof_count(), tau.len())?;
        self.write_efforts(q, &[], &[], tau);
        Ok(())
    }

    /// Writes the efforts of a validated motion. Missing speeds and accelerations count as zero.
    fn write_efforts(&self, q: &[f32], qd: &[f32], qdd: &[f32], tau: &mut [f32]) {
        let bodies = self.tree.bodies();
        let joints = joints::<N>(bodies, q, qd);
        let mut accelerations = [Twist::ZERO; N];
        let mut rest = qdd;
        for ((body, joint), slot) in bodies.iter().zip(&joints).zip(&mut accelerations) {
            let of_joint = take(&mut rest, body.joint.dof_count());
            let in_joint = body.rotation_in_joint(joint.pose.rotation);
            let bias = body.joint.bias_acceleration(in_joint, joint.velocity);
            *slot = body.joint.twist_along(in_joint, of_joint) + bias;
        }
        let mut wrenches = [Wrench::ZERO; N];
        inverse_dynamics(
            bodies,
            &joints,
            &accelerations,
            self.gravity_m_s2,
            &[],
            &mut [BodyMotion::default(); N],
            &mut wrenches,
        );
        let as_twists = wrenches.iter().map(|wrench| wrench.as_twist());
        write_components(bodies, &joints, as_twists, tau);
    }
}

/// Returns the states of all joints. The coordinates must have passed the checks. Missing speeds count as zero.
fn joints<const N: usize>(bodies: &[Body], q: &[f32], qd: &[f32]) -> [JointState; N] {
    let mut joints = [JointState::default(); N];
    for_each_state(bodies, q, qd, |joint, _, state, _| {
        if let Some(slot) = joints.get_mut(joint) {
            *slot = state.with_unit_rotation();
        }
    });
    joints
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stack_of_a_body_is_as_documented() {
        let inverse = size_of::<(JointState, Twist, BodyMotion, Wrench)>();
        let forward = size_of::<(JointState, Twist, ArticulatedBody, Wrench)>();
        let matrix = size_of::<(JointState, CompositeBody)>();
        assert_eq!((inverse, forward, matrix), (136, 424, 216));
    }
}
