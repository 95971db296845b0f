//! Commands by dof, split into the parts that a drive may use.

use core::f32::consts::TAU;
use core::mem;

use super::error::{CoordinatesError, check_count};
use super::tree::in_joint;
use crate::control::{ControlLaw, LimitReason};
use crate::controller::{TorqueController, Workspace};
use crate::joint::JointKind;
use crate::joint_states::JointStates;
use crate::joint_targets::JointTargets;
use crate::math;
use crate::state::JointState;
use crate::transform::Wrench;
use crate::tree::Body;

/// The command for one dof: target position and velocity, and the effort in two parts.
///
/// The feed-forward effort and the sum are within the joint's limit. The feedback effort alone may be up to twice the
/// limit. A common [`supply`](crate::supply) reduces the sum, not the feed-forward effort.
///
/// All numbers are finite: a number that is too large for f32 becomes zero.
///
/// A drive uses the parts that its servo supports. With current control, it uses the whole [`Self::effort`]. With
/// position control, it uses the target, and the feed-forward effort divided by the servo's own stiffness; it does
/// not use the feedback, which would close a second loop around the servo's loop. With neither, it uses only the
/// target.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct DofCommand {
    /// Target position. Revolute and universal joints: angle in rad, in [-π, π] (see [`nearest_turn`]). Prismatic
    /// joints: displacement in m. Spherical joints: a component of the rotation vector of the desired pose in the
    /// joint frame, rad. Free joints: a component of the rotation vector, then of the position in the joint frame, m.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub position: f32,
    /// Target velocity along the joint's axis, rad/s or m/s. For spherical and free joints: a component in desired
    /// body axes, which is not the derivative of the rotation vector.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub velocity: f32,
    /// Effort of the desired acceleration at the measured state, including gravity and external wrenches, within the
    /// joint's limit; N m or N. Zero with the PD law.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub feedforward_effort: f32,
    /// Effort that corrects the error: the rest of the tick's effort, after limits and supply; N m or N.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub feedback_effort: f32,
    /// Reason that limited the effort of the joint, or `None`. With [`LimitReason::NotFinite`] and
    /// [`LimitReason::NoRoom`] both efforts are zero.
    pub limited: Option<LimitReason>,
}

impl DofCommand {
    /// Returns the sum of feed-forward and feedback: the effort that the tick gave, within all limits. N m or N.
    pub fn effort(&self) -> f32 {
        self.feedforward_effort + self.feedback_effort
    }
}

/// Adds whole turns to an angle, which brings it nearest to another angle, rad.
///
/// Poses do not count turns, so target angles are in [-π, π]. For a servo with a wider range, pass the middle of its
/// range as `to_rad`. For a servo that turns without end, pass its encoder's reading. If f32 cannot hold the result,
/// the function returns `angle_rad`.
///
/// ```
/// use sinew_core::{coordinates::nearest_turn, math::PI};
/// // A range from 0 to 270 degrees.
/// let (target, middle) = (-2.0, 0.75 * PI);
/// assert!((nearest_turn(target, middle) - (2.0 * PI - 2.0)).abs() < 1e-6);
/// ```
pub fn nearest_turn(angle_rad: f32, to_rad: f32) -> f32 {
    let turned_rad = angle_rad + math::round((to_rad - angle_rad) / TAU) * TAU;
    if turned_rad.is_finite() { turned_rad } else { angle_rad }
}

impl<const N: usize> TorqueController<N> {
    /// Writes the command for each dof, after a tick with the same targets, measurements, external wrenches and
    /// workspace. A [`supply`](crate::supply) may have changed the tick's torques in between. O(n), about the cost
    /// of a tick: call it only for drives that need more than [`Tree::efforts`](crate::Tree::efforts).
    ///
    /// Feed-forward is inverse dynamics of the targets' accelerations (including an observer's addition), for every
    /// method.
    ///
    /// # Errors
    /// [`CoordinatesError::Count`], and nothing is written, if targets or measurements are not for the tree's number of
    /// joints, or the length of `out` is not the number of dofs.
    ///
    /// ```
    /// use sinew_core::coordinates::DofCommand;
    /// use sinew_core::{TorqueController, JointStates, JointTargets, Workspace};
    /// use sinew_core::{control::Gains, glam::Vec3, state_error::Method};
    /// # use sinew_core::{Body, Inertia, JointKind, RotationalInertia, Transform, Tree};
    /// # let inertia = Inertia {
    /// #     mass_kg: 2.0,
    /// #     center_of_mass_m: Vec3::X * 0.5,
    /// #     rotational_kg_m2: RotationalInertia::default(),
    /// # };
    /// # let joint = JointKind::Revolute { axis: Vec3::Z };
    /// # let level_arm = Body { parent: None, joint, placement: Transform::IDENTITY, inertia, rotor_inertia: 0.0 };
    /// let tree = Tree::<1>::from_bodies(&[level_arm])?;
    /// let (mut targets, measured) = (JointTargets::rest(&tree), JointStates::rest(&tree));
    /// targets.set_coordinates(&tree, &[0.25], &[0.0], &[0.0])?;
    /// let controller = TorqueController::new(tree, Gains::new(100.0, 20.0)?, Method::Local)?;
    /// let mut workspace = Workspace::new();
    /// controller.tick(&mut targets, &measured, &[], &mut workspace);
    /// let mut commands = [DofCommand::default()];
    /// controller.dof_commands(&targets, &measured, &[], &mut workspace, &mut commands)?;
    /// // 2 kg on a level arm of 0.5 m weigh 9.81 N m; 0.25 rad times 100/s² times 0.5 kg m² are 12.5 N m.
    /// let [arm] = commands;
    /// assert!((arm.position - 0.25).abs() < 1e-6);
    /// assert!((arm.feedforward_effort - 9.81).abs() < 1e-4);
    /// assert!((arm.feedback_effort - 12.5).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn dof_commands<const R: usize>(
        &self,
        targets: &JointTargets<N>,
        measured: &JointStates<N>,
        external: &[Wrench],
        workspace: &mut Workspace<N, R>,
        out: &mut [DofCommand],
    ) -> Result<(), CoordinatesError> {
        let tree = self.tree();
        for joints in [targets.states(), measured.as_slice()] {
            check_count("joints", tree.len(), joints.len())?;
        }
        check_count("out", tree.dof_count(), out.len())?;
        let mut feedforward = [Wrench::ZERO; N];
        if self.law() == ControlLaw::InverseDynamics {
            self.feedforward_wrenches(targets, measured, external, workspace, &mut feedforward);
        }
        let mut rest = out;
        for ((body, (desired, measured)), (torque, feedforward)) in tree
            .bodies()
            .iter()
            .zip(targets.states().iter().zip(measured.as_slice()))
            .zip(workspace.torques().iter().zip(feedforward))
        {
            let count = body.joint.dof_count();
            let (of_joint, behind) =
                mem::take(&mut rest).split_at_mut_checked(count).unwrap_or_default();
            rest = behind;
            let nothing =
                matches!(torque.reason, Some(LimitReason::NotFinite | LimitReason::NoRoom));
            let feedforward = if nothing { Wrench::ZERO } else { feedforward };
            let [mut velocity, mut effort, mut of_model] = [[0.0; 6]; 3];
            let of_desired = body.rotation_in_joint(desired.pose.rotation);
            let of_measured = body.rotation_in_joint(measured.pose.rotation);
            body.joint.components(of_desired, desired.velocity, &mut velocity);
            body.joint.components(of_measured, torque.value.as_twist(), &mut effort);
            body.joint.components(of_measured, feedforward.as_twist(), &mut of_model);
            let numbers =
                position(body, desired).into_iter().zip(velocity).zip(effort).zip(of_model);
            for (slot, (((position, velocity), effort), feedforward_effort)) in
                of_joint.iter_mut().zip(numbers)
            {
                let feedforward_effort = finite(feedforward_effort);
                *slot = DofCommand {
                    position: finite(position),
                    velocity: finite(velocity),
                    feedforward_effort,
                    feedback_effort: finite(effort - feedforward_effort),
                    limited: torque.reason,
                };
            }
        }
        Ok(())
    }
}

/// Returns the number, or zero if it is not finite.
fn finite(number: f32) -> f32 {
    if number.is_finite() { number } else { 0.0 }
}

/// Returns the target position of each dof, followed by zeros.
fn position(body: &Body, desired: &JointState) -> [f32; 6] {
    let in_joint = in_joint(body, &desired.pose);
    match body.joint {
        JointKind::Spherical | JointKind::Free => {
            let [a, b, c] = math::log(in_joint.rotation).to_array();
            let [x, y, z] = in_joint.translation_m.to_array();
            [a, b, c, x, y, z]
        }
        joint => {
            let [a, b] = joint.along(&in_joint);
            [a, b, 0.0, 0.0, 0.0, 0.0]
        }
    }
}
