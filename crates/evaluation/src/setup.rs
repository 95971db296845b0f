//! A setup: all settings of a run, except its clip.

use serde::{Deserialize, Serialize};
use sinew_core::Workspace;
use sinew_core::control::ControlLaw;
use sinew_core::tracker::{
    DesiredVelocity, Differences, MethodName, ObserverChoice, Settings, Timing, Tracker,
    TrackerError,
};
use sinew_figure::plant::PlantSettings;
use sinew_figure::{BODIES, BodyModel, BodyModelError, Dimensions, FigureMotion, Root, Subject};
use sinew_host_util::parse_message;
use sinew_rig::mechanism::{Link, Mechanism};

use super::capacity::{CAPACITY, MAX_LATENCY_STEPS};
use super::controller::{BodyName, ControllerSettings, narrow};
use super::disturbance::Disturbance;
use super::error::{RunError, SetupError};
use super::rig::Rig;
use super::supply::make_supply;

/// Tracker of a rig, with room for the maximum latency: one command per step of latency, and one that has just
/// arrived.
pub type RigTracker = Tracker<CAPACITY, { MAX_LATENCY_STEPS + 1 }, CAPACITY>;

/// All settings of a run, except its clip. The default is the paper's setup with Local Space Error.
///
/// In TOML, every key may be omitted:
///
/// ```
/// use sinew_core::tracker::MethodName;
/// use sinew_evaluation::Setup;
/// let setup = Setup::parse("controller.method = 'world'\nplant.substeps = 2")?;
/// assert_eq!(setup.controller.method, MethodName::World);
/// assert!(Setup::parse("controller.kp = nan").is_err());
/// # Ok::<(), sinew_evaluation::SetupError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Setup {
    /// Source of the figure's masses.
    pub body: BodySource,
    /// Dimensions of the figure relative to the clip.
    pub dimensions: Dimensions,
    /// Support of the pelvis. A fixed pelvis stays where the clip begins, and the clip's pelvis stays there too.
    pub root: Root,
    /// Settings of the controller.
    pub controller: ControllerSettings,
    /// Settings of the simulation.
    pub plant: PlantSettings,
    /// Differences between the rig and the controller's model of it.
    pub disturbance: Disturbance,
    /// Subject whose masses `hanavan_kwon` uses; `None` for the built-in subject.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub subject: Option<Subject>,
}

/// The source of the figure's masses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum BodySource {
    /// De Leva's segment regressions (1996), 73 kg.
    #[default]
    DeLeva,
    /// Hanavan's solids as modified by Kwon, for a measured subject. The paper uses this model.
    HanavanKwon,
}

/// Kind of a tracker with the paper's differences, without projection, observer and supply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PlainTracker {
    method: MethodName,
    /// Settings of Linear Compensation.
    compensation: Option<(u32, u8, u8)>,
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

    /// Selects the exact plant in the table of a setup that names no plant: users' rigs have rotors, for which the
    /// paper's plant has no coordinate.
    pub fn prefer_exact_plant(table: &mut toml::Table) {
        let plant = table.entry("plant").or_insert_with(|| toml::Table::new().into());
        if let Some(plant) = plant.as_table_mut() {
            plant.entry("kind").or_insert_with(|| "articulated".into());
        }
    }

    /// Checks every value; NaN is refused.
    ///
    /// # Errors
    /// [`SetupError`].
    pub fn check(&self) -> Result<(), SetupError> {
        let value = |key: &str, (expected, value)| {
            Err(SetupError::Value { key: key.to_owned(), expected, value })
        };
        if let Some((key, expected, found)) = self.dimensions.fault() {
            return value(&format!("dimensions.{key}"), (expected, found));
        }
        if let Some((key, expected, found)) = self.disturbance.find_fault() {
            return value(&format!("disturbance.{key}"), (expected, found));
        }
        if self.subject.is_some() && self.body != BodySource::HanavanKwon {
            return Err(SetupError::SubjectWithoutBody);
        }
        self.controller.check()?;
        if !(1..=1000).contains(&self.plant.substeps) {
            let found = self.plant.substeps as f64;
            return value("plant.substeps", ("a number from 1 to 1000", found));
        }
        Ok(())
    }

    /// Checks that named bodies exist in the rig, or without a rig in the figure. For a rig it also checks that no
    /// setting of the figure's construction is present.
    ///
    /// # Errors
    /// [`SetupError::NoSuchBody`], [`SetupError::OfTheFigure`].
    pub fn check_for(&self, rig: Option<&Mechanism>) -> Result<(), SetupError> {
        let Some(rig) = rig else {
            return self.reference(BODIES.iter().map(|body| body.name)).map(|_| ());
        };
        let Self { body, dimensions, root, subject, .. } = Self::default();
        for (key, same) in [
            ("body", self.body == body),
            ("dimensions", self.dimensions == dimensions),
            ("root", self.root == root),
            ("subject", self.subject == subject),
        ] {
            if !same {
                return Err(SetupError::OfTheFigure { key });
            }
        }
        self.reference(rig.bodies.iter().map(|link| link.name.as_str())).map(|_| ())
    }

    /// Returns the controller's settings with bodies by index. Only the method `accumulated` requires an existing
    /// reference body.
    pub(super) fn controller_of(&self, links: &[Link]) -> Result<Settings, SetupError> {
        let reference = self.reference(links.iter().map(|link| link.name.as_str()));
        let reference = match self.controller.method {
            MethodName::Accumulated => reference?,
            _ => reference.unwrap_or_default(),
        };
        Ok(self.controller.clone().named(|_| reference))
    }

    /// Returns the index of the reference body among bodies of these names. The default is the root, whatever its
    /// name.
    fn reference<'a>(
        &self,
        names: impl Iterator<Item = &'a str> + Clone,
    ) -> Result<usize, SetupError> {
        if self.controller.reference == BodyName::default() {
            return Ok(0);
        }
        let BodyName(wanted) = &self.controller.reference;
        names.clone().position(|name| name == wanted).ok_or_else(|| SetupError::NoSuchBody {
            names: names.collect::<Vec<_>>().join(", "),
            found: wanted.clone(),
        })
    }

    /// Returns the kind of a tracker that [`sinew_batch::Trackers`] can replace, as far as settings decide it; `None`
    /// for other trackers. Trackers of one kind can take their ticks together.
    pub(super) fn plain_tracker(&self) -> Option<PlainTracker> {
        let controller = &self.controller;
        let is_plain = matches!(
            controller.method,
            MethodName::Local | MethodName::World | MethodName::LinearCompensation
        ) && controller.differences == Differences::Forward
            && controller.desired_velocity == DesiredVelocity::Bodies
            && controller.observer == ObserverChoice::default()
            && controller.law == ControlLaw::InverseDynamics
            && self.disturbance.supply_nm == f64::INFINITY;
        is_plain.then(|| PlainTracker {
            method: controller.method,
            compensation: (controller.method == MethodName::LinearCompensation).then(|| {
                (controller.beta.to_bits(), controller.rate_term as u8, controller.aim as u8)
            }),
        })
    }

    /// Lists the keys that differ from the default, with their values: `plant.substeps = 4`.
    pub fn differences(&self) -> Vec<String> {
        let mut lines = Vec::new();
        differences("", &self.to_table(), &Self::default().to_table(), &mut lines);
        lines
    }

    /// Returns the setup as TOML with every key: equal setups give equal texts. Journals of sweeps contain a hash
    /// of it; a change of the order of keys would prevent the resumption of existing sweeps.
    pub(super) fn to_toml(&self) -> String {
        toml::to_string(self).expect("every setup can be written in TOML")
    }

    /// Returns the setup as a TOML table with every key and its value.
    pub(super) fn to_table(&self) -> toml::Table {
        toml::Table::try_from(self).expect("every setup can be written in TOML")
    }

    /// Builds the figure as the controller knows it, with the dimensions of a clip and of this setup.
    ///
    /// # Errors
    /// [`BodyModelError`] if no body model fits the clip's skeleton.
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

    /// Creates the tracker of a rig, which runs once every `dt_s` seconds.
    ///
    /// # Errors
    /// [`RunError`] if the rig's numbers are not representable in f32, or a setting does not fit the rig.
    pub(super) fn make_tracker(&self, rig: &Rig, dt_s: f64) -> Result<Box<RigTracker>, RunError> {
        let tree = rig.tree()?;
        let timing = Timing { dt_s: narrow(dt_s), latency_ticks: self.disturbance.latency_steps };
        self.controller.check().map_err(TrackerError::from)?;
        // `effective` replaces the recommended method by its settings. A tracker with explicit settings does not
        // refuse a late drive, and an evaluation tests late drives too.
        let settings = self.controller_of(rig.links())?.effective(timing.dt_s);
        let supply = make_supply(
            self.controller.sharing,
            self.disturbance.supply_nm,
            &tree,
            rig.importance_weights(),
        )?;
        let tracker = Tracker::with_workspace(tree, &settings, timing, Workspace::resolving())?
            .with_limits(&self.disturbance.torque_limits(rig.links()))?
            .with_supply(supply)?;
        Ok(Box::new(tracker))
    }
}

fn differences(prefix: &str, table: &toml::Table, from: &toml::Table, lines: &mut Vec<String>) {
    for (key, value) in table {
        match (value, from.get(key)) {
            (toml::Value::Table(inner), Some(toml::Value::Table(from))) => {
                differences(&format!("{prefix}{key}."), inner, from, lines);
            }
            (value, from) if from != Some(value) => {
                lines.push(format!("{prefix}{key} = {}", short(value)));
            }
            _ => {}
        }
    }
}

/// Formats a value for people: an f32 of the core is not printed with the meaningless extra digits of TOML's f64.
fn short(value: &toml::Value) -> String {
    match value {
        toml::Value::Float(number) if f64::from(narrow(*number)).to_bits() == number.to_bits() => {
            format!("{:?}", narrow(*number))
        }
        other => other.to_string(),
    }
}
