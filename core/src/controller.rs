//! One control tick: targets and measurements in, limited torques out.

use core::fmt;

use glam::{Quat, Vec3};
use heapless::Vec;

use crate::body_weight::{BodyWeights, BodyWeightsError};
use crate::control::{ControlLaw, Gains, LimitReason, Limited, TorqueLimit, through_parent};
use crate::dynamics::{
    BodyMotion, ReflectedInertia, ResolvedAccelerationScratch, inverse_dynamics,
    resolved_acceleration,
};
use crate::fixed;
use crate::joint::JointKind;
use crate::joint_states::JointStates;
use crate::joint_targets::JointTargets;
use crate::kinematics;
use crate::math;
use crate::state::{BodyState, JointState};
use crate::state_error::{
    self, Aim, AimStatus, Aims, AimsError, Method, References, ReferencesError, StateError,
};
use crate::transform::{Twist, Wrench};
use crate::tree::{Body, Tree};

/// Default acceleration of gravity, m/s², in world axes: y is up.
pub const GRAVITY_M_S2: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// A tracking controller for one rig.
///
/// The controller holds the values that are constant from tick to tick. Everything else is an argument or is stored
/// in the caller's [`Workspace`]. Firmware and simulator call the same [`TorqueController::tick`].
///
/// ```
/// use sinew_core::{Body, TorqueController, Inertia, JointKind, JointStates, JointTargets, Twist};
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
///     rotor_inertia: 0.0,
/// };
/// let tree = Tree::<1>::from_bodies(&[pendulum])?;
/// let mut target = JointTargets::rest(&tree);
/// let state = pendulum.joint.state(pendulum.placement, &[0.1], &[0.0])?;
/// target.set(0, state, Twist::ZERO)?;
/// let measured = JointStates::rest(&tree);
///
/// let controller = TorqueController::new(tree, Gains::critically_damped(200.0)?, Method::World)?;
/// let mut workspace = Workspace::new();
/// let torques = controller.tick(&mut target, &measured, &[], &mut workspace);
/// // Inertia 1 kg * (0.4 m)², accelerated by kp * 0.1 rad = 20 rad/s².
/// assert!((torques[0].value.moment_nm.z - 3.2).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TorqueController<const N: usize> {
    tree: Tree<N>,
    gains: Vec<Gains, N>,
    method: Method<N>,
    law: ControlLaw,
    gravity_m_s2: Vec3,
    limits: Vec<TorqueLimit, N>,
    /// `true` if a joint other than the root's can slide.
    slides: bool,
    /// Inertias by joint if `with_inertia_scaled_pd` has set them; otherwise empty.
    inertias: Vec<ReflectedInertia, N>,
}

impl<const N: usize> TorqueController<N> {
    /// Creates a controller with the same gains for all joints, inverse dynamics, gravity of 9.81 m/s² along -y and
    /// no torque limits. O(n).
    ///
    /// # Errors
    /// [`ControllerError`] if the tree is empty, the method was made for another tree, or the β of Linear Compensation
    /// is not finite.
    #[expect(clippy::needless_pass_by_value, reason = "a controller has its own rig")]
    pub fn new(tree: Tree<N>, gains: Gains, method: Method<N>) -> Result<Self, ControllerError> {
        let mut controller = Self::uninit();
        controller.init(&tree, gains, method)?;
        Ok(controller)
    }

    /// Initializes in place. On an error nothing changes.
    #[inline(never)]
    pub(crate) fn init(
        &mut self,
        tree: &Tree<N>,
        gains: Gains,
        method: Method<N>,
    ) -> Result<(), ControllerError> {
        if tree.is_empty() {
            return Err(ControllerError::EmptyTree);
        }
        match &method {
            Method::Local | Method::World => {}
            Method::Accumulated(references) => {
                References::new(tree, references.as_slice())
                    .map_err(ControllerError::References)?;
            }
            Method::LinearCompensation { aims, settings } => {
                if !settings.beta.is_finite() {
                    return Err(ControllerError::NonFinite("beta"));
                }
                Aims::new(tree, aims.as_slice()).map_err(ControllerError::Aims)?;
            }
            Method::ResolvedAcceleration { weights } => {
                BodyWeights::new(tree, weights.as_slice()).map_err(ControllerError::Weights)?;
            }
        }
        self.tree.clone_from(tree);
        self.slides = tree.bodies().iter().skip(1).any(|body| body.joint.slides());
        self.gains = fixed::collect(tree.bodies().iter().map(|_| gains));
        self.limits = fixed::collect(tree.bodies().iter().map(|_| TorqueLimit::NONE));
        self.method = method;
        (self.law, self.gravity_m_s2) = (ControlLaw::default(), GRAVITY_M_S2);
        self.inertias.clear();
        Ok(())
    }

    /// Creates a controller of an empty tree, to be filled by [`init`](Self::init).
    pub(crate) fn uninit() -> Self {
        Self {
            tree: Tree::new(),
            gains: Vec::new(),
            method: Method::Local,
            law: ControlLaw::default(),
            gravity_m_s2: GRAVITY_M_S2,
            limits: Vec::new(),
            slides: false,
            inertias: Vec::new(),
        }
    }

    /// Sets the control law.
    ///
    /// # Errors
    /// [`ControllerError::Law`] if the method needs inverse dynamics.
    pub fn with_law(mut self, law: ControlLaw) -> Result<Self, ControllerError> {
        self.set_law(law)?;
        Ok(self)
    }

    /// Sets the control law in place.
    pub(crate) fn set_law(&mut self, law: ControlLaw) -> Result<(), ControllerError> {
        let resolved = matches!(self.method, Method::ResolvedAcceleration { .. });
        if resolved && law != ControlLaw::InverseDynamics {
            return Err(ControllerError::Law);
        }
        self.law = law;
        Ok(())
    }

    /// Sets gravity, in world axes, m/s².
    ///
    /// # Errors
    /// [`ControllerError::NonFinite`] if a component is not finite.
    pub fn with_gravity(self, gravity_m_s2: Vec3) -> Result<Self, ControllerError> {
        if !gravity_m_s2.is_finite() {
            return Err(ControllerError::NonFinite("gravity"));
        }
        Ok(Self { gravity_m_s2, ..self })
    }

    /// Sets gains for each joint.
    ///
    /// # Errors
    /// [`ControllerError::GainsCount`] if the number of gains is not the number of joints.
    pub fn with_joint_gains(self, gains: &[Gains]) -> Result<Self, ControllerError> {
        if gains.len() != self.tree.len() {
            let (expected, found) = (self.tree.len(), gains.len());
            return Err(ControllerError::GainsCount { expected, found });
        }
        Ok(Self { gains: fixed::collect(gains.iter().copied()), ..self })
    }

    /// Sets a torque limit for each joint.
    ///
    /// # Errors
    /// [`ControllerError::Count`] if the number of limits is not the number of joints.
    ///
    /// ```
    /// use sinew_core::control::{Gains, LimitReason, TorqueLimit};
    /// use sinew_core::{TorqueController, ControllerError, JointStates, JointTargets, Workspace};
    /// use sinew_core::{glam::Vec3, state_error::Method};
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
    /// // 2 kg on a level arm of 0.5 m need 9.81 N m; the drive has 6.
    /// let controller = TorqueController::new(tree, Gains::critically_damped(200.0)?, Method::World)?
    ///     .with_limits(&[TorqueLimit::new(6.0, 0.0)?])?;
    /// let mut workspace = Workspace::new();
    /// let torque = controller.tick(&mut targets, &measured, &[], &mut workspace)[0];
    /// assert_eq!(torque.value.moment_nm, Vec3::Z * 6.0);
    /// assert_eq!(torque.reason, Some(LimitReason::Torque));
    /// // Without gravity no torque is needed.
    /// let controller = controller.with_gravity(Vec3::ZERO)?;
    /// let torque = controller.tick(&mut targets, &measured, &[], &mut workspace)[0];
    /// assert_eq!((torque.value.moment_nm, torque.reason), (Vec3::ZERO, None));
    /// assert_eq!(
    ///     controller.with_limits(&[]),
    ///     Err(ControllerError::Count { expected: 1, found: 0 })
    /// );
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_limits(self, limits: &[TorqueLimit]) -> Result<Self, ControllerError> {
        if limits.len() != self.tree.len() {
            return Err(ControllerError::Count { expected: self.tree.len(), found: limits.len() });
        }
        Ok(Self { limits: fixed::collect(limits.iter().copied()), ..self })
    }

    /// Sets the PD law with gains per unit of inertia (1/s² and 1/s). The torque of a joint is the acceleration that
    /// these gains ask for, times the joint's own constant inertia (see
    /// [`reflected_inertia`](crate::dynamics::reflected_inertia)).
    ///
    /// Joints move each other, so a given period allows less damping than for a single joint: `kd dt_s` must be below
    /// 1 / λ, where λ is the largest eigenvalue of the inverse mass matrix times these inertias.
    ///
    /// # Errors
    /// [`ControllerError::InertiaCount`] if the number of inertias is not the number of joints,
    /// [`ControllerError::NonFinite`] if an inertia is not finite, [`ControllerError::Law`] if the method needs
    /// inverse dynamics.
    ///
    /// ```
    /// use sinew_core::dynamics::{OuterJoints, reflected_inertia};
    /// use sinew_core::{TorqueController, JointStates, control::{ControlLaw, Gains}, state_error::Method};
    /// # use sinew_core::{Body, Inertia, JointKind, RotationalInertia, Transform, Tree, glam::Vec3};
    /// # let inertia = Inertia {
    /// #     mass_kg: 2.0,
    /// #     center_of_mass_m: Vec3::X * 0.5,
    /// #     rotational_kg_m2: RotationalInertia::default(),
    /// # };
    /// # let joint = JointKind::Revolute { axis: Vec3::Z };
    /// # let arm = Body { parent: None, joint, placement: Transform::IDENTITY, inertia, rotor_inertia: 0.0 };
    /// let tree = Tree::<1>::from_bodies(&[arm])?;
    /// let inertias = reflected_inertia(&tree, &JointStates::rest(&tree), OuterJoints::Locked);
    /// // The law of a servo alone: no model in the loop, but gains that fit the inertia that each joint moves.
    /// let controller = TorqueController::new(tree, Gains::critically_damped(200.0)?, Method::Local)?
    ///     .with_inertia_scaled_pd(&inertias)?;
    /// assert_eq!(controller.law(), ControlLaw::ProportionalDerivative);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_inertia_scaled_pd(
        mut self,
        inertias: &[ReflectedInertia],
    ) -> Result<Self, ControllerError> {
        self.set_pd_of_inertia(inertias)?;
        Ok(self)
    }

    /// Sets, in place, the law of [`Self::with_inertia_scaled_pd`].
    pub(crate) fn set_pd_of_inertia(
        &mut self,
        inertias: &[ReflectedInertia],
    ) -> Result<(), ControllerError> {
        if inertias.len() != self.tree.len() {
            let (expected, found) = (self.tree.len(), inertias.len());
            return Err(ControllerError::InertiaCount { expected, found });
        }
        if !inertias.iter().all(ReflectedInertia::is_finite) {
            return Err(ControllerError::NonFinite("inertia"));
        }
        self.inertias = fixed::collect(inertias.iter().copied());
        self.set_law(ControlLaw::ProportionalDerivative)
    }

    /// Returns the rig.
    pub fn tree(&self) -> &Tree<N> {
        &self.tree
    }

    /// Returns the gains by joint.
    pub fn gains(&self) -> &[Gains] {
        &self.gains
    }

    /// Returns the method that computes the tracked state error.
    pub fn method(&self) -> &Method<N> {
        &self.method
    }

    /// Returns the law that turns errors into torques.
    pub fn law(&self) -> ControlLaw {
        self.law
    }

    /// Returns gravity, m/s², in world axes.
    pub fn gravity_m_s2(&self) -> Vec3 {
        self.gravity_m_s2
    }

    /// Returns the torque limits by joint.
    pub fn limits(&self) -> &[TorqueLimit] {
        &self.limits
    }

    /// Returns the inertias by joint that [`Self::with_inertia_scaled_pd`] has set; empty by default.
    pub fn inertias(&self) -> &[ReflectedInertia] {
        &self.inertias
    }

    /// Returns the torques for this instant: the wrench of joint i's drive on body i about its origin, in measured
    /// body axes, along the joint's dofs, within its limit. [`Tree::efforts`](crate::Tree::efforts) converts them to
    /// numbers by dof. O(n).
    ///
    /// It cannot fail: the types guarantee finite inputs, and a torque that overflows is returned as zero with its
    /// reason. `external` is the wrench on each body from outside (see [`inverse_dynamics`]); empty for none. Targets
    /// and measurements must belong to this controller's tree: the result omits joints that targets or measurements
    /// lack. Resolved acceleration without [`Workspace::resolving`] gives zero, with [`LimitReason::NoRoom`].
    pub fn tick<'w, const R: usize>(
        &self,
        targets: &mut JointTargets<N>,
        measured: &JointStates<N>,
        external: &[Wrench],
        workspace: &'w mut Workspace<N, R>,
    ) -> &'w [Limited<Wrench>] {
        let bodies = self.tree.bodies();
        let measured = measured.as_slice();
        let count = bodies.len().min(targets.states().len()).min(measured.len());
        let w = workspace;
        if R < count && matches!(self.method, Method::ResolvedAcceleration { .. }) {
            w.torques.fill(Limited { value: Wrench::ZERO, reason: Some(LimitReason::NoRoom) });
            return w.torques.get(..count).unwrap_or_default();
        }

        match self.method {
            // Local errors need no world states.
            Method::Local => {}
            // World errors of bodies that only turn need only the turning part of world states.
            Method::World if !self.slides => {
                kinematics::body_turns(bodies, measured, &mut w.measured);
                targets.complete_turns(&self.tree);
            }
            _ => {
                kinematics::body_states(bodies, measured, &mut w.measured);
                targets.complete(&self.tree);
            }
        }
        match &self.method {
            // Unreachable, because a tree has a body. With R = 0 the compiler therefore omits the code of this
            // method.
            Method::ResolvedAcceleration { .. } if R == 0 => {}
            Method::ResolvedAcceleration { weights } => {
                self.resolved_commands(targets, measured, weights, w);
            }
            // Each of the other methods has its own loop, which avoids a match on the method for each body.
            Method::Local => self.direct_commands(targets, measured, w, |at| {
                let to_body = at.measured.pose.rotation.conjugate();
                (state_error::of_joint(at.desired, at.measured), to_body)
            }),
            Method::World => self.world_commands(targets, measured, w),
            Method::Accumulated(references) => {
                self.direct_commands(targets, measured, w, |at| {
                    let reference = references.as_slice().get(at.body).copied().flatten();
                    let reference = reference.and_then(|body| at.bodies(body));
                    let (of_desired, of_measured) =
                        reference.unwrap_or((&BodyState::WORLD, &BodyState::WORLD));
                    let error = StateError::between(
                        &at.desired_body.seen_from(of_desired),
                        &at.measured_body.seen_from(of_measured),
                    );
                    let to_body =
                        at.measured_body.pose.rotation.conjugate() * of_measured.pose.rotation;
                    (error, to_body)
                });
            }
            Method::LinearCompensation { aims, settings } => {
                self.direct_commands(targets, measured, w, |at| {
                    let aim = aims.as_slice().get(at.body).unwrap_or(&Aim::None);
                    let (error, status) = state_error::aimed(
                        aim,
                        *settings,
                        at.desired_bodies,
                        at.desired_body,
                        at.measured_body,
                    );
                    *at.aim_status = status;
                    (error, at.measured_body.pose.rotation.conjugate())
                });
            }
        }

        match self.law {
            ControlLaw::ProportionalDerivative if self.inertias.is_empty() => {
                for (command, torque) in w.commands.iter().zip(&mut w.torques) {
                    torque.value = Wrench::new(command.angular, command.linear);
                }
            }
            ControlLaw::ProportionalDerivative => {
                for ((command, inertia), torque) in
                    w.commands.iter().zip(&self.inertias).zip(&mut w.torques)
                {
                    torque.value = inertia.wrench(*command);
                }
            }
            ControlLaw::InverseDynamics => inverse_dynamics(
                bodies,
                measured,
                &w.commands,
                self.gravity_m_s2,
                external,
                &mut w.scratch,
                &mut w.torques,
            ),
        }

        limit_wrenches(bodies, measured, &self.limits, &mut w.torques);
        w.torques.get(..count).unwrap_or_default()
    }

    /// Computes the wrenches that hold every joint at constant speed in the measured state: against gravity,
    /// centrifugal and Coriolis forces and external wrenches (Featherstone's bias forces). They are in measured body
    /// axes, along the joints' dofs and within their limits. O(n).
    ///
    /// The rest of a tick's torque accelerates the joints: see
    /// [`TorqueSupply::share_acceleration`](crate::supply::TorqueSupply::share_acceleration). The commands and
    /// torques of the last tick, in the workspace, are unchanged.
    pub fn bias_wrenches<const R: usize>(
        &self,
        measured: &JointStates<N>,
        external: &[Wrench],
        workspace: &mut Workspace<N, R>,
        out: &mut [Wrench],
    ) {
        let measured = measured.as_slice();
        let mut accelerations = [Twist::ZERO; N];
        for ((body, measured), acceleration) in
            self.tree.bodies().iter().zip(measured).zip(&mut accelerations)
        {
            let in_joint = body.rotation_in_joint(measured.pose.rotation);
            *acceleration = body.joint.bias_acceleration(in_joint, measured.velocity);
        }
        self.limited_wrenches(measured, &accelerations, external, workspace, out);
    }

    /// Computes the wrenches that the targets' accelerations need at the measured state, along the joints' dofs and
    /// within their limits: the result of a tick with zero errors. O(n).
    pub(crate) fn feedforward_wrenches<const R: usize>(
        &self,
        targets: &JointTargets<N>,
        measured: &JointStates<N>,
        external: &[Wrench],
        workspace: &mut Workspace<N, R>,
        out: &mut [Wrench],
    ) {
        let measured = measured.as_slice();
        let mut accelerations = [Twist::ZERO; N];
        for ((body, (desired, measured)), (wanted, acceleration)) in self
            .tree
            .bodies()
            .iter()
            .zip(targets.states().iter().zip(measured))
            .zip(targets.accelerations().iter().zip(&mut accelerations))
        {
            let law = ControlLaw::InverseDynamics;
            *acceleration = asked(body, law, desired, measured, wanted, Twist::ZERO);
        }
        self.limited_wrenches(measured, &accelerations, external, workspace, out);
    }

    /// Computes inverse dynamics along the joints' dofs, within their limits.
    fn limited_wrenches<const R: usize>(
        &self,
        measured: &[JointState],
        accelerations: &[Twist],
        external: &[Wrench],
        workspace: &mut Workspace<N, R>,
        out: &mut [Wrench],
    ) {
        let bodies = self.tree.bodies();
        let (gravity, scratch) = (self.gravity_m_s2, &mut workspace.scratch);
        inverse_dynamics(bodies, measured, accelerations, gravity, external, scratch, out);
        for (((body, measured), limit), wrench) in
            bodies.iter().zip(measured).zip(&self.limits).zip(out)
        {
            let in_joint = body.rotation_in_joint(measured.pose.rotation);
            *wrench = limit.apply(body.joint.project_wrench(in_joint, *wrench)).value;
        }
    }

    /// Computes the state errors by body that a tick with these arguments acts on, in the axes of the method's
    /// reference frame. O(n).
    ///
    /// Only reports need these errors, so a tick does not store them.
    pub fn errors<const R: usize>(
        &self,
        targets: &mut JointTargets<N>,
        measured: &JointStates<N>,
        workspace: &mut Workspace<N, R>,
        out: &mut [StateError],
    ) {
        let w = workspace;
        kinematics::body_states(self.tree.bodies(), measured.as_slice(), &mut w.measured);
        targets.complete(&self.tree);
        let desired = targets.bodies();
        match &self.method {
            Method::Local => state_error::local(targets.states(), measured.as_slice(), out),
            Method::World | Method::ResolvedAcceleration { .. } => {
                state_error::world(desired, &w.measured, out);
            }
            Method::Accumulated(references) => {
                state_error::accumulated(references.as_slice(), desired, &w.measured, out);
            }
            Method::LinearCompensation { aims, settings } => state_error::linear_compensation(
                aims.as_slice(),
                *settings,
                desired,
                &w.measured,
                out,
                &mut w.aim_status,
            ),
        }
    }

    /// Computes the commands of the methods that apply every error to its own joint: eq. (11). `error` returns the
    /// error in the axes of the method's reference frame, and the rotation from these axes to measured body axes.
    fn direct_commands<const R: usize>(
        &self,
        targets: &JointTargets<N>,
        measured: &[JointState],
        w: &mut Workspace<N, R>,
        error: impl Fn(BodyContext<'_>) -> (StateError, Quat),
    ) {
        let desired_bodies = targets.bodies();
        for (body, (((of_tree, gains), (desired, of_targets)), (measured, out))) in self
            .tree
            .bodies()
            .iter()
            .zip(&self.gains)
            .zip(targets.states().iter().zip(targets.accelerations()))
            .zip(measured.iter().zip(w.commands.iter_mut().zip(&mut w.aim_status)))
            .enumerate()
        {
            let (Some(desired_body), Some(measured_body)) =
                (desired_bodies.get(body), w.measured.get(body))
            else {
                break;
            };
            let (command, aim_status) = out;
            let (error, to_body) = error(BodyContext {
                body,
                desired,
                measured,
                desired_body,
                measured_body,
                desired_bodies,
                measured_bodies: &w.measured,
                aim_status,
            });
            let joint = of_tree.joint;
            let correction = gains.apply(&error);
            let mut wanted = Twist::new(math::rotate(to_body, correction.angular), Vec3::ZERO);
            if joint.slides() {
                wanted.linear = math::rotate(to_body, correction.linear);
            }
            *command = asked(of_tree, self.law, desired, measured, of_targets, wanted);
        }
    }

    /// Computes the commands that follow from world errors. For bodies whose joints only turn, it uses only results of
    /// [`kinematics::body_turns`].
    #[inline(never)]
    fn world_commands<const R: usize>(
        &self,
        targets: &JointTargets<N>,
        measured: &[JointState],
        w: &mut Workspace<N, R>,
    ) {
        let bodies = self.tree.bodies();
        for (index, ((((body, gains), of_target), desired), (is, command))) in bodies
            .iter()
            .zip(&self.gains)
            .zip(targets.accelerations())
            .zip(targets.bodies())
            .zip(w.measured.iter().zip(&mut w.commands))
            .enumerate()
        {
            let of_target =
                if self.law == ControlLaw::InverseDynamics { of_target } else { &Twist::ZERO };
            let turn = math::log(math::turn_in_world(is.pose.rotation, desired.pose.rotation));
            let rate = desired.velocity.angular - is.velocity.angular;
            let to_body = is.pose.rotation.conjugate();
            let correction = math::rotate(to_body, turn * gains.kp() + rate * gains.kd());
            let wanted = correction + of_target.angular;
            match body.joint {
                JointKind::Spherical => {
                    (command.angular, command.linear) = (wanted, Vec3::ZERO);
                }
                JointKind::Revolute { axis } => {
                    (command.angular, command.linear) = (axis * axis.dot(wanted), Vec3::ZERO);
                }
                _ => {
                    let states = targets.states().get(index).zip(measured.get(index));
                    let Some((of_joint, measured)) = states else { return };
                    let states = [of_joint, measured];
                    command.angular = correction;
                    let of_bodies = [desired, is];
                    finish_command(body, *gains, self.law, of_bodies, states, of_target, command);
                }
            }
        }
    }

    /// Computes the commands of resolved acceleration: errors become accelerations of bodies, which become
    /// accelerations of joints.
    fn resolved_commands<const R: usize>(
        &self,
        targets: &JointTargets<N>,
        measured: &[JointState],
        weights: &BodyWeights<N>,
        w: &mut Workspace<N, R>,
    ) {
        let bodies = self.tree.bodies();
        let of_joints = targets.accelerations();
        kinematics::body_accelerations(bodies, targets.bodies(), of_joints, &mut w.commands);
        for (command, (gains, (desired, measured))) in w
            .commands
            .iter_mut()
            .zip(self.gains.iter().zip(targets.bodies().iter().zip(&w.measured)))
        {
            *command = *command + gains.apply(&StateError::between(desired, measured));
        }
        let (world, scratch) = (&w.measured, &mut w.resolved);
        resolved_acceleration(bodies, measured, world, weights, scratch, &mut w.commands);
        kinematics::joint_accelerations(bodies, world, &mut w.commands);
        for ((body, measured), command) in bodies.iter().zip(measured).zip(&mut w.commands) {
            // Removes motion outside the joint's dofs, which is only rounding error.
            let in_joint = body.rotation_in_joint(measured.pose.rotation);
            *command = body.joint.project_twist(in_joint, *command)
                + body.joint.bias_acceleration(in_joint, measured.velocity);
        }
    }
}

/// Returns a joint's command for a correction, along the joint's axes. With inverse dynamics the command is an
/// acceleration, and includes the target's acceleration and the bias of moving axes. Correction and result are in
/// measured body axes.
#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
fn asked(
    body: &Body,
    law: ControlLaw,
    desired: &JointState,
    measured: &JointState,
    of_target: &Twist,
    correction: Twist,
) -> Twist {
    let (joint, mut wanted) = (body.joint, correction);
    let is_acceleration = law == ControlLaw::InverseDynamics;
    if is_acceleration {
        wanted.angular += of_target.angular;
        if joint.slides() {
            wanted.linear += through_parent(desired, measured, of_target.linear);
        }
    }
    let in_joint = body.rotation_in_joint(measured.pose.rotation);
    let mut allowed = joint.project_twist(in_joint, wanted);
    if is_acceleration && matches!(joint, JointKind::Universal { .. }) {
        allowed.angular += moving_axis(body, measured);
    }
    allowed
}

/// Returns the angular acceleration of a universal joint due to the motion of its first axis. Never inlined, since
/// few joints are universal.
#[inline(never)]
fn moving_axis(body: &Body, measured: &JointState) -> Vec3 {
    let in_joint = body.rotation_in_joint(measured.pose.rotation);
    body.joint.bias_acceleration(in_joint, measured.velocity).angular
}

/// Completes the command of a joint that is neither spherical nor revolute, from the angular correction in `command`.
/// `bodies` and `joints` are each a desired and a measured state. Never inlined, because its inlined code would
/// take registers from the other joint kinds.
#[inline(never)]
fn finish_command(
    body: &Body,
    gains: Gains,
    law: ControlLaw,
    bodies: [&BodyState; 2],
    joints: [&JointState; 2],
    of_target: &Twist,
    command: &mut Twist,
) {
    let ([desired, is], [of_joint, measured]) = (bodies, joints);
    let mut wanted = Twist { linear: Vec3::ZERO, ..*command };
    if body.joint.slides() {
        let correction = gains.apply(&StateError {
            linear_m: desired.pose.translation_m - is.pose.translation_m,
            linear_rate_m_s: desired.velocity.linear - is.velocity.linear,
            ..StateError::ZERO
        });
        wanted.linear = math::rotate(is.pose.rotation.conjugate(), correction.linear);
    }
    *command = asked(body, law, of_joint, measured, of_target, wanted);
}

/// Replaces the wrenches on bodies by the torques that the joints' drives must deliver, within their limits.
///
/// Never inlined, because its code would compete for registers inside the tick. It works in place, because
/// otherwise wrenches would go through the stack.
#[inline(never)]
fn limit_wrenches(
    bodies: &[Body],
    measured: &[JointState],
    limits: &[TorqueLimit],
    torques: &mut [Limited<Wrench>],
) {
    for (((body, measured), limit), torque) in bodies.iter().zip(measured).zip(limits).zip(torques)
    {
        let wrench = &mut torque.value;
        match body.joint {
            JointKind::Spherical => wrench.force_n = Vec3::ZERO,
            JointKind::Revolute { axis } => {
                wrench.moment_nm = axis * axis.dot(wrench.moment_nm);
                wrench.force_n = Vec3::ZERO;
            }
            JointKind::Free => {}
            joint => {
                let in_joint = body.rotation_in_joint(measured.pose.rotation);
                let (moment_nm, force_n) =
                    joint.on_axes(in_joint, wrench.moment_nm, wrench.force_n);
                *wrench = Wrench { moment_nm, force_n };
            }
        }
        limit.bound(torque, body.joint.slides());
    }
}

/// Inputs for the state error of one body.
struct BodyContext<'a> {
    body: usize,
    desired: &'a JointState,
    measured: &'a JointState,
    desired_body: &'a BodyState,
    measured_body: &'a BodyState,
    desired_bodies: &'a [BodyState],
    measured_bodies: &'a [BodyState],
    aim_status: &'a mut AimStatus,
}

impl<'a> BodyContext<'a> {
    /// Returns desired and measured state of another body.
    fn bodies(&self, body: usize) -> Option<(&'a BodyState, &'a BodyState)> {
        Some((self.desired_bodies.get(body)?, self.measured_bodies.get(body)?))
    }
}

/// Scratch memory of a [`TorqueController`], owned by the caller. No tick depends on the contents that an earlier
/// tick left. The last tick's commands and torques can be read from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Workspace<const N: usize, const R: usize = 0> {
    measured: [BodyState; N],
    aim_status: [AimStatus; N],
    commands: [Twist; N],
    resolved: [ResolvedAccelerationScratch; R],
    scratch: [BodyMotion; N],
    torques: [Limited<Wrench>; N],
}

impl<const N: usize> Workspace<N> {
    /// Creates a workspace for trees of capacity `N`, for all methods except resolved acceleration.
    pub fn new() -> Self {
        Self::with_room()
    }
}

impl<const N: usize> Workspace<N, N> {
    /// Creates a workspace for trees of capacity `N`, for all methods. Room for resolved acceleration takes 132
    /// bytes per body.
    pub fn resolving() -> Self {
        Self::with_room()
    }
}

impl<const N: usize, const R: usize> Workspace<N, R> {
    /// Creates a workspace with room for resolved acceleration of `R` bodies.
    // Functions that make large values are never inlined: they then build the value in the caller's destination, not
    // on the stack.
    #[inline(never)]
    pub(crate) fn with_room() -> Self {
        Self {
            measured: [BodyState::WORLD; N],
            aim_status: [AimStatus::Leaf; N],
            commands: [Twist::ZERO; N],
            resolved: [ResolvedAccelerationScratch::ZERO; R],
            scratch: [BodyMotion::default(); N],
            torques: [Limited { value: Wrench::ZERO, reason: None }; N],
        }
    }

    /// Returns how the last tick of Linear Compensation handled each body's aim.
    pub fn aim_status(&self) -> &[AimStatus] {
        &self.aim_status
    }

    /// Returns the torques of the last tick.
    pub fn torques(&self) -> &[Limited<Wrench>] {
        &self.torques
    }

    /// Returns the torques of the last tick, so that a common [`supply`](crate::supply) can reduce them before they
    /// go to the drives.
    pub fn torques_mut(&mut self) -> &mut [Limited<Wrench>] {
        &mut self.torques
    }

    /// Returns the commands of the last tick to each joint, in measured body axes: an acceleration (inverse dynamics,
    /// or PD with inertias), or moment and force in N m and N (PD alone).
    pub fn commands(&self) -> &[Twist] {
        &self.commands
    }
}

impl<const N: usize> Default for Workspace<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// An error in the parts of a controller.
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
    /// The method is resolved acceleration, which needs inverse dynamics, but the law is PD.
    Law,
    /// The number of torque limits is not the number of joints.
    Count {
        /// Number of joints of the tree.
        expected: usize,
        /// Number of limits.
        found: usize,
    },
    /// The number of gains is not the number of joints.
    GainsCount {
        /// Number of joints of the tree.
        expected: usize,
        /// Number of gains.
        found: usize,
    },
    /// The number of inertias is not the number of joints.
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
            Self::References(error) => write!(f, "method and tree do not match: {error}"),
            Self::Aims(error) => write!(f, "method and tree do not match: {error}"),
            Self::Weights(error) => write!(f, "method and tree do not match: {error}"),
            Self::Law => f.write_str(
                "resolved acceleration needs the control law of inverse dynamics: PD alone does not use accelerations",
            ),
            Self::NonFinite(name) => write!(f, "the setting {name} is not finite"),
        }
    }
}

impl core::error::Error for ControllerError {}
