//! What cargo knows of the workspace.

use anyhow::{Context as _, Result};
use serde::Deserialize;

use crate::step;

#[derive(Deserialize)]
pub(super) struct Workspace {
    packages: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    targets: Vec<Target>,
}

#[derive(Deserialize)]
struct Target {
    name: String,
    kind: Vec<String>,
}

impl Workspace {
    pub(super) fn read() -> Result<Self> {
        let arguments = ["metadata", "--no-deps", "--offline", "--format-version", "1"];
        let text =
            step::output(step::cargo().args(arguments)).context("`cargo metadata` failed")?;
        Ok(serde_json::from_str(&text)?)
    }

    /// What is wrong with options of a cargo command: packages and targets that are not there.
    pub(super) fn fault(&self, options: &[String]) -> Option<String> {
        let mut package = None;
        for pair in options.windows(2) {
            let [option, name] = pair else { continue };
            match option.as_str() {
                "-p" | "--package" => {
                    package = self.packages.iter().find(|package| package.name == *name);
                    if package.is_none() {
                        return Some(format!("there is no package `{name}`"));
                    }
                }
                "--example" | "--bench" | "--bin" | "--test" => {
                    let kind = &option[2..];
                    let is_it = |target: &Target| {
                        target.name == *name && target.kind.iter().any(|of| of == kind)
                    };
                    let mut among = self
                        .packages
                        .iter()
                        .filter(|one| package.is_none_or(|package| package.name == one.name));
                    if !among.any(|package| package.targets.iter().any(is_it)) {
                        return Some(format!("there is no {kind} `{name}`"));
                    }
                }
                _ => {}
            }
        }
        None
    }
}
