//! A setup: all that a run can be varied in, but its clip.

use serde::{Deserialize, Serialize};
use sinew_core::Workspace;
use sinew_core::tracker::{MethodName, Settings, Timing, Tracker, TrackerError};
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

/// A rig's tracker: as many commands can be on their way as the latency has steps, and one has just arrived.
pub type RigTracker = Tracker<CAPACITY, { MAX_LATENCY_STEPS + 1 }, CAPACITY>;

/// All that a run can be varied in, but its clip. The default is the paper's, with Local Space Error.
///
/// In TOML, every key may be left out:
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
    /// Where the figure's masses come from.
    pub body: BodySource,
    /// How large it is against the clip.
    pub dimensions: Dimensions,
    /// How the pelvis is held. Fixed, it stays where the clip begins, and the clip's too.
    pub root: Root,
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

    /// Puts the exact plant into the table of a setup that names none: rigs of the user have rotors, which the paper's
    /// plant has no coordinate for.
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

    /// Checks that the bodies which are named are the rig's, or without one the figure's; and of a rig, that nothing
    /// is set which makes the figure.
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

    /// The controller's settings with bodies by index. Only the method `accumulated` needs one to be there.
    pub(super) fn controller_of(&self, links: &[Link]) -> Result<Settings, SetupError> {
        let reference = self.reference(links.iter().map(|link| link.name.as_str()));
        let reference = match self.controller.method {
            MethodName::Accumulated => reference?,
            _ => reference.unwrap_or_default(),
        };
        Ok(self.controller.clone().named(|_| reference))
    }

    /// Index of the reference body among bodies of these names. The default is the root, whatever its name.
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

    /// The keys that differ from the default, with their values: `plant.substeps = 4`.
    pub fn differences(&self) -> Vec<String> {
        let mut lines = Vec::new();
        differences("", &self.to_table(), &Self::default().to_table(), &mut lines);
        lines
    }

    /// Returns the setup as TOML, every key with its value: equal for equal setups. Journals of sweeps have its hash:
    /// another order of keys, and no sweep that was begun before goes on.
    pub(super) fn to_toml(&self) -> String {
        toml::to_string(self).expect("every setup can be written in TOML")
    }

    /// Returns the setup as a TOML table: every key with its value.
    pub(super) fn to_table(&self) -> toml::Table {
        toml::Table::try_from(self).expect("every setup can be written in TOML")
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

    /// Makes the tracker of a rig, which acts once in `dt_s` seconds.
    ///
    /// # Errors
    /// [`RunError`] if the rig's numbers do not survive f32, or a setting does not go with it.
    pub(super) fn make_tracker(&self, rig: &Rig, dt_s: f64) -> Result<Box<RigTracker>, RunError> {
        let tree = rig.tree()?;
        let timing = Timing { dt_s: narrow(dt_s), latency_ticks: self.disturbance.latency_steps };
        self.controller.check().map_err(TrackerError::from)?;
        // Spelled out, since it is an evaluation's business to try drives that come too late.
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

/// A value as people write it: the core's numbers are f32, and in f64, which TOML has, they get digits that say
/// nothing.
fn short(value: &toml::Value) -> String {
    match value {
        toml::Value::Float(number) if f64::from(narrow(*number)).to_bits() == number.to_bits() => {
            format!("{:?}", narrow(*number))
        }
        other => other.to_string(),
    }
}
