//! Packages and targets of the workspace, as cargo reports them.

use anyhow::{Context as _, Result};

use serde_json::Value;
use sinew_steps::step;

pub(super) struct Workspace {
    packages: Vec<Package>,
}

struct Package {
    name: String,
    targets: Vec<Target>,
}

struct Target {
    name: String,
    kind: Vec<String>,
}

impl Workspace {
    pub(super) fn read() -> Result<Self> {
        let arguments = ["metadata", "--no-deps", "--offline", "--format-version", "1"];
        let text =
            step::output(step::cargo().args(arguments)).context("`cargo metadata` failed")?;
        let all: Value = serde_json::from_str(&text)?;
        let list = |of: &Value, name: &str| of[name].as_array().cloned().unwrap_or_default();
        let text = |of: &Value| of.as_str().unwrap_or_default().to_owned();
        let target = |of: &Value| Target {
            name: text(&of["name"]),
            kind: list(of, "kind").iter().map(text).collect(),
        };
        let package = |of: &Value| Package {
            name: text(&of["name"]),
            targets: list(of, "targets").iter().map(target).collect(),
        };
        Ok(Self { packages: list(&all, "packages").iter().map(package).collect() })
    }

    /// Describes a fault in the options of a cargo command: a package or target that does not exist.
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
