//! One control tick: targets and measurements in, limited torques out.

use core::fmt;

use glam::{Quat, Vec3};
use heapless::Vec;

use crate::body_weight::{BodyWeights, BodyWeightsError};
use crate::control::{ControlLaw, Gains, Limited, TorqueLimit, commanded_acceleration};
use crate::dynamics::{
    BodyMotion, ReflectedInertia, Resolved, inverse_dynamics, resolved_acceleration,
};
use crate::fixed;
use crate::kinematics;
use crate::state::{BodyState, JointState, JointStates, JointTargets};
use crate::state_error::{
    self, AimStatus, Aims, AimsError, Method, References, ReferencesError, StateError,
};
use crate::transform::{Motion, Wrench};
use crate::tree::Tree;

/// A tracking controller for one rig.
///
/// It holds what does not change from tick to tick; everything else is an argument or lives in the
/// caller's [`Workspace`]. Firmware and simulator call the same [`Controller::tick`].
///
/// ```
/// use sinew_core::{Body, Controller, Inertia, JointKind, JointStates, JointTargets, Motion};
/// use sinew_core::{RotationalInertia, Transform, Tree, Workspace};
/// use sinew_core::{control::Gains, glam::Vec3, math, state_error::Method};
/// let pendulum = Body {
///     parent: None,
///     joint: JointKind::Revolute { axis: Vec3::Z },
///     placement: Transform::IDENTITY,
///     inertia: Inertia {
///         mass_kg: 1.0,
///         center_of_mass_m: Vec3::new(0.0, -0.4, 0.0),
///         rotational_kg_m2: RotationalInertia::default(),
///     },
/// };
/// let tree = Tree::<1>::from_bodies(&[pendulum])?;
/// let mut target = JointTargets::rest(&tree);
/// let state = pendulum.joint.state(pendulum.placement, &[0.1], &[0.0])?;
/// target.set(0, state, Motion::ZERO)?;
/// let measured = JointStates::rest(&tree);
///
/// let controller = Controller::new(tree, Gains::critically_damped(200.0)?, Method::World)?;
/// let mut workspace = Workspace::new();
/// let torques = controller.tick(&target, &measured, &[], &mut workspace);
/// // Inertia 1 kg * (0.4 m)², accelerated by kp * 0.1 rad = 20 rad/s².
/// assert!((torques[0].value.moment_nm.z - 3.2).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Controller<const N: usize> {
    tree: Tree<N>,
    gains: Vec<Gains, N>,
    method: Method<N>,
    law: ControlLaw,
    gravity_m_s2: Vec3,
    limits: Vec<TorqueLimit, N>,
    /// By joint, or none at all.
    inertias: Vec<ReflectedInertia, N>,
}

impl<const N: usize> Controller<N> {
    /// A controller with the same gains for all joints, inverse dynamics, gravity of 9.81 m/s² along -y and
    /// no torque limits.
    ///
    /// # Errors
    /// [`ControllerError`] if the tree is empty or the method was made for another tree.
    pub fn new(tree: Tree<N>, gains: Gains, method: Method<N>) -> Result<Self, ControllerError> {
        if tree.is_empty() {
            return Err(ControllerError::EmptyTree);
        }
        match &method {
            Method::Local | Method::World => {}
            Method::Accumulated(references) => {
                References::new(&tree, references.as_slice())
                    .map_err(ControllerError::References)?;
            }
            Method::LinearCompensation { aims, settings } => {
                if !settings.beta.is_finite() {
                    return Err(ControllerError::NonFinite("beta"));
                }
                Aims::new(&tree, aims.as_slice()).map_err(ControllerError::Aims)?;
            }
            Method::ResolvedAcceleration { weights } => {
                BodyWeights::new(&tree, weights.as_slice()).map_err(ControllerError::Weights)?;
            }
        }
        let gains = fixed::collect(tree.bodies().iter().map(|_| gains));
        let limits = fixed::collect(tree.bodies().iter().map(|_| TorqueLimit::NONE));
        let gravity_m_s2 = Vec3::new(0.0, -9.81, 0.0);
        let (law, inertias) = (ControlLaw::default(), Vec::new());
        Ok(Self { tree, gains, method, law, gravity_m_s2, limits, inertias })
    }

    /// The same controller with another control law.
    ///
    /// # Errors
    /// [`ControllerError::Law`] if the method needs inverse dynamics.
    pub fn with_law(self, law: ControlLaw) -> Result<Self, ControllerError> {
        let resolved = matches!(self.method, Method::ResolvedAcceleration { .. });
        if resolved && law != ControlLaw::InverseDynamics {
            return Err(ControllerError::Law);
        }
        Ok(Self { law, ..self })
    }

    /// The same controller in another field of gravity, world axes.
    ///
    /// # Errors
    /// [`ControllerError::NonFinite`].
    pub fn with_gravity(self, gravity_m_s2: Vec3) -> Result<Self, ControllerError> {
        if !gravity_m_s2.is_finite() {
            return Err(ControllerError::NonFinite("gravity"));
        }
        Ok(Self { gravity_m_s2, ..self })
    }

    /// The same controller with gains of their own for each joint.
    ///
    /// # Errors
    /// [`ControllerError::GainsCount`] if there are not as many as joints.
    pub fn with_joint_gains(self, gains: &[Gains]) -> Result<Self, ControllerError> {
        if gains.len() != self.tree.len() {
            let (expected, found) = (self.tree.len(), gains.len());
            return Err(ControllerError::GainsCount { expected, found });
        }
        Ok(Self { gains: fixed::collect(gains.iter().copied()), ..self })
    }

    /// The same controller with a torque limit for each joint.
    ///
    /// # Errors
    /// [`ControllerError::Count`] if there is not one for each joint.
    pub fn with_limits(self, limits: &[TorqueLimit]) -> Result<Self, ControllerError> {
        if limits.len() != self.tree.len() {
            return Err(ControllerError::Count { expected: self.tree.len(), found: limits.len() });
        }
        Ok(Self { limits: fixed::collect(limits.iter().copied()), ..self })
    }

    /// The same controller with the PD law, its gains per unit of inertia (1/s² and 1/s): the torque of a joint
    /// is what these gains ask for, times the joint's own constant inertia (see
    /// [`reflected_inertia`](crate::dynamics::reflected_inertia)).
    ///
    /// Joints move each other, so the damping that a period allows is less than that of one joint alone:
    /// `kv dt_s` must be below 1 / λ, λ the largest eigenvalue of the inverse mass matrix times these inertias.
    ///
    /// # Errors
    /// [`ControllerError::InertiaCount`] if there is not one for each joint, [`ControllerError::NonFinite`] if one
    /// is not finite, [`ControllerError::Law`] if the method needs inverse dynamics.
    pub fn with_pd_of_inertia(
        self,
        inertias: &[ReflectedInertia],
    ) -> Result<Self, ControllerError> {
        if inertias.len() != self.tree.len() {
            let (expected, found) = (self.tree.len(), inertias.len());
            return Err(ControllerError::InertiaCount { expected, found });
        }
        if !inertias.iter().all(ReflectedInertia::is_finite) {
            return Err(ControllerError::NonFinite("inertia"));
        }
        let inertias = fixed::collect(inertias.iter().copied());
        Self { inertias, ..self }.with_law(ControlLaw::ProportionalDerivative)
    }

    /// The rig.
    pub fn tree(&self) -> &Tree<N> {
        &self.tree
    }

    /// The gains by joint.
    pub fn gains(&self) -> &[Gains] {
        &self.gains
    }

    /// The state error that is tracked.
    pub fn method(&self) -> &Method<N> {
        &self.method
    }

    /// How errors become torques.
    pub fn law(&self) -> ControlLaw {
        self.law
    }

    /// The field of gravity, world axes.
    pub fn gravity_m_s2(&self) -> Vec3 {
        self.gravity_m_s2
    }

    /// The torque limits by joint.
    pub fn limits(&self) -> &[TorqueLimit] {
        &self.limits
    }

    /// The inertias by joint that [`Self::with_pd_of_inertia`] was given; empty without.
    pub fn inertias(&self) -> &[ReflectedInertia] {
        &self.inertias
    }

    /// Torques for this instant: the wrench that joint i's drive puts on body i about its origin, in
    /// measured body axes, along the joint's degrees of freedom, within its limit. O(n).
    ///
    /// Cannot fail: the inputs are finite by their types, and what would overflow all the same is returned
    /// as zero with a reason. `external` is the wrench on each body from outside (see
    /// [`inverse_dynamics`]); empty for none. Targets and measurements must be of this controller's tree:
    /// joints that they do not have get no torque and are not in the result.
    pub fn tick<'w>(
        &self,
        targets: &JointTargets<N>,
        measured: &JointStates<N>,
        external: &[Wrench],
        workspace: &'w mut Workspace<N>,
    ) -> &'w [Limited<Wrench>] {
        let bodies = self.tree.bodies();
        let (desired, measured) = (targets.states(), measured.as_slice());
        let count = bodies.len().min(desired.len()).min(measured.len());
        let w = workspace;

        // Local errors need no world states: they are the joints' own.
        if !matches!(self.method, Method::Local) {
            kinematics::body_states(bodies, measured, &mut w.measured);
            kinematics::body_states(bodies, desired, &mut w.desired);
        }
        match &self.method {
            Method::Local => state_error::local(desired, measured, &mut w.errors),
            Method::World | Method::ResolvedAcceleration { .. } => {
                state_error::world(&w.desired, &w.measured, &mut w.errors);
            }
            Method::Accumulated(references) => state_error::accumulated(
                references.as_slice(),
                &w.desired,
                &w.measured,
                &mut w.errors,
            ),
            Method::LinearCompensation { aims, settings } => state_error::linear_compensation(
                aims.as_slice(),
                *settings,
                &w.desired,
                &w.measured,
                &mut w.errors,
                &mut w.aim_status,
            ),
        }

        match &self.method {
            Method::ResolvedAcceleration { weights } => {
                self.resolved_commands(targets, measured, weights, w);
            }
            _ => self.direct_commands(targets, measured, w),
        }

        match self.law {
            ControlLaw::ProportionalDerivative if self.inertias.is_empty() => {
                for (command, wrench) in w.commands.iter().zip(&mut w.wrenches) {
                    *wrench = Wrench::new(command.angular, command.linear);
                }
            }
            ControlLaw::ProportionalDerivative => {
                for ((command, inertia), wrench) in
                    w.commands.iter().zip(&self.inertias).zip(&mut w.wrenches)
                {
                    *wrench = inertia.wrench(*command);
                }
            }
            ControlLaw::InverseDynamics => inverse_dynamics(
                bodies,
                measured,
                &w.commands,
                self.gravity_m_s2,
                external,
                &mut w.scratch,
                &mut w.wrenches,
            ),
        }

        for ((((body, measured), wrench), limit), torque) in
            bodies.iter().zip(measured).zip(&w.wrenches).zip(&self.limits).zip(&mut w.torques)
        {
            let in_joint = body.placement.rotation.conjugate() * measured.pose.rotation;
            *torque = limit.apply(body.joint.project_wrench(in_joint, *wrench));
        }
        w.torques.get(..count).unwrap_or_default()
    }

    /// Feeds every error to its own joint, as it is: eq. (11).
    fn direct_commands(
        &self,
        targets: &JointTargets<N>,
        measured: &[JointState],
        w: &mut Workspace<N>,
    ) {
        for (joint, ((((body, desired), measured), feedforward), ((error, gains), command))) in self
            .tree
            .bodies()
            .iter()
            .zip(targets.states())
            .zip(measured)
            .zip(targets.accelerations())
            .zip(w.errors.iter().zip(&self.gains).zip(&mut w.commands))
            .enumerate()
        {
            let correction = gains.apply(error);
            let to_body = self.error_axes_to_body(joint, measured.pose.rotation, &w.measured);
            let in_joint = body.placement.rotation.conjugate() * measured.pose.rotation;
            *command = match self.law {
                ControlLaw::ProportionalDerivative => {
                    body.joint.project_motion(in_joint, correction.rotated(to_body))
                }
                ControlLaw::InverseDynamics => {
                    let wanted = commanded_acceleration(
                        desired,
                        measured,
                        *feedforward,
                        correction,
                        to_body,
                    );
                    body.joint.project_motion(in_joint, wanted)
                        + body.joint.bias_acceleration(in_joint, measured.velocity)
                }
            };
        }
    }

    /// Feeds every error to its body's acceleration, and asks of the joints what that takes.
    fn resolved_commands(
        &self,
        targets: &JointTargets<N>,
        measured: &[JointState],
        weights: &BodyWeights<N>,
        w: &mut Workspace<N>,
    ) {
        let bodies = self.tree.bodies();
        let of_joints = targets.accelerations();
        kinematics::body_accelerations(bodies, &w.desired, of_joints, &mut w.commands);
        for (command, (gains, error)) in w.commands.iter_mut().zip(self.gains.iter().zip(&w.errors))
        {
            *command = *command + gains.apply(error);
        }
        let (world, scratch) = (&w.measured, &mut w.resolved);
        resolved_acceleration(bodies, measured, world, weights, scratch, &mut w.commands);
        kinematics::joint_accelerations(bodies, world, &mut w.commands);
        for ((body, measured), command) in bodies.iter().zip(measured).zip(&mut w.commands) {
            // Without what rounding has left across the joint's freedoms.
            let in_joint = body.placement.rotation.conjugate() * measured.pose.rotation;
            *command = body.joint.project_motion(in_joint, *command)
                + body.joint.bias_acceleration(in_joint, measured.velocity);
        }
    }

    /// Rotation from the axes of a joint's state error to measured body axes: `R_m,iᵀ R_m,l`.
    fn error_axes_to_body(&self, joint: usize, relative: Quat, measured: &[BodyState]) -> Quat {
        let rotation =
            |body: usize| measured.get(body).map_or(Quat::IDENTITY, |state| state.pose.rotation);
        match &self.method {
            Method::Local => relative.conjugate(),
            Method::World
            | Method::LinearCompensation { .. }
            | Method::ResolvedAcceleration { .. } => rotation(joint).conjugate(),
            Method::Accumulated(references) => {
                let reference = references.as_slice().get(joint).copied().flatten();
                rotation(joint).conjugate() * reference.map_or(Quat::IDENTITY, rotation)
            }
        }
    }
}

/// Scratch memory of a [`Controller`], owned by the caller; it holds nothing from tick to tick, but the
/// last tick's states and errors can be read from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Workspace<const N: usize> {
    desired: [BodyState; N],
    measured: [BodyState; N],
    errors: [StateError; N],
    aim_status: [AimStatus; N],
    commands: [Motion; N],
    resolved: [Resolved; N],
    scratch: [BodyMotion; N],
    wrenches: [Wrench; N],
    torques: [Limited<Wrench>; N],
}

impl<const N: usize> Workspace<N> {
    /// A workspace for trees of capacity `N`.
    pub fn new() -> Self {
        Self {
            desired: [BodyState::WORLD; N],
            measured: [BodyState::WORLD; N],
            errors: [StateError::ZERO; N],
            aim_status: [AimStatus::Leaf; N],
            commands: [Motion::ZERO; N],
            resolved: [Resolved::ZERO; N],
            scratch: [BodyMotion::default(); N],
            wrenches: [Wrench::ZERO; N],
            torques: [Limited { value: Wrench::ZERO, reason: None }; N],
        }
    }

    /// State errors of the last tick, by body, in the axes of the method's reference frame.
    pub fn errors(&self) -> &[StateError] {
        &self.errors
    }

    /// What the last tick of Linear Compensation did with each body's aim.
    pub fn aim_status(&self) -> &[AimStatus] {
        &self.aim_status
    }

    /// What the last tick returned.
    pub fn torques(&self) -> &[Limited<Wrench>] {
        &self.torques
    }

    /// What the last tick asked of each joint, in measured body axes: an acceleration (inverse dynamics, or
    /// PD with inertias), or moment and force in N m and N (PD alone).
    pub fn commands(&self) -> &[Motion] {
        &self.commands
    }
}

impl<const N: usize> Default for Workspace<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Why a controller could not be made.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ControllerError {
    /// The tree has no bodies.
    EmptyTree,
    /// The method's reference bodies were made for another tree.
    References(ReferencesError),
    /// The method's aims were made for another tree.
    Aims(AimsError),
    /// The weights of the method's bodies were made for another tree.
    Weights(BodyWeightsError),
    /// Resolved acceleration asks for accelerations: only inverse dynamics has torques for them.
    Law,
    /// There must be one torque limit for each joint.
    Count {
        /// Number of joints of the tree.
        expected: usize,
        /// Number of limits.
        found: usize,
    },
    /// There must be gains for each joint.
    GainsCount {
        /// Number of joints of the tree.
        expected: usize,
        /// Number of gains.
        found: usize,
    },
    /// There must be an inertia for each joint.
    InertiaCount {
        /// Number of joints of the tree.
        expected: usize,
        /// Number of inertias.
        found: usize,
    },
    /// The named setting is NaN or infinite.
    NonFinite(&'static str),
}

impl fmt::Display for ControllerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::EmptyTree => f.write_str("the tree has no bodies"),
            Self::Count { expected, found } => {
                write!(f, "{expected} joints need as many torque limits, {found} were given")
            }
            Self::GainsCount { expected, found } => {
                write!(f, "{expected} joints need as many gains, {found} were given")
            }
            Self::InertiaCount { expected, found } => {
                write!(f, "{expected} joints need as many inertias, {found} were given")
            }
            Self::References(error) => write!(f, "the method is for another tree: {error}"),
            Self::Aims(error) => write!(f, "the method is for another tree: {error}"),
            Self::Weights(error) => write!(f, "the method is for another tree: {error}"),
            Self::Law => f.write_str(
                "resolved acceleration needs the control law of inverse dynamics: PD alone has no use for accelerations",
            ),
            Self::NonFinite(name) => write!(f, "the setting {name} is not finite"),
        }
    }
}

impl core::error::Error for ControllerError {}
