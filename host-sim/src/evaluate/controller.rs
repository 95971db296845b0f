//! How the figure is controlled: the settings, and what they are made of.

use std::fmt;

use serde::{Deserialize, Serialize};
use sinew_core::Tree;
use sinew_core::projection::{BodyWeight, BodyWeights, DEFAULT_SWEEPS};
use sinew_core::state_error::{Aims, Compensation, Method, RateTerm, References};
use sinew_firmware::recommended::{BANDWIDTH_RAD_S, ROTATION_M};

use crate::figure::{BODIES, BODY_COUNT, Root};

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
    /// How the joints share what their drives have together, `disturbance.supply_nm`.
    pub sharing: SharingName,
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
            sharing: SharingName::Alike,
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
    /// How that is shared among the bodies.
    pub weights: WeightsName,
    /// Whether the pelvis stays where the clip has it.
    pub root_held: bool,
    /// Gauss-Newton steps for each frame.
    pub sweeps: u8,
    /// Whether the bodies' errors are fed by resolved acceleration instead of to their own joints.
    pub resolved: bool,
}

impl Default for ProjectionSettings {
    fn default() -> Self {
        Self {
            rotation_m: f64::from(ROTATION_M),
            weights: WeightsName::Uniform,
            root_held: false,
            sweeps: DEFAULT_SWEEPS,
            resolved: false,
        }
    }
}

/// How the weight of turns is shared among the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WeightsName {
    /// All have the same.
    Uniform,
    /// By importance: the length of what hangs on a body's joint. The mean is `rotation_m`.
    Lengths,
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
    pub(super) fn weights<const N: usize>(self, tree: &Tree<N>) -> BodyWeights<N> {
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

/// How joints share what their drives have together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SharingName {
    /// All torques are cut by the same factor.
    Alike,
    /// What is cut is least in squares, by the motion of the skin that it makes: weights `(lᵢ / Iᵢ)²`, of the joints' levers
    /// and of the articulated inertias that their drives work against in the rest pose.
    Importance,
    /// What carries the figure is left, and what accelerates it is cut by the same factor.
    Accelerations,
}

/// What the gains of a PD controller are multiplied with, joint by joint.
///
/// The rule: a joint's gains are those of unit inertia (kp, and kd for critical damping) times the constant
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

impl ControllerSettings {
    /// The setting for real rigs: manifold projection on aligned targets, with an observer that cancels what
    /// the model has wrong and looks ahead over the latency. Gains and the projection's weight stay.
    #[must_use]
    pub fn recommended(self) -> Self {
        Self {
            method: MethodName::ManifoldProjection,
            differences: DifferencesName::Aligned,
            observer: ObserverChoice {
                bandwidth_rad_s: f64::from(BANDWIDTH_RAD_S),
                cancel: true,
                predict: true,
            },
            implicit: true,
            ..self
        }
    }

    /// The method for a figure.
    pub(super) fn method(&self, tree: &Tree<BODY_COUNT>) -> Method<BODY_COUNT> {
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
