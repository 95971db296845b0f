//! Reads and writes the coordinates of all joints of a tree.

use core::mem;
use core::ops::Range;

use super::error::{CoordinatesError, check_count, check_numbers};
use super::joint::squared_length_off_unit;
use crate::dynamics::dof_count;
use crate::joint::JointKind;
use crate::joint_states::JointStates;
use crate::joint_targets::JointTargets;
use crate::state::{JointState, check_position};
use crate::transform::{Transform, Twist, Wrench};
use crate::tree::{Body, Tree};

impl<const N: usize> Tree<N> {
    /// Returns the length of `q` (nq): a ball joint has four numbers for three dofs. O(n).
    pub fn coordinate_count(&self) -> usize {
        count(self.bodies(), JointKind::coordinate_count)
    }

    /// Returns the number of dofs of all joints: the length of `qd`, `qdd` and efforts (nv). O(n).
    pub fn dof_count(&self) -> usize {
        dof_count(self.bodies())
    }

    /// Returns the range in `q` of a body's joint; an empty range at the end if there is no such body. O(n): call it
    /// once and keep the result.
    pub fn coordinates(&self, body: usize) -> Range<usize> {
        range(self.bodies(), body, JointKind::coordinate_count)
    }

    /// Returns the range in `qd`, `qdd` and efforts of a body's joint; an empty range at the end if there is no such
    /// body. O(n): call it once and keep the result.
    pub fn dofs(&self, body: usize) -> Range<usize> {
        range(self.bodies(), body, JointKind::dof_count)
    }

    /// Converts accelerations of joints in body axes ([`Workspace::commands`](crate::Workspace::commands),
    /// [`forward_dynamics`](crate::dynamics::forward_dynamics)) to accelerations by dof: `Sᵀ` times each. `joints`
    /// are the states of these joints. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError::Count`], and nothing is written, if a slice does not fit the tree.
    pub fn accelerations(
        &self,
        joints: &[JointState],
        twists: &[Twist],
        qdd: &mut [f32],
    ) -> Result<(), CoordinatesError> {
        let bodies = self.bodies();
        check_count("joints", bodies.len(), joints.len())?;
        check_count("twists", bodies.len(), twists.len())?;
        check_count("qdd", self.dof_count(), qdd.len())?;
        write_components(bodies, joints, twists.iter().copied(), qdd);
        Ok(())
    }

    /// Converts wrenches on bodies in body axes, such as a tick's torques, to efforts by dof (N m, N): `Sᵀ` times
    /// each. `joints` are the measured joint states. The power is unchanged: `effort · qd = wrench · twist`. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError::Count`], and nothing is written, if a slice does not fit the tree.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointKind, JointStates, Transform, Tree, Wrench, glam::Vec3};
    /// # let (parent, placement) = (None, Transform::IDENTITY);
    /// # let joint = JointKind::Revolute { axis: Vec3::X };
    /// # let knee = Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 };
    /// let tree = Tree::<1>::from_bodies(&[knee])?;
    /// let measured = JointStates::rest(&tree);
    /// let wrench = Wrench::new(Vec3::new(3.0, 1.0, 0.0), Vec3::ZERO);
    /// let mut effort = [0.0];
    /// tree.efforts(measured.as_slice(), &[wrench], &mut effort)?;
    /// assert_eq!(effort, [3.0]);
    /// // The inverse omits the part that the bearings carry.
    /// let mut of_drive = [Wrench::ZERO];
    /// tree.wrenches(measured.as_slice(), &effort, &mut of_drive)?;
    /// assert_eq!(of_drive, [Wrench::new(Vec3::X * 3.0, Vec3::ZERO)]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn efforts<W: AsRef<Wrench>>(
        &self,
        joints: &[JointState],
        wrenches: &[W],
        efforts: &mut [f32],
    ) -> Result<(), CoordinatesError> {
        let bodies = self.bodies();
        check_count("joints", bodies.len(), joints.len())?;
        check_count("wrenches", bodies.len(), wrenches.len())?;
        check_count("efforts", self.dof_count(), efforts.len())?;
        let as_twists = wrenches.iter().map(|wrench| wrench.as_ref().as_twist());
        write_components(bodies, joints, as_twists, efforts);
        Ok(())
    }

    /// Converts efforts by dof to wrenches on bodies, in body axes: `S` times each. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`], and nothing is written, if a slice does not fit the tree, or an effort is not a number
    /// from -1e6 to 1e6.
    pub fn wrenches(
        &self,
        joints: &[JointState],
        efforts: &[f32],
        wrenches: &mut [Wrench],
    ) -> Result<(), CoordinatesError> {
        let bodies = self.bodies();
        check_count("joints", bodies.len(), joints.len())?;
        check_count("wrenches", bodies.len(), wrenches.len())?;
        check_numbers("efforts", bodies, JointKind::dof_count, efforts)?;
        let mut rest = efforts;
        for ((body, joint), slot) in bodies.iter().zip(joints).zip(wrenches) {
            let of_joint = take(&mut rest, body.joint.dof_count());
            let in_joint = body.rotation_in_joint(joint.pose.rotation);
            let Twist { angular, linear } = body.joint.twist_along(in_joint, of_joint);
            *slot = Wrench::new(angular, linear);
        }
        Ok(())
    }
}

impl<const N: usize> JointStates<N> {
    /// Sets all joints from their positions and speeds, in the form that encoders give (see
    /// [`coordinates`](crate::coordinates)). O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`], and nothing changes, if a slice or the states do not fit the tree, a number is not from
    /// -1e6 to 1e6, or a quaternion is not unit.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointKind, JointStates, Transform, Tree, glam::Vec3};
    /// # let (parent, placement) = (None, Transform::IDENTITY);
    /// # let joint = JointKind::Prismatic { axis: Vec3::X };
    /// # let slide = Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 };
    /// let tree = Tree::<1>::from_bodies(&[slide])?;
    /// let mut measured = JointStates::rest(&tree);
    /// measured.set_coordinates(&tree, &[0.25], &[2.0])?;
    /// assert_eq!(measured.as_slice()[0].pose.translation_m, Vec3::X * 0.25);
    /// let (mut q, mut qd) = ([0.0], [0.0]);
    /// measured.coordinates(&tree, &mut q, &mut qd)?;
    /// assert_eq!((q, qd), ([0.25], [2.0]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_coordinates(
        &mut self,
        tree: &Tree<N>,
        q: &[f32],
        qd: &[f32],
    ) -> Result<(), CoordinatesError> {
        let bodies = tree.bodies();
        check_count("joints", bodies.len(), self.as_slice().len())?;
        check_state(bodies, q, qd)?;
        for_each_state(bodies, q, qd, |joint, _, state, _| {
            // The joint exists: its count was checked.
            let _ = self.put(joint, state);
        });
        Ok(())
    }

    /// Sets all joints from their positions, with zero speeds: for the first reading of encoders that measure no
    /// speeds. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`], and nothing changes, in the cases of [`Self::set_coordinates`].
    pub fn set_coordinates_at_rest(
        &mut self,
        tree: &Tree<N>,
        q: &[f32],
    ) -> Result<(), CoordinatesError> {
        let bodies = tree.bodies();
        check_count("joints", bodies.len(), self.as_slice().len())?;
        check_positions(bodies, q)?;
        for_each_state(bodies, q, &[], |joint, _, state, _| {
            // The joint exists: its count was checked.
            let _ = self.put(joint, state);
        });
        Ok(())
    }

    /// Sets all joints from newly measured positions, for encoders that measure no speeds. The speeds become the
    /// backward differences from the positions `elapsed_s` earlier. The difference of two angles is the shorter way
    /// around the circle. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`], and nothing changes, in the cases of [`Self::set_coordinates`]; or if the time is not a
    /// positive number (at least 1e-9 s), or a joint is farther than 1e6 m from its parent.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointKind, JointStates, Transform, Tree, glam::Vec3};
    /// # let (parent, placement) = (None, Transform::IDENTITY);
    /// # let joint = JointKind::Revolute { axis: Vec3::X };
    /// # let knee = Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 };
    /// let tree = Tree::<1>::from_bodies(&[knee])?;
    /// let mut measured = JointStates::rest(&tree);
    /// measured.set_coordinates_at_rest(&tree, &[3.1])?;
    /// // The angle passes the end of the encoder's range.
    /// measured.update_coordinates(&tree, &[-3.1], 0.01)?;
    /// let turned_rad = core::f32::consts::TAU - 6.2;
    /// assert!((measured.as_slice()[0].velocity.angular.x - turned_rad / 0.01).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn update_coordinates(
        &mut self,
        tree: &Tree<N>,
        q: &[f32],
        elapsed_s: f32,
    ) -> Result<(), CoordinatesError> {
        let bodies = tree.bodies();
        check_count("joints", bodies.len(), self.as_slice().len())?;
        check_positions(bodies, q)?;
        // The checks above limit positions, but not placements.
        bodies
            .iter()
            .try_for_each(|body| check_position(body.placement.translation_m))
            .map_err(CoordinatesError::Difference)?;
        let rate_hz = self.rate(elapsed_s).map_err(CoordinatesError::Difference)?;
        for_each_state(bodies, q, &[], |joint, _, state, _| {
            self.move_on(joint, state.pose, rate_hz);
        });
        Ok(())
    }

    /// Writes the positions and speeds of all joints. Angles are in [-π, π]. For a pose that the joint cannot reach,
    /// the nearest reachable position is written. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError::Count`], and nothing is written, if a slice or the states do not fit the tree.
    pub fn coordinates(
        &self,
        tree: &Tree<N>,
        q: &mut [f32],
        qd: &mut [f32],
    ) -> Result<(), CoordinatesError> {
        write_state(tree, self.as_slice(), q, qd)
    }
}

impl<const N: usize> JointTargets<N> {
    /// Sets all joints from their positions, speeds and accelerations (see [`coordinates`](crate::coordinates)).
    /// O(n).
    ///
    /// The accelerations are the derivatives of the speeds (except the linear accelerations of a free joint, see
    /// [`coordinates`](crate::coordinates)). The function adds the acceleration due to the moving axes of a universal
    /// joint.
    ///
    /// # Errors
    /// [`CoordinatesError`], and nothing changes, if a slice or the targets do not fit the tree, a number is not from
    /// -1e6 to 1e6, or a quaternion is not unit.
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointKind, JointTargets, Transform, Tree, glam::Vec3};
    /// # let (parent, placement) = (None, Transform::IDENTITY);
    /// # let joint = JointKind::Revolute { axis: Vec3::Z };
    /// # let knee = Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 };
    /// let tree = Tree::<1>::from_bodies(&[knee])?;
    /// let mut targets = JointTargets::rest(&tree);
    /// targets.set_coordinates(&tree, &[0.5], &[1.0], &[-4.0])?;
    /// assert_eq!(targets.accelerations()[0].angular, Vec3::Z * -4.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_coordinates(
        &mut self,
        tree: &Tree<N>,
        q: &[f32],
        qd: &[f32],
        qdd: &[f32],
    ) -> Result<(), CoordinatesError> {
        let bodies = tree.bodies();
        check_count("joints", bodies.len(), self.states().len())?;
        check_state(bodies, q, qd)?;
        check_numbers("qdd", bodies, JointKind::dof_count, qdd)?;
        let mut rest = qdd;
        for_each_state(bodies, q, qd, |joint, body, state, in_joint| {
            let of_joint = take(&mut rest, body.joint.dof_count());
            let bias = body.joint.bias_acceleration(in_joint, state.velocity);
            let acceleration = body.joint.twist_along(in_joint, of_joint) + bias;
            // The joint exists: its count was checked.
            let _ = self.put(joint, state, acceleration);
        });
        Ok(())
    }

    /// Writes the positions, speeds and accelerations of all joints, like [`JointStates::coordinates`]. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError::Count`], and nothing is written, if a slice or the targets do not fit the tree.
    pub fn coordinates(
        &self,
        tree: &Tree<N>,
        q: &mut [f32],
        qd: &mut [f32],
        qdd: &mut [f32],
    ) -> Result<(), CoordinatesError> {
        check_count("qdd", tree.dof_count(), qdd.len())?;
        write_state(tree, self.states(), q, qd)?;
        tree.accelerations(self.states(), self.accelerations(), qdd)
    }
}

fn count(bodies: &[Body], of_joint: impl Fn(JointKind) -> usize) -> usize {
    bodies.iter().map(|body| of_joint(body.joint)).fold(0, usize::saturating_add)
}

fn range(bodies: &[Body], body: usize, of_joint: impl Fn(JointKind) -> usize) -> Range<usize> {
    let (before, from) = bodies.split_at_checked(body).unwrap_or((bodies, &[]));
    let start = count(before, &of_joint);
    start..start.saturating_add(from.first().map_or(0, |body| of_joint(body.joint)))
}

/// Refuses positions and speeds that are not a valid state of the tree.
pub(super) fn check_state(bodies: &[Body], q: &[f32], qd: &[f32]) -> Result<(), CoordinatesError> {
    check_positions(bodies, q)?;
    check_numbers("qd", bodies, JointKind::dof_count, qd)
}

/// Refuses positions that are not valid for the tree.
pub(super) fn check_positions(bodies: &[Body], q: &[f32]) -> Result<(), CoordinatesError> {
    check_numbers("q", bodies, JointKind::coordinate_count, q)?;
    let mut rest = q;
    for (joint, body) in bodies.iter().enumerate() {
        let index = q.len().saturating_sub(rest.len());
        let of_joint = take(&mut rest, body.joint.coordinate_count());
        if let Some(squared) = squared_length_off_unit(of_joint) {
            return Err(CoordinatesError::NotUnit { joint, index, squared });
        }
    }
    Ok(())
}

/// Calls `set` with every joint, its body, its state, and the body's rotation in the joint frame. The numbers must
/// have passed [`check_state`]. Missing speeds count as zero.
pub(super) fn for_each_state(
    bodies: &[Body],
    mut q: &[f32],
    mut qd: &[f32],
    mut set: impl FnMut(usize, &Body, JointState, glam::Quat),
) {
    for (joint, body) in bodies.iter().enumerate() {
        let position = take(&mut q, body.joint.coordinate_count());
        let speed = take(&mut qd, body.joint.dof_count());
        let state = body.joint.state_at(body.placement, position, speed);
        set(joint, body, state, body.rotation_in_joint(state.pose.rotation));
    }
}

/// Writes the positions and speeds of joint states.
fn write_state<const N: usize>(
    tree: &Tree<N>,
    joints: &[JointState],
    mut q: &mut [f32],
    qd: &mut [f32],
) -> Result<(), CoordinatesError> {
    let bodies = tree.bodies();
    check_count("joints", bodies.len(), joints.len())?;
    check_count("q", tree.coordinate_count(), q.len())?;
    check_count("qd", tree.dof_count(), qd.len())?;
    for (body, joint) in bodies.iter().zip(joints) {
        let count = body.joint.coordinate_count();
        let (of_joint, rest) = mem::take(&mut q).split_at_mut_checked(count).unwrap_or_default();
        body.joint.write_position(&in_joint(body, &joint.pose), of_joint);
        q = rest;
    }
    write_components(bodies, joints, joints.iter().map(|joint| joint.velocity), qd);
    Ok(())
}

/// Writes `Sᵀ` times a six-vector of each joint. The slices must fit the tree.
pub(super) fn write_components(
    bodies: &[Body],
    joints: &[JointState],
    twists: impl Iterator<Item = Twist>,
    mut out: &mut [f32],
) {
    for ((body, joint), twist) in bodies.iter().zip(joints).zip(twists) {
        let count = body.joint.dof_count();
        let (of_joint, rest) = mem::take(&mut out).split_at_mut_checked(count).unwrap_or_default();
        body.joint.components(body.rotation_in_joint(joint.pose.rotation), twist, of_joint);
        out = rest;
    }
}

/// Converts a pose from the parent's frame to the joint frame.
pub(super) fn in_joint(body: &Body, pose: &Transform) -> Transform {
    body.placement.inverse() * *pose
}

/// Splits the first `count` numbers off `rest`.
pub(super) fn take<'a>(rest: &mut &'a [f32], count: usize) -> &'a [f32] {
    let (first, behind) = rest.split_at_checked(count).unwrap_or_default();
    *rest = behind;
    first
}
