//! Options that make a [`Setup`].

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use sinew_evaluation::{BodySource, Setup};
use sinew_figure::Subject;
use sinew_figure::plant::PlantKind;
use sinew_mocap::{Kind, read};
use sinew_rig::Mechanism;

/// Options that make a [`Setup`]. More specific options override more general ones.
#[derive(Debug, clap::Args)]
pub(super) struct SetupArgs {
    /// Plant that simulates the figure or the rig. Default: `rapier` as in the paper; `articulated` with --rig, and for
    /// `latency` and `robustness`.
    #[arg(long, value_enum, value_name = "PLANT")]
    plant: Option<PlantKind>,

    /// Source of the figure's masses. Default: `hanavan_kwon` if --subject is given, otherwise `de_leva`.
    #[arg(long, value_enum, value_name = "BODY", conflicts_with = "rig")]
    body: Option<BodySource>,

    /// Measured subject in TOML, for the body `hanavan_kwon`; see `sinew evaluate figure --help`.
    #[arg(long, value_name = "FILE", conflicts_with = "rig")]
    subject: Option<PathBuf>,

    /// File with the settings of a run, in TOML. `sinew evaluate --format json` prints all keys.
    #[arg(long, value_name = "FILE")]
    setup: Option<PathBuf>,

    /// Set one key of the setup, such as `plant.substeps=4` or `controller.rate_term=none`. May be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl SetupArgs {
    /// Returns the input files, each with its role.
    pub(super) fn files(&self) -> Vec<(&'static str, Option<&Path>)> {
        vec![("subject", self.subject.as_deref()), ("setup", self.setup.as_deref())]
    }

    /// Returns the setup. If no plant is selected, it has the exact plant instead of the paper's.
    pub(super) fn setup_on_exact(&self, rig: Option<&Mechanism>) -> anyhow::Result<Setup> {
        self.read(rig, true)
    }

    /// Returns the setup for a user's rig, or for the figure.
    pub(super) fn setup(&self, rig: Option<&Mechanism>) -> anyhow::Result<Setup> {
        self.read(rig, false)
    }

    /// Reads the setup. With `exact`, the default plant is the exact one.
    fn read(&self, rig: Option<&Mechanism>, exact: bool) -> anyhow::Result<Setup> {
        let mut setup = toml::Table::new();
        if let Some(file) = &self.setup {
            let text = read::text_of(file, "a setup in TOML", &[Kind::Toml])
                .with_context(|| format!("{}", file.display()))?;
            // The file is parsed alone first, so that errors point at its lines.
            Setup::parse(&text).with_context(|| format!("{}", file.display()))?;
            setup = text.parse().with_context(|| format!("{}", file.display()))?;
        }
        for assignment in &self.set {
            let Some((key, value)) = assignment.split_once('=') else {
                bail!("--set: expected KEY=VALUE, found `{assignment}`");
            };
            let value = value.trim();
            if value.contains(['\n', '\r']) {
                bail!("--set: expected a value on one line, found `{assignment}`");
            }
            insert(&mut setup, key.trim(), parse(value))
                .with_context(|| format!("--set {assignment}"))?;
            Setup::from_table(setup.clone())
                .and_then(|setup| setup.check_for(rig))
                .with_context(|| format!("--set {assignment}"))?;
        }
        if exact {
            Setup::prefer_exact_plant(&mut setup);
        }
        let mut setup = Setup::from_table(setup)?;
        setup.check_for(rig)?;
        if let Some(kind) = self.plant {
            setup.plant.kind = kind;
        }
        if let Some(body) = self.body {
            setup.body = body;
        }
        if let Some(file) = &self.subject {
            setup.subject = Some(Subject::read(file)?);
            if self.body.is_none() {
                setup.body = BodySource::HanavanKwon;
            }
        }
        setup.check()?;
        Ok(setup)
    }
}

/// Parses a TOML value. Invalid TOML becomes a string, so that names need no quotes in a shell.
fn parse(value: &str) -> toml::Value {
    format!("value = {value}")
        .parse::<toml::Table>()
        .ok()
        .and_then(|mut table| table.remove("value"))
        .unwrap_or_else(|| toml::Value::String(value.to_owned()))
}

fn insert(table: &mut toml::Table, key: &str, value: toml::Value) -> anyhow::Result<()> {
    match key.split_once('.') {
        None => {
            table.insert(key.to_owned(), value);
            Ok(())
        }
        Some((first, rest)) => {
            let inner = table.entry(first).or_insert_with(|| toml::Table::new().into());
            let Some(inner) = inner.as_table_mut() else {
                bail!("`{first}` has no keys of its own");
            };
            insert(inner, rest, value)
        }
    }
}

#[cfg(test)]
mod tests {
    use sinew_evaluation::MethodName;

    use super::*;

    fn setup(set: &[&str]) -> anyhow::Result<Setup> {
        let set = set.iter().map(ToString::to_string).collect();
        SetupArgs { plant: None, body: None, subject: None, setup: None, set }.setup(None)
    }

    #[test]
    fn keys_go_into_their_tables() {
        let setup =
            setup(&["plant.substeps=4", "controller.method = world", "dimensions.left_arm=1.2"])
                .unwrap();
        assert_eq!(setup.plant.substeps, 4);
        assert_eq!(setup.controller.method, MethodName::World);
        assert!((setup.dimensions.left_arm - 1.2).abs() < f64::EPSILON);
    }

    #[test]
    fn a_bad_assignment_is_named() {
        for bad in [
            "plant.substeps",
            "plant.substeps=0",
            "plant.substeps=many",
            "plant.substeps=4\nbody=3",
            "plant.steps=1",
            "body.kind=x",
            "controller.beta=nan",
            "controller.reference=tail",
        ] {
            let error = format!("{:#}", setup(&[bad]).unwrap_err());
            assert!(error.contains(bad), "{error}");
        }
    }
}
