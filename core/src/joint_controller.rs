//! A controller in joint coordinates: numbers in, efforts out.

use core::fmt;

use glam::Vec3;
use heapless::Vec;

use crate::control::{Gains, GainsError, LimitReason, TorqueLimit};
use crate::controller::{ControllerError, TorqueController, Workspace};
use crate::coordinates::CoordinatesError;
use crate::joint_states::JointStates;
use crate::joint_targets::JointTargets;
use crate::state_error::Method;
use crate::tree::Tree;

/// A controller that holds the joints of a rig at target positions, or moves them along moving targets.
///
/// It contains a [`TorqueController`] with inverse dynamics and `Method::Local`, and owns targets, states and
/// workspace. The caller passes only slices of numbers, in the form that [`coordinates`](crate::coordinates)
/// describes. `q` has nq numbers (rad, m, or a unit quaternion), speeds, accelerations and efforts have nv.
///
/// The torque is `H(q) (q̈ + kp e + kd ė) + C + G`: computed torque (Luh, Walker & Paul, "On-Line Computational Scheme
/// for Mechanical Manipulators", 1980). The error of an angle is the shorter way around the circle. The controller
/// takes up to 532 bytes for each body of the capacity `N`. A tick costs as much as [`TorqueController::tick`] plus
/// the conversion of coordinates.
///
/// ```
/// use sinew_core::{Body, Inertia, JointController, Tree, glam::Vec3};
/// // 2 kg on a level arm of 0.5 m.
/// let weight = Inertia::of_box(2.0, Vec3::X * 0.5, Vec3::ZERO);
/// let arm = Tree::<1>::from_bodies(&[Body::revolute(None, Vec3::Z, Vec3::ZERO, weight)])?;
/// let mut controller = JointController::new(arm, 100.0, &[30.0])?;
/// let mut torques_nm = [0.0];
/// controller.tick(&[0.25], &[0.0], &[0.0], &mut torques_nm)?;
/// // 9.81 N m hold it; 0.25 rad times 100/s² times 0.5 kg m² are 12.5 N m.
/// assert!((torques_nm[0] - 22.31).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct JointController<const N: usize> {
    controller: TorqueController<N>,
    targets: JointTargets<N>,
    measured: JointStates<N>,
    workspace: Workspace<N>,
}

impl<const N: usize> JointController<N> {
    /// Creates the controller of a rig under gravity of 9.81 m/s² along -y of its base. O(n).
    ///
    /// - `kp`: stiffness per unit of inertia of all joints, in 1/s². 200 is firm, 20 is soft. The damping is critical:
    ///   `kd = 2 √kp` in 1/s.
    /// - `limits`: maximum effort of each joint's drive, one number for each body: in N m for a joint that turns,
    ///   in N for a joint that slides, in both units for a free joint. For a joint of several axes, the limit
    ///   bounds the length of the vector. The limit of a fixed joint has no effect. Infinity means no limit.
    ///
    /// # Errors
    /// [`JointControllerError`] if the tree is empty, the stiffness is negative or not finite, the number of limits
    /// is not the number of joints, or a limit is negative or NaN.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointController, JointControllerError, Tree, glam::Vec3};
    /// # let weight = Inertia::of_box(2.0, Vec3::X * 0.5, Vec3::ZERO);
    /// let arm = Tree::<1>::from_bodies(&[Body::revolute(None, Vec3::Z, Vec3::ZERO, weight)])?;
    /// let refused = JointController::new(arm, 100.0, &[-1.0]);
    /// assert_eq!(refused, Err(JointControllerError::Limit { joint: 0, value: -1.0 }));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(tree: Tree<N>, kp: f32, limits: &[f32]) -> Result<Self, JointControllerError> {
        let gains = Gains::critically_damped(kp)?;
        let mut checked: Vec<TorqueLimit, N> = Vec::new();
        for (joint, &value) in limits.iter().enumerate() {
            let limit = TorqueLimit::new(value, value)
                .map_err(|_| JointControllerError::Limit { joint, value })?;
            // A count above the capacity is also above the tree's number of joints.
            if checked.push(limit).is_err() {
                let (expected, found) = (tree.len(), limits.len());
                return Err(ControllerError::Count { expected, found }.into());
            }
        }
        let (targets, measured) = (JointTargets::rest(&tree), JointStates::rest(&tree));
        let controller =
            TorqueController::new(tree, gains, Method::Local)?.with_limits(&checked)?;
        Ok(Self { controller, targets, measured, workspace: Workspace::new() })
    }

    /// Sets gravity, m/s², in the axes of the base.
    ///
    /// # Errors
    /// [`JointControllerError::Controller`] if it is not finite.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointController, Tree, glam::Vec3};
    /// # let weight = Inertia::of_box(2.0, Vec3::X * 0.5, Vec3::ZERO);
    /// let arm = Tree::<1>::from_bodies(&[Body::revolute(None, Vec3::Y, Vec3::ZERO, weight)])?;
    /// // z is up.
    /// let mut controller = JointController::new(arm, 100.0, &[30.0])?.with_gravity(Vec3::Z * -9.81)?;
    /// let mut torques_nm = [0.0];
    /// controller.tick(&[0.0], &[0.0], &[0.0], &mut torques_nm)?;
    /// assert!((torques_nm[0] + 9.81).abs() < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_gravity(self, gravity_m_s2: Vec3) -> Result<Self, JointControllerError> {
        Ok(Self { controller: self.controller.with_gravity(gravity_m_s2)?, ..self })
    }

    /// Sets gains for each joint. O(n).
    ///
    /// # Errors
    /// [`JointControllerError::Controller`] if the number of gains is not the number of joints.
    pub fn with_joint_gains(self, gains: &[Gains]) -> Result<Self, JointControllerError> {
        Ok(Self { controller: self.controller.with_joint_gains(gains)?, ..self })
    }

    /// Writes the efforts that move the joints to target positions and hold them there. O(n).
    ///
    /// `q_target`: target positions. `q`, `qd`: measured positions and speeds. `efforts`: N m or N for each dof, within
    /// the limits.
    ///
    /// # Errors
    /// [`JointTickError`], and nothing is written, if a slice does not fit the tree, a number is outside -1e6 to 1e6 or
    /// NaN, or a quaternion is not unit. The caller must then bring the servos into a safe state.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointController, Tree, glam::Vec3};
    /// # let weight = Inertia::of_box(2.0, Vec3::X * 0.5, Vec3::ZERO);
    /// let arm = Tree::<1>::from_bodies(&[Body::revolute(None, Vec3::Z, Vec3::ZERO, weight)])?;
    /// let mut controller = JointController::new(arm, 100.0, &[30.0])?;
    /// let refused = controller.tick(&[0.25], &[f32::NAN], &[0.0], &mut [0.0]);
    /// assert_eq!(
    ///     refused.expect_err("no such angle").to_string(),
    ///     "measured: q[0], of joint 0, is NaN; it must be a number from -1e6 to 1e6",
    /// );
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn tick(
        &mut self,
        q_target: &[f32],
        q: &[f32],
        qd: &[f32],
        efforts: &mut [f32],
    ) -> Result<(), JointTickError> {
        let zeros = [[0.0; 6]; N];
        let zeros = zeros.as_flattened().get(..self.tree().dof_count()).unwrap_or_default();
        self.follow([q_target, zeros, zeros], q, qd, efforts)
    }

    /// Writes the efforts that move the joints along moving targets. O(n).
    ///
    /// `target`: desired positions, speeds and accelerations. The other arguments are those of [`Self::tick`].
    ///
    /// # Errors
    /// [`JointTickError`], as [`Self::tick`].
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointController, Tree, glam::Vec3};
    /// # let weight = Inertia::of_box(2.0, Vec3::X * 0.5, Vec3::ZERO);
    /// let arm = Tree::<1>::from_bodies(&[Body::revolute(None, Vec3::Z, Vec3::ZERO, weight)])?;
    /// let mut controller = JointController::new(arm, 100.0, &[30.0])?;
    /// let mut torques_nm = [0.0];
    /// controller.follow([&[0.0], &[1.0], &[4.0]], &[0.0], &[1.0], &mut torques_nm)?;
    /// // The arm is at its target: its weight, and 0.5 kg m² times 4 rad/s².
    /// assert!((torques_nm[0] - 11.81).abs() < 1e-5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn follow(
        &mut self,
        target: [&[f32]; 3],
        q: &[f32],
        qd: &[f32],
        efforts: &mut [f32],
    ) -> Result<(), JointTickError> {
        let Self { controller, targets, measured, workspace } = self;
        let tree = controller.tree();
        let [q_target, qd_target, qdd_target] = target;
        targets
            .set_coordinates(tree, q_target, qd_target, qdd_target)
            .map_err(JointTickError::Target)?;
        measured.set_coordinates(tree, q, qd).map_err(JointTickError::Measured)?;
        let wrenches = controller.tick(targets, measured, &[], workspace);
        tree.efforts(measured.as_slice(), wrenches, efforts).map_err(JointTickError::Efforts)
    }

    /// Returns the reason why the last tick limited the effort of a joint, if it did. O(1).
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointController, Tree, control::LimitReason, glam::Vec3};
    /// # let weight = Inertia::of_box(2.0, Vec3::X * 0.5, Vec3::ZERO);
    /// let arm = Tree::<1>::from_bodies(&[Body::revolute(None, Vec3::Z, Vec3::ZERO, weight)])?;
    /// let mut controller = JointController::new(arm, 100.0, &[6.0])?;
    /// let mut torques_nm = [0.0];
    /// controller.tick(&[0.0], &[0.0], &[0.0], &mut torques_nm)?;
    /// assert_eq!((torques_nm, controller.limited(0)), ([6.0], Some(LimitReason::Torque)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn limited(&self, joint: usize) -> Option<LimitReason> {
        self.workspace.torques().get(joint).and_then(|torque| torque.reason)
    }

    /// Returns the rig.
    pub fn tree(&self) -> &Tree<N> {
        self.controller.tree()
    }

    /// Returns the inner torque controller, which has gains, limits and gravity.
    pub fn controller(&self) -> &TorqueController<N> {
        &self.controller
    }
}

/// A reason why a [`JointController`] could not be created.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum JointControllerError {
    /// The stiffness is negative or not finite.
    Gains(GainsError),
    /// The limit of a joint is negative or NaN.
    Limit {
        /// Index of the joint.
        joint: usize,
        /// Limit of the joint, N m or N.
        value: f32,
    },
    /// The tree is empty, the number of limits or gains is not the number of joints, or gravity is not finite.
    Controller(ControllerError),
}

impl fmt::Display for JointControllerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gains(error) => error.fmt(f),
            Self::Limit { joint, value } => write!(
                f,
                "the limit of joint {joint} is {value}; it must be zero or more, or infinity for no limit"
            ),
            Self::Controller(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for JointControllerError {}

impl From<GainsError> for JointControllerError {
    fn from(error: GainsError) -> Self {
        Self::Gains(error)
    }
}

impl From<ControllerError> for JointControllerError {
    fn from(error: ControllerError) -> Self {
        Self::Controller(error)
    }
}

/// A reason why a tick of a [`JointController`] was refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum JointTickError {
    /// The target does not fit the rig.
    Target(CoordinatesError),
    /// The measured state does not fit the rig.
    Measured(CoordinatesError),
    /// The slice of efforts does not have one item for each dof.
    Efforts(CoordinatesError),
}

impl fmt::Display for JointTickError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Target(error) => write!(f, "target: {error}"),
            Self::Measured(error) => write!(f, "measured: {error}"),
            Self::Efforts(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for JointTickError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inertia::Inertia;
    use crate::tree::Body;

    fn arm() -> Tree<3> {
        let inertia = Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04));
        let link = |axis| Body::revolute(None, axis, Vec3::Y * 0.1, inertia);
        Tree::serial_chain(&[Vec3::Y, Vec3::X, Vec3::X].map(link)).unwrap()
    }

    /// Returns the bits to compare. Zeros lose their sign.
    fn bits(numbers: [f32; 3]) -> [u32; 3] {
        numbers.map(|number| (number + 0.0).to_bits())
    }

    #[test]
    fn it_gives_the_efforts_that_its_parts_give() {
        let (target, q, qd) = ([[0.2, -0.4, 0.6]; 3], [0.1, -0.5, 0.7], [0.3, 0.2, -0.1]);
        let mut controller = JointController::new(arm(), 50.0, &[2.0; 3]).unwrap();
        let mut got = [0.0; 3];
        controller.follow(target.each_ref().map(|x| &x[..]), &q, &qd, &mut got).unwrap();

        let limits = [TorqueLimit::new(2.0, 2.0).unwrap(); 3];
        let by_parts =
            TorqueController::new(arm(), Gains::critically_damped(50.0).unwrap(), Method::Local);
        let by_parts = by_parts.unwrap().with_limits(&limits).unwrap();
        let (mut targets, mut measured) = (JointTargets::rest(&arm()), JointStates::rest(&arm()));
        targets.set_coordinates(&arm(), &target[0], &target[1], &target[2]).unwrap();
        measured.set_coordinates(&arm(), &q, &qd).unwrap();
        let mut workspace = Workspace::new();
        let wrenches = by_parts.tick(&mut targets, &measured, &[], &mut workspace);
        let mut expected = [0.0; 3];
        arm().efforts(measured.as_slice(), wrenches, &mut expected).unwrap();
        assert_eq!(bits(got), bits(expected));
    }

    #[test]
    fn what_a_target_asks_for_is_inverse_dynamics() {
        let mut controller = JointController::new(arm(), 50.0, &[f32::INFINITY; 3]).unwrap();
        let (q, qd, qdd) = ([0.1, -0.5, 0.7], [0.3, 0.2, -0.1], [1.0, -2.0, 3.0]);
        let (mut got, mut expected) = ([0.0; 3], [0.0; 3]);
        controller.follow([&q, &qd, &qdd], &q, &qd, &mut got).unwrap();
        arm().inverse_dynamics(&q, &qd, &qdd, &mut expected).unwrap();
        assert_eq!(bits(got), bits(expected));
        controller.tick(&q, &q, &[0.0; 3], &mut got).unwrap();
        arm().gravity(&q, &mut expected).unwrap();
        assert_eq!(bits(got), bits(expected));
    }

    #[test]
    fn every_refusal_has_its_name_and_writes_nothing() {
        use CoordinatesError::Count;
        use JointControllerError as E;
        let new = |kp, limits: &[f32]| JointController::new(arm(), kp, limits).unwrap_err();
        assert_eq!(new(-1.0, &[2.0; 3]), E::Gains(GainsError::Negative("kp")));
        assert!(matches!(new(1.0, &[2.0, f32::NAN, 2.0]), E::Limit { joint: 1, .. }));
        for found in [2, 4] {
            let count = ControllerError::Count { expected: 3, found };
            assert_eq!(new(1.0, &[2.0; 4][..found]), E::Controller(count));
        }
        let empty = JointController::<3>::new(Tree::new(), 1.0, &[]);
        assert_eq!(empty, Err(E::Controller(ControllerError::EmptyTree)));
        let controller = JointController::new(arm(), 1.0, &[2.0; 3]).unwrap();
        let refused = controller.clone().with_gravity(Vec3::NAN);
        assert_eq!(refused, Err(E::Controller(ControllerError::NonFinite("gravity"))));

        let mut controller = controller;
        let mut efforts = [7.0; 3];
        let (name, expected) = ("q", 3);
        let count = Count { name, expected, found: 2 };
        let refused = controller.tick(&[0.0; 2], &[0.0; 3], &[0.0; 3], &mut efforts);
        assert_eq!(refused, Err(JointTickError::Target(count)));
        let refused = controller.tick(&[0.0; 3], &[0.0; 2], &[0.0; 3], &mut efforts);
        assert_eq!(refused, Err(JointTickError::Measured(count)));
        let name = "efforts";
        let refused = controller.tick(&[0.0; 3], &[0.0; 3], &[0.0; 3], &mut efforts[..2]);
        assert_eq!(refused, Err(JointTickError::Efforts(Count { name, expected, found: 2 })));
        let refused = controller.tick(&[0.0, f32::NAN, 0.0], &[0.0; 3], &[0.0; 3], &mut efforts);
        assert!(matches!(
            refused,
            Err(JointTickError::Target(CoordinatesError::Number { joint: 1, .. }))
        ));
        assert_eq!(bits(efforts), bits([7.0; 3]));
    }

    #[test]
    fn its_memory_is_as_documented() {
        let bytes = |more: usize, fewer: usize| (more - fewer) / 4;
        let a_body = bytes(size_of::<JointController<8>>(), size_of::<JointController<4>>());
        assert_eq!(a_body, 532);
    }
}
