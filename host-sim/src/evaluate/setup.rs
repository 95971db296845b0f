//! A setup: all that a run can be varied in, but its clip.

use serde::{Deserialize, Serialize};
use sinew_core::control::{ControlLaw, Gains};
use sinew_core::dynamics::{OuterJoints, reflected_inertia};
use sinew_core::importance::{RestPose, descendants_length};
use sinew_core::projection::{BodyWeight, BodyWeights, ManifoldProjection, ProjectionError};
use sinew_core::{Controller, JointStates, Tree};
use thiserror::Error;

use super::controller::{
    ControllerSettings, GainsName, LawName, MethodName, ObserverChoice, ProjectionSettings,
    WeightsName, narrow,
};
use super::disturbance::Disturbance;
use super::error::RunError;
use crate::figure::{BODY_COUNT, BodyModel, BodyModelError, Dimensions, FigureMotion, Subject};
use crate::parse_message::parse_message;
use crate::plant::PlantSettings;
use crate::weights;

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
            toml::from_str(toml).map_err(|error| SetupError::Toml(parse_message(&error)))?;
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
                let (path, message) = (error.path(), parse_message(&error.inner().message()));
                // The path of the whole table is a dot.
                SetupError::Toml(match path.iter().next() {
                    Some(_) => format!("{path}: {message}"),
                    None => message,
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
        let rotation_m = narrow(rotation_m);
        let weights = match controller.projection.weights {
            WeightsName::Uniform => {
                BodyWeights::new(tree, &[BodyWeight::new(1.0, rotation_m); BODY_COUNT])
            }
            WeightsName::Lengths => {
                let usual = weights::Settings::default();
                let base_m = narrow(usual.base_of(weights::Method::Lengths));
                let rest_pose = RestPose::of_tree(tree)?;
                let importance = descendants_length(&rest_pose, base_m, narrow(usual.discount))?;
                BodyWeights::by_importance(tree, rotation_m, &importance)
            }
        };
        let weights = weights.map_err(ProjectionError::Weights)?;
        let projection = ManifoldProjection::new(tree, weights.as_slice())?.with_sweeps(sweeps);
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
