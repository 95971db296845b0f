//! The settings of a tracker, in a type that files, boards and simulators share.

use crate::body_weight::{BodyWeight, BodyWeights};
use crate::control::{ControlLaw, Gains};
use crate::controller::TorqueController;
use crate::dynamics::{OuterJoints, reflected_inertia};
use crate::importance::{RestPose, descendants_length};
use crate::joint_states::JointStates;
use crate::observer::ObserverSettings;
use crate::projection::{DEFAULT_SWEEPS, ManifoldProjection, ProjectionError};
use crate::state_error::{Aims, Compensation, Method, RateTerm, References};
use crate::tree::Tree;

use super::error::{SettingError, TrackerError};
use super::names::{
    AimName, DesiredVelocity, Differences, GainsName, MethodName, Sharing, WeightsName,
};

/// Recommended weight of rotation against position in the projection: an error of 1 rad costs as much as 0.5 m.
pub const RECOMMENDED_ROTATION_WEIGHT_M: f32 = 0.5;

/// Bandwidth of the recommended observer, rad/s; limited to one over the tick.
pub const BANDWIDTH_RAD_S: f32 = 100.0;

/// Base importance of every joint in the importance by lengths, m. The next constant is its discount for each bone.
const IMPORTANCE_BASE_M: f32 = 0.1;
const IMPORTANCE_DISCOUNT: f32 = 0.9;

/// Settings of a tracker. Default: the Local Space Error of the paper, with its gains.
///
/// With the feature `serde` the settings are read from a file, and every key is optional. `B` is the type that names
/// a body: an index, or a name in files that people write.
///
/// ```
/// use sinew_core::tracker::{MethodName, Settings};
/// let settings: Settings = Settings { kp: 100.0, ..Settings::recommended() };
/// assert_eq!(settings.method, MethodName::Recommended);
/// settings.check()?;
/// let error = Settings::<usize> { kp: f32::NAN, ..Settings::default() }.check().unwrap_err();
/// assert_eq!(error.to_string(), "kp: expected a finite number above 0, found NaN");
/// # Ok::<(), sinew_core::tracker::SettingError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
pub struct Settings<B: Default = usize> {
    /// Method of measuring the state error.
    pub method: MethodName,
    /// Body relative to which `accumulated` measures the errors of all its descendants. The errors of other bodies are
    /// relative to the world.
    pub reference: B,
    /// Weight β of Linear Compensation: 0 is World Space Error, 1 is the paper's method.
    pub beta: f32,
    /// Rate of the compensating rotation.
    pub rate_term: RateTerm,
    /// Aim of a body with several children in Linear Compensation.
    pub aim: AimName,
    /// Manifold projection, for methods with a projection.
    pub projection: ProjectionSettings,
    /// Weights of resolved acceleration, used when not every body can reach its acceleration.
    pub resolved: ResolvedSettings,
    /// Estimation of the state from the sensors.
    pub observer: ObserverChoice,
    /// Frames whose differences give desired velocities and accelerations.
    pub differences: Differences,
    /// Source of the desired velocities, if forward differences are used.
    pub desired_velocity: DesiredVelocity,
    /// Law that turns the error into a torque.
    #[cfg_attr(feature = "serde", serde(with = "super::names::law"))]
    pub law: ControlLaw,
    /// Rule by which the joints share a common supply, see [`Tracker::with_supply`](super::Tracker::with_supply).
    pub sharing: Sharing,
    /// Factors of the gains of `pd`, joint by joint.
    pub gains: GainsName,
    /// Stiffness, in 1/s², or in N m/rad for `pd` with uniform gains. The damping is critical.
    pub kp: f32,
    /// Whether the gains are those of stable PD, which act on the state one period ahead.
    pub implicit: bool,
}

impl<B: Default> Default for Settings<B> {
    fn default() -> Self {
        Self {
            method: MethodName::Local,
            reference: B::default(),
            beta: 1.0,
            rate_term: RateTerm::Corrected,
            aim: AimName::HeaviestChild,
            projection: ProjectionSettings::default(),
            resolved: ResolvedSettings::default(),
            observer: ObserverChoice::default(),
            differences: Differences::Forward,
            desired_velocity: DesiredVelocity::Bodies,
            law: ControlLaw::InverseDynamics,
            sharing: Sharing::Uniform,
            gains: GainsName::Uniform,
            kp: 200.0,
            implicit: false,
        }
    }
}

/// Settings of the manifold projection.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
pub struct ProjectionSettings {
    /// Weight of rotation against position: an error of 1 rad costs as much as this many metres.
    pub rotation_m: f32,
    /// Distribution of this weight among the bodies.
    pub weights: WeightsName,
    /// Whether the root keeps its pose from the performance.
    pub root_held: bool,
    /// Gauss-Newton steps for each frame.
    pub sweeps: u8,
    /// Whether the bodies' errors are corrected by resolved acceleration instead of by their own joints.
    pub resolved: bool,
}

impl Default for ProjectionSettings {
    fn default() -> Self {
        Self {
            rotation_m: RECOMMENDED_ROTATION_WEIGHT_M,
            weights: WeightsName::Uniform,
            root_held: false,
            sweeps: DEFAULT_SWEEPS,
            resolved: false,
        }
    }
}

/// Estimation of the state from the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
pub struct ObserverChoice {
    /// Bandwidth of an extended state observer, rad/s; 0 for backward differences.
    pub bandwidth_rad_s: f32,
    /// Whether the learnt disturbance is cancelled.
    pub cancel: bool,
    /// Whether commands are computed for the state predicted over the latency.
    pub predict: bool,
}

/// Weights of resolved acceleration, used when not every body can reach its acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
pub struct ResolvedSettings {
    /// Weight of the linear acceleration of a body's origin. With 0, it counts only for bodies on free or prismatic
    /// joints, such as a free root, and `rotation_m` is not used.
    pub position: f32,
    /// Weight of rotation against position: an error of 1 rad/s² costs as much as this many m/s².
    pub rotation_m: f32,
}

impl Default for ResolvedSettings {
    fn default() -> Self {
        Self { position: 0.0, rotation_m: 1.0 }
    }
}

impl<B: Default + Clone> Settings<B> {
    /// Returns the settings for real rigs: manifold projection on aligned targets, implicit gains, and an observer
    /// that cancels model errors and predicts over the latency.
    #[must_use]
    pub fn recommended() -> Self {
        Self { method: MethodName::Recommended, ..Self::default() }
    }

    /// Replaces the method [`MethodName::Recommended`] by the settings that it represents, for a rig with a period of
    /// `dt_s` seconds. Gains and the projection's weights are kept.
    ///
    /// A tracker with explicit settings does not check its [`Timing`](super::Timing), so that drives with too much
    /// delay can be simulated.
    #[must_use]
    pub fn effective(self, dt_s: f32) -> Self {
        let recommended = self.method == MethodName::Recommended;
        let mut effective = self.spelled_out();
        if recommended {
            // An observer cannot be faster than its ticks.
            let bandwidth_rad_s = &mut effective.observer.bandwidth_rad_s;
            *bandwidth_rad_s = bandwidth_rad_s.min(1.0 / dt_s);
        }
        effective
    }

    /// Replaces the recommended method as `effective` does, without the limit by the period.
    fn spelled_out(self) -> Self {
        if self.method != MethodName::Recommended {
            return self;
        }
        Self {
            method: MethodName::ManifoldProjection,
            differences: Differences::Aligned,
            observer: ObserverChoice {
                bandwidth_rad_s: BANDWIDTH_RAD_S,
                cancel: true,
                predict: true,
            },
            implicit: true,
            ..self
        }
    }

    /// Sets the method, for a comparison of several methods with common settings. [`MethodName::Recommended`] fixes
    /// differences and observer: other values of these two settings are replaced.
    #[must_use]
    pub fn with_method(self, method: MethodName) -> Self {
        let of_method = Self { method, ..self };
        if of_method.fixed_otherwise().is_none() {
            return of_method;
        }
        let Self { observer, differences, .. } = of_method.clone().spelled_out();
        Self { observer, differences, ..of_method }
    }

    /// Returns the key of a setting that the method fixes, but that has neither the fixed value nor its default.
    fn fixed_otherwise(&self) -> Option<&'static str> {
        let (own, default) = (self.clone().spelled_out(), Self::default());
        if self.method != MethodName::Recommended {
            None
        } else if ![own.differences, default.differences].contains(&self.differences) {
            Some("differences")
        } else if ![own.observer, default.observer].contains(&self.observer) {
            Some("observer")
        } else {
            None
        }
    }

    /// Converts the type that names the reference body.
    pub fn named<C: Default>(self, name: impl FnOnce(B) -> C) -> Settings<C> {
        Settings {
            method: self.method,
            reference: name(self.reference),
            beta: self.beta,
            rate_term: self.rate_term,
            aim: self.aim,
            projection: self.projection,
            resolved: self.resolved,
            observer: self.observer,
            differences: self.differences,
            desired_velocity: self.desired_velocity,
            law: self.law,
            sharing: self.sharing,
            gains: self.gains,
            kp: self.kp,
            implicit: self.implicit,
        }
    }

    /// Checks every value, and whether the values fit together; NaN is refused. With [`MethodName::Recommended`],
    /// differences and observer are fixed: they must be left out, or have the fixed values.
    ///
    /// # Errors
    /// [`SettingError`] with the key.
    ///
    /// ```
    /// use sinew_core::tracker::{Differences, Settings};
    /// let live = Settings { differences: Differences::Live, ..Settings::<usize>::recommended() };
    /// let expected =
    ///     "differences: fixed by method = \"recommended\"; use \"manifold_projection\" and set it";
    /// assert_eq!(live.check().unwrap_err().to_string(), expected);
    /// ```
    pub fn check(&self) -> Result<(), SettingError> {
        let Self { beta, kp, law, gains, projection, resolved, implicit, observer, .. } =
            self.clone().spelled_out();
        let pd = law == ControlLaw::ProportionalDerivative;
        let value = |key, expected, value| Err(SettingError::Value { key, expected, value });
        let length = "a length from 0.01 to 100 m";
        if let Some(key) = self.fixed_otherwise() {
            return Err(SettingError::Fixed { key });
        }
        if gains != GainsName::Uniform && !pd {
            return Err(SettingError::GainsWithoutPd);
        }
        if pd && (observer.predict || observer.bandwidth_rad_s > 0.0) {
            return Err(SettingError::ObserverWithoutDynamics);
        }
        if implicit && pd && gains == GainsName::Uniform {
            return Err(SettingError::ImplicitWithoutInertia);
        }
        if !(0.0..=2.0).contains(&beta) {
            return value("beta", "a weight from 0 to 2", beta);
        }
        if !(0.01..=100.0).contains(&projection.rotation_m) {
            return value("projection.rotation_m", length, projection.rotation_m);
        }
        let heaviest = 1e4 * resolved.rotation_m * resolved.rotation_m;
        if resolved.position != 0.0 && !(1e-6..=heaviest).contains(&resolved.position) {
            let expected = "0, or a weight from 1e-6 to 1e4 times the square of rotation_m";
            return value("resolved.position", expected, resolved.position);
        }
        if !(0.01..=100.0).contains(&resolved.rotation_m) {
            return value("resolved.rotation_m", length, resolved.rotation_m);
        }
        if !(0.0..=1000.0).contains(&observer.bandwidth_rad_s) {
            let expected = "a bandwidth from 0 to 1000 rad/s";
            return value("observer.bandwidth_rad_s", expected, observer.bandwidth_rad_s);
        }
        if observer.cancel && observer.bandwidth_rad_s <= 0.0 {
            let expected =
                "a bandwidth above 0 rad/s: without an observer there is nothing to cancel";
            return value("observer.bandwidth_rad_s", expected, observer.bandwidth_rad_s);
        }
        if projection.sweeps == 0 {
            return value("projection.sweeps", "a number from 1 to 255", 0.0);
        }
        if !(kp > 0.0 && kp.is_finite()) {
            return value("kp", "a finite number above 0", kp);
        }
        Ok(())
    }
}

impl Settings {
    /// Creates the controller of a rig with a period of `dt_s` seconds. O(n).
    ///
    /// # Errors
    /// [`TrackerError`] if a setting is invalid, or invalid for this rig.
    #[expect(clippy::needless_pass_by_value, reason = "a controller has its own rig")]
    pub fn controller<const N: usize>(
        &self,
        tree: Tree<N>,
        dt_s: f32,
    ) -> Result<TorqueController<N>, TrackerError> {
        let mut controller = TorqueController::uninit();
        self.set_controller(&mut controller, &tree, dt_s)?;
        Ok(controller)
    }

    /// Initializes a controller in place.
    // Never inlined: its stack is then free again before the caller goes on.
    #[inline(never)]
    pub(super) fn set_controller<const N: usize>(
        &self,
        controller: &mut TorqueController<N>,
        tree: &Tree<N>,
        dt_s: f32,
    ) -> Result<(), TrackerError> {
        self.check()?;
        let settings = self.effective(dt_s);
        let method = settings.state_error(tree)?;
        let outer = match settings.gains {
            GainsName::Uniform => None,
            GainsName::CompositeInertia => Some(OuterJoints::Locked),
            GainsName::ArticulatedInertia => Some(OuterJoints::Free),
        };
        let inertias = outer.map(|outer| reflected_inertia(tree, &JointStates::rest(tree), outer));
        let gains = Gains::critically_damped(settings.kp)?;
        let gains = if settings.implicit { gains.implicit(dt_s)? } else { gains };
        controller.init(tree, gains, method)?;
        match inertias {
            Some(inertias) => controller.set_pd_of_inertia(&inertias)?,
            None => controller.set_law(settings.law)?,
        }
        Ok(())
    }

    /// Returns the method of the state error, for a rig.
    fn state_error<const N: usize>(&self, tree: &Tree<N>) -> Result<Method<N>, TrackerError> {
        Ok(match self.method {
            MethodName::Local => Method::Local,
            MethodName::World => Method::World,
            MethodName::ManifoldProjection | MethodName::Recommended
                if !self.projection.resolved =>
            {
                Method::World
            }
            MethodName::ManifoldProjection
            | MethodName::Recommended
            | MethodName::ResolvedAcceleration => {
                Method::ResolvedAcceleration { weights: self.resolved.weights(tree)? }
            }
            MethodName::Egocentric => Method::Accumulated(References::egocentric(tree)),
            MethodName::Accumulated => {
                let (body, bodies) = (self.reference, tree.len());
                if body >= bodies {
                    return Err(SettingError::Reference { body, bodies }.into());
                }
                let seen_from: [_; N] = core::array::from_fn(|body| {
                    tree.is_ancestor(self.reference, body).then_some(self.reference)
                });
                let seen_from = seen_from.get(..tree.len()).unwrap_or_default();
                Method::Accumulated(References::new(tree, seen_from)?)
            }
            MethodName::LinearCompensation => Method::LinearCompensation {
                aims: match self.aim {
                    AimName::HeaviestChild => Aims::heaviest_child(tree),
                    AimName::AllChildren => Aims::all_children(tree),
                },
                settings: Compensation { beta: self.beta, rate_term: self.rate_term },
            },
        })
    }

    /// Returns the projection of the performance's poses onto the rig's, if the method has one. O(n).
    ///
    /// # Errors
    /// [`TrackerError`] if the weights are invalid, or invalid for this rig.
    #[inline(never)]
    pub fn projection<const N: usize>(
        &self,
        tree: &Tree<N>,
    ) -> Result<Option<ManifoldProjection<N>>, TrackerError> {
        if self.spelled_out().method != MethodName::ManifoldProjection {
            return Ok(None);
        }
        let ProjectionSettings { rotation_m, root_held, sweeps, .. } = self.projection;
        let weights = match self.projection.weights {
            WeightsName::Uniform => {
                let weights = [BodyWeight::new(1.0, rotation_m); N];
                BodyWeights::new(tree, weights.get(..tree.len()).unwrap_or_default())
            }
            WeightsName::Lengths => {
                let rest_pose = RestPose::of_tree(tree)?;
                let importance =
                    descendants_length(&rest_pose, IMPORTANCE_BASE_M, IMPORTANCE_DISCOUNT)?;
                BodyWeights::by_importance(tree, rotation_m, &importance)
            }
        };
        let weights = weights.map_err(ProjectionError::Weights)?;
        let projection = ManifoldProjection::new(tree, weights.as_slice())?.with_sweeps(sweeps);
        Ok(Some(if root_held { projection.with_root_held() } else { projection }))
    }

    /// Returns the settings of the observer, if there is one. These settings must already be explicit (see
    /// `effective`).
    pub(super) fn observer(&self, dt_s: f32) -> Result<Option<ObserverSettings>, TrackerError> {
        let ObserverChoice { bandwidth_rad_s, predict, .. } = self.observer;
        Ok(if bandwidth_rad_s > 0.0 {
            Some(ObserverSettings::extended_state(bandwidth_rad_s, dt_s)?)
        } else if predict {
            Some(ObserverSettings::differences(dt_s)?)
        } else {
            None
        })
    }
}

impl ResolvedSettings {
    fn weights<const N: usize>(self, tree: &Tree<N>) -> Result<BodyWeights<N>, TrackerError> {
        if self.position <= 0.0 {
            return Ok(BodyWeights::rotations(tree));
        }
        let weights = [BodyWeight::new(self.position, self.rotation_m); N];
        let weights = weights.get(..tree.len()).unwrap_or_default();
        Ok(BodyWeights::new(tree, weights).map_err(ProjectionError::Weights)?)
    }
}
