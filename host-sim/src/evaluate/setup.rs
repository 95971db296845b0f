//! A setup: all that a run can be varied in, but its clip.

use std::fmt;

use serde::{Deserialize, Serialize};
use sinew_core::control::{ControlLaw, Gains};
use sinew_core::dynamics::{OuterJoints, reflected_inertia};
use sinew_core::projection::{BodyWeight, BodyWeights, DEFAULT_SWEEPS, ManifoldProjection};
use sinew_core::state_error::{Aims, Compensation, Method, RateTerm, References};
use sinew_core::{Controller, JointStates, Tree};
use thiserror::Error;

use super::disturbance::Disturbance;
use super::error::RunError;
use crate::figure::{BODIES, BODY_COUNT, BodyModel, BodyModelError, Dimensions, Root, Subject};
use crate::mocap::FigureMotion;
use crate::plant::PlantSettings;

/// All that a run can be varied in, but its clip. The default is the paper's, with Local Space Error.
///
/// In TOML, every key may be left out:
///
/// ```
/// use sinew_sim::evaluate::{MethodName, Setup};
/// let setup = Setup::parse("controller.method = 'world'\nplant.substeps = 2")?;
/// assert_eq!(setup.controller.method, MethodName::World);
/// assert!(Setup::parse("controller.kp = nan").is_err());
/// # Ok::<(), sinew_sim::evaluate::SetupError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Setup {
    /// Where the figure's masses come from.
    pub body: BodySource,
    /// How large it is against the clip.
    pub dimensions: Dimensions,
    /// How it is controlled.
    pub controller: ControllerSettings,
    /// How it is simulated.
    pub plant: PlantSettings,
    /// What the controller does not know of it.
    pub disturbance: Disturbance,
    /// The subject that `hanavan_kwon` takes the masses from; without one, the built-in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub subject: Option<Subject>,
}

/// Where the masses of the figure come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum BodySource {
    /// De Leva's segment regressions (1996), 73 kg.
    #[default]
    DeLeva,
    /// Hanavan's solids as modified by Kwon, of a measured subject: the paper's.
    HanavanKwon,
}

/// How the figure is controlled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ControllerSettings {
    /// How the state error is measured.
    pub method: MethodName,
    /// The body that its descendants are seen from, for `accumulated`; all others are seen from the world.
    pub reference: BodyName,
    /// Weight β of Linear Compensation: 0 is World Space Error, 1 the paper's.
    pub beta: f64,
    /// The derivative of the compensating rotation.
    pub rate_term: RateTermName,
    /// What a body of several children aims at in Linear Compensation.
    pub aim: AimName,
    /// The manifold projection, for the methods that have it.
    pub projection: ProjectionSettings,
    /// What resolved acceleration weighs where not every body can have its acceleration.
    pub resolved: ResolvedSettings,
    /// How the state is estimated from what the sensors tell.
    pub observer: ObserverChoice,
    /// Which frames desired velocities and accelerations are differences of.
    pub differences: DifferencesName,
    /// Where the desired velocities come from, for forward differences.
    pub desired_velocity: DesiredVelocity,
    /// How the error becomes a torque.
    pub law: LawName,
    /// What the gains of `pd` are multiplied with, joint by joint.
    pub gains: GainsName,
    /// Stiffness, critically damped: in 1/s², or in N m/rad for `pd` with uniform gains.
    pub kp: f64,
    /// Whether the gains are those of stable PD: applied to the state one period ahead.
    pub implicit: bool,
    /// How the pelvis is held. Fixed, it stays where the clip begins, and the clip's too.
    pub root: Root,
}

impl Default for ControllerSettings {
    fn default() -> Self {
        Self {
            method: MethodName::Local,
            reference: BodyName(0),
            beta: 1.0,
            rate_term: RateTermName::Corrected,
            aim: AimName::HeaviestChild,
            projection: ProjectionSettings::default(),
            resolved: ResolvedSettings::default(),
            observer: ObserverChoice::default(),
            differences: DifferencesName::Forward,
            desired_velocity: DesiredVelocity::Bodies,
            law: LawName::InverseDynamics,
            gains: GainsName::Uniform,
            kp: 200.0,
            implicit: false,
            root: Root::Driven,
        }
    }
}

/// A method of measuring the state error, as tables and options name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum MethodName {
    /// Local Space Error: every joint as its parent sees it.
    Local,
    /// World Space Error.
    World,
    /// Every body as the pelvis sees it, the pelvis as the world sees it.
    Egocentric,
    /// The descendants of `controller.reference` as that body sees them, all others as the world does.
    Accumulated,
    /// Linear Compensation Error: bodies turn so that their child reaches its goal.
    LinearCompensation,
    /// World Space Error of the figure's own pose that is nearest to the clip's.
    ManifoldProjection,
    /// Joint accelerations that make every body's error in the world obey one law.
    ResolvedAcceleration,
    /// For real rigs: manifold projection, aligned differences, implicit gains, an observer that looks ahead.
    Recommended,
}

/// How the figure's pose nearest to the clip's is found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ProjectionSettings {
    /// What a turn counts against a distance: 1 rad as much as this many metres.
    pub rotation_m: f64,
    /// Whether the pelvis stays where the clip has it.
    pub root_held: bool,
    /// Gauss-Newton steps for each frame.
    pub sweeps: u8,
    /// Whether the bodies' errors are fed by resolved acceleration instead of to their own joints.
    pub resolved: bool,
}

impl Default for ProjectionSettings {
    fn default() -> Self {
        Self { rotation_m: 0.5, root_held: false, sweeps: DEFAULT_SWEEPS, resolved: false }
    }
}

/// How the state is estimated from what the sensors tell.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ObserverChoice {
    /// Bandwidth of an extended state observer; 0 for backward differences.
    pub bandwidth_rad_s: f64,
    /// Whether the disturbance that it learns is cancelled.
    pub cancel: bool,
    /// Whether the latency is known: commands are made for the state that they will meet.
    pub predict: bool,
}

/// What resolved acceleration weighs where not every body can have its acceleration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ResolvedSettings {
    /// What the acceleration of a body's joint counts, in m/s²; 0: only that of the pelvis.
    pub position: f64,
    /// What an angular acceleration counts against it: 1 rad/s² as much as so many m/s².
    pub rotation_m: f64,
}

impl Default for ResolvedSettings {
    fn default() -> Self {
        Self { position: 0.0, rotation_m: 1.0 }
    }
}

impl ResolvedSettings {
    fn weights<const N: usize>(self, tree: &Tree<N>) -> BodyWeights<N> {
        if self.position <= 0.0 {
            return BodyWeights::rotations(tree);
        }
        let weight = BodyWeight::new(narrow(self.position), narrow(self.rotation_m));
        BodyWeights::new(tree, &vec![weight; tree.len()]).expect("a checked setup")
    }
}

/// Which frames desired velocities and accelerations are differences of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DifferencesName {
    /// This one and the next two: the paper's.
    Forward,
    /// The one before, this one and the next, so that velocities are of the same instant as measured ones.
    Aligned,
    /// This one and the two before: for a live stream, whose next frame is not known.
    Live,
}

/// The sign of the rate term of Linear Compensation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RateTermName {
    /// That of the rotation which is applied.
    Corrected,
    /// The paper's.
    AsPrinted,
    /// No term.
    None,
}

/// What a body of several children aims at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AimName {
    /// The child with the heaviest subtree.
    HeaviestChild,
    /// All of them, by least squares.
    AllChildren,
}

/// Where desired velocities come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DesiredVelocity {
    /// Forward differences of the bodies' world poses.
    Bodies,
    /// Forward differences of the joints' poses.
    Joints,
    /// Backward differences of the bodies' world poses: of the same instant as the measured velocities.
    Backward,
    /// Omitted: every body is to stand still.
    Zero,
}

/// How an error becomes a torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LawName {
    /// PD and inverse dynamics, eq. (11).
    InverseDynamics,
    /// PD alone, without a model of the dynamics: what a servo does by itself.
    Pd,
}

/// What the gains of a PD controller are multiplied with, joint by joint.
///
/// The rule: a joint's gains are those of unit inertia (kp, and kv for critical damping) times the constant
/// inertia that its drive works against in the figure's rest pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GainsName {
    /// Nothing: all joints have the same.
    Uniform,
    /// The inertia of all bodies beyond the joint, their joints held: the composite-rigid-body inertia.
    CompositeInertia,
    /// The inertia of all bodies beyond the joint, their joints giving way: the articulated-body inertia.
    ArticulatedInertia,
}

/// A body of the figure, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
pub struct BodyName(pub usize);

impl TryFrom<String> for BodyName {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        BODIES.iter().position(|body| body.name == name).map(Self).ok_or_else(|| {
            let names: Vec<_> = BODIES.iter().map(|body| body.name).collect();
            format!("expected a body of the figure ({}), found `{name}`", names.join(", "))
        })
    }
}

impl From<BodyName> for &'static str {
    fn from(BodyName(body): BodyName) -> Self {
        BODIES[body].name
    }
}

/// A setup that cannot be.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SetupError {
    /// Not the TOML of a setup.
    #[error("{0}")]
    Toml(String),
    /// A subject for a body that needs none.
    #[error("subject: expected with body = \"hanavan_kwon\" only")]
    SubjectWithoutBody,
    /// An observer of accelerations for a law that commands none.
    #[error(
        "controller.law: expected \"inverse_dynamics\" with an observer, which the method \"recommended\" has too; found \"pd\""
    )]
    ObserverWithoutDynamics,
    /// Gains of joints for a law that knows their inertia itself.
    #[error("controller.gains: expected \"uniform\", but with controller.law = \"pd\"")]
    GainsWithoutPd,
    /// Gains of a period for a law that has no unit of inertia.
    #[error(
        "controller.implicit: expected false with uniform gains of controller.law = \"pd\", which are not per unit of inertia"
    )]
    ImplicitWithoutInertia,
    /// A value out of its range.
    #[error("{key}: expected {expected}, found {value}")]
    Value {
        /// The key, dotted.
        key: String,
        /// What it may be.
        expected: &'static str,
        /// What it is.
        value: f64,
    },
}

impl Setup {
    /// Reads a setup from TOML text and checks it.
    ///
    /// # Errors
    /// [`SetupError`].
    pub fn parse(toml: &str) -> Result<Self, SetupError> {
        let setup: Self =
            toml::from_str(toml).map_err(|error| SetupError::Toml(error.to_string()))?;
        setup.check()?;
        Ok(setup)
    }

    /// Reads a setup from a TOML table and checks it.
    ///
    /// # Errors
    /// [`SetupError`].
    pub fn from_table(table: toml::Table) -> Result<Self, SetupError> {
        let setup: Self =
            serde_path_to_error::deserialize(toml::Value::Table(table)).map_err(|error| {
                let (path, message) = (error.path(), error.inner().message());
                // The path of the whole table is a dot.
                SetupError::Toml(match path.iter().next() {
                    Some(_) => format!("{path}: {message}"),
                    None => message.to_owned(),
                })
            })?;
        setup.check()?;
        Ok(setup)
    }

    /// Checks every value; NaN is refused.
    ///
    /// # Errors
    /// [`SetupError`].
    pub fn check(&self) -> Result<(), SetupError> {
        let value = |key: &str, (expected, value)| {
            Err(SetupError::Value { key: key.to_owned(), expected, value })
        };
        let controller = self.effective_controller();
        if let Some((key, expected, found)) = self.dimensions.fault() {
            return value(&format!("dimensions.{key}"), (expected, found));
        }
        if let Some((key, expected, found)) = self.disturbance.fault() {
            return value(&format!("disturbance.{key}"), (expected, found));
        }
        if self.subject.is_some() && self.body != BodySource::HanavanKwon {
            return Err(SetupError::SubjectWithoutBody);
        }
        let ControllerSettings { beta, kp, law, gains, projection, resolved, implicit, .. } =
            controller;
        if gains != GainsName::Uniform && law != LawName::Pd {
            return Err(SetupError::GainsWithoutPd);
        }
        let ObserverChoice { bandwidth_rad_s, cancel, predict } = controller.observer;
        if law == LawName::Pd && (predict || bandwidth_rad_s > 0.0) {
            return Err(SetupError::ObserverWithoutDynamics);
        }
        if implicit && law == LawName::Pd && gains == GainsName::Uniform {
            return Err(SetupError::ImplicitWithoutInertia);
        }
        if !(0.0..=2.0).contains(&beta) {
            return value("controller.beta", ("a weight from 0 to 2", beta));
        }
        if !(0.01..=100.0).contains(&projection.rotation_m) {
            let expected = "a length from 0.01 to 100 m";
            return value("controller.projection.rotation_m", (expected, projection.rotation_m));
        }
        let heaviest = 1e4 * resolved.rotation_m * resolved.rotation_m;
        if resolved.position != 0.0 && !(1e-6..=heaviest).contains(&resolved.position) {
            let expected = "0, or a weight from 1e-6 to 1e4 times the square of rotation_m";
            return value("controller.resolved.position", (expected, resolved.position));
        }
        if !(0.01..=100.0).contains(&resolved.rotation_m) {
            let expected = "a length from 0.01 to 100 m";
            return value("controller.resolved.rotation_m", (expected, resolved.rotation_m));
        }
        if !(0.0..=1000.0).contains(&bandwidth_rad_s) {
            let expected = "a bandwidth from 0 to 1000 rad/s";
            return value("controller.observer.bandwidth_rad_s", (expected, bandwidth_rad_s));
        }
        if cancel && bandwidth_rad_s <= 0.0 {
            let expected =
                "a bandwidth above 0 rad/s: without an observer there is nothing to cancel";
            return value("controller.observer.bandwidth_rad_s", (expected, bandwidth_rad_s));
        }
        if projection.sweeps == 0 {
            return value("controller.projection.sweeps", ("a number from 1 to 255", 0.0));
        }
        if !(kp > 0.0 && kp.is_finite()) {
            return value("controller.kp", ("a finite number above 0", kp));
        }
        if !(1..=1000).contains(&self.plant.substeps) {
            let found = self.plant.substeps as f64;
            return value("plant.substeps", ("a number from 1 to 1000", found));
        }
        Ok(())
    }

    /// How the figure is controlled in the end: the method `recommended` stands for several settings.
    pub fn effective_controller(&self) -> ControllerSettings {
        match self.controller.method {
            MethodName::Recommended => self.controller.recommended(),
            _ => self.controller,
        }
    }

    /// The keys that differ from the default, with their values: `plant.substeps = 4`.
    pub fn differences(&self) -> Vec<String> {
        let table = |setup: &Self| {
            toml::Table::try_from(setup).expect("every setup can be written in TOML")
        };
        let mut lines = Vec::new();
        differences("", &table(self), &table(&Self::default()), &mut lines);
        lines
    }

    /// The figure as the controller knows it, on the dimensions of a clip and this setup.
    ///
    /// # Errors
    /// [`BodyModelError`] if the clip's skeleton cannot be given a body.
    pub fn model(&self, motion: &FigureMotion) -> Result<BodyModel, BodyModelError> {
        let model = match self.body {
            BodySource::DeLeva => BodyModel::from_motion(motion)?,
            BodySource::HanavanKwon => {
                let subject = self.subject.as_ref().unwrap_or_else(|| Subject::built_in());
                BodyModel::hanavan_kwon(motion, subject)?
            }
        };
        Ok(model.scaled_by(&self.dimensions.factors()))
    }

    /// The projection of the clip's poses on a figure's, if its method has one.
    pub(super) fn projection(
        &self,
        tree: &Tree<BODY_COUNT>,
    ) -> Result<Option<ManifoldProjection<BODY_COUNT>>, RunError> {
        let controller = self.effective_controller();
        if controller.method != MethodName::ManifoldProjection {
            return Ok(None);
        }
        let ProjectionSettings { rotation_m, root_held, sweeps, .. } = controller.projection;
        let weights = [BodyWeight::new(1.0, narrow(rotation_m)); BODY_COUNT];
        let projection = ManifoldProjection::new(tree, &weights)?.with_sweeps(sweeps);
        Ok(Some(if root_held { projection.with_root_held() } else { projection }))
    }

    /// The controller of a figure, which acts once in `dt_s` seconds.
    ///
    /// # Errors
    /// [`RunError`] if the figure's numbers do not survive f32, or the method does not go with the law.
    pub(super) fn controller(
        &self,
        model: &BodyModel,
        dt_s: f64,
    ) -> Result<Controller<BODY_COUNT>, RunError> {
        let settings = self.effective_controller();
        let tree = model.tree(settings.root)?;
        let method = settings.method(&tree);
        let law = match settings.law {
            LawName::InverseDynamics => ControlLaw::InverseDynamics,
            LawName::Pd => ControlLaw::ProportionalDerivative,
        };
        let outer = match settings.gains {
            GainsName::Uniform => None,
            GainsName::CompositeInertia => Some(OuterJoints::Locked),
            GainsName::ArticulatedInertia => Some(OuterJoints::Free),
        };
        let inertias =
            outer.map(|outer| reflected_inertia(&tree, &JointStates::rest(&tree), outer));
        let gains = Gains::critically_damped(narrow(settings.kp))?;
        let gains = if settings.implicit { gains.implicit(narrow(dt_s))? } else { gains };
        let controller =
            Controller::new(tree, gains, method)?.with_limits(&self.disturbance.torque_limits())?;
        if let Some(inertias) = inertias {
            return Ok(controller.with_pd_of_inertia(&inertias)?);
        }
        Ok(controller.with_law(law)?)
    }
}

fn differences(prefix: &str, table: &toml::Table, from: &toml::Table, lines: &mut Vec<String>) {
    for (key, value) in table {
        match (value, from.get(key)) {
            (toml::Value::Table(inner), Some(toml::Value::Table(from))) => {
                differences(&format!("{prefix}{key}."), inner, from, lines);
            }
            (value, from) if from != Some(value) => lines.push(format!("{prefix}{key} = {value}")),
            _ => {}
        }
    }
}

impl ControllerSettings {
    /// The setting for real rigs: manifold projection on aligned targets, with an observer that cancels what
    /// the model has wrong and looks ahead over the latency. Gains and the projection's weight stay.
    #[must_use]
    pub const fn recommended(self) -> Self {
        Self {
            method: MethodName::ManifoldProjection,
            differences: DifferencesName::Aligned,
            observer: ObserverChoice { bandwidth_rad_s: 100.0, cancel: true, predict: true },
            implicit: true,
            ..self
        }
    }

    /// The method for a figure.
    fn method(&self, tree: &Tree<BODY_COUNT>) -> Method<BODY_COUNT> {
        match self.method {
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
                Method::ResolvedAcceleration { weights: self.resolved.weights(tree) }
            }
            MethodName::Egocentric => Method::Accumulated(References::egocentric(tree)),
            MethodName::Accumulated => {
                let BodyName(reference) = self.reference;
                let seen_from: [_; BODY_COUNT] = std::array::from_fn(|body| {
                    tree.is_ancestor(reference, body).then_some(reference)
                });
                let references = References::new(tree, &seen_from);
                Method::Accumulated(references.expect("ancestors and nothing else"))
            }
            MethodName::LinearCompensation => Method::LinearCompensation {
                aims: match self.aim {
                    AimName::HeaviestChild => Aims::heaviest_child(tree),
                    AimName::AllChildren => Aims::all_children(tree),
                },
                settings: Compensation {
                    beta: narrow(self.beta),
                    rate_term: self.rate_term.into(),
                },
            },
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
pub(super) fn narrow(x: f64) -> f32 {
    x as f32
}

impl From<RateTermName> for RateTerm {
    fn from(name: RateTermName) -> Self {
        match name {
            RateTermName::Corrected => Self::Corrected,
            RateTermName::AsPrinted => Self::AsPrinted,
            RateTermName::None => Self::None,
        }
    }
}

impl MethodName {
    /// The paper's three, in its order.
    pub const PAPER: [Self; 3] = [Self::Local, Self::World, Self::LinearCompensation];

    /// All that need no reference.
    pub const ALL: [Self; 7] = [
        Self::Local,
        Self::World,
        Self::Egocentric,
        Self::LinearCompensation,
        Self::ManifoldProjection,
        Self::ResolvedAcceleration,
        Self::Recommended,
    ];

    /// The name in options and files.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Local => "local",
            Self::World => "world",
            Self::Egocentric => "egocentric",
            Self::Accumulated => "accumulated",
            Self::LinearCompensation => "linear_compensation",
            Self::ManifoldProjection => "manifold_projection",
            Self::ResolvedAcceleration => "resolved_acceleration",
            Self::Recommended => "recommended",
        }
    }

    /// The name in headings.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Local => "Local",
            Self::World => "World",
            Self::Egocentric => "Egocentric",
            Self::Accumulated => "Accumulated",
            Self::LinearCompensation => "Linear Compensation",
            Self::ManifoldProjection => "Manifold Projection",
            Self::ResolvedAcceleration => "Resolved Acceleration",
            Self::Recommended => "Recommended",
        }
    }
}

impl fmt::Display for MethodName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
