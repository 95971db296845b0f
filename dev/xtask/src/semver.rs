//! Finds changes of the core's public interface.

use anyhow::{Result, ensure};

use sinew_steps::step;

/// Command that installs the tool. It is not installed automatically: building it takes minutes.
const INSTALL: &str = "cargo install cargo-semver-checks --locked --version 0.51.0";

/// Compares the core's interface with that of a revision of the repository.
///
/// This is not part of `cargo xtask test`: until 0.1.0 is published nobody depends on the interface, and it may change.
pub(crate) fn run(revision: &str) -> Result<()> {
    let installed = step::output(step::cargo().args(["semver-checks", "--version"])).is_some();
    ensure!(installed, "cargo-semver-checks is missing; it takes some minutes: `{INSTALL}`");
    step::run(
        &format!("the core's interface against {revision}"),
        step::cargo()
            .args(["semver-checks", "--package", "sinew-core", "--all-features"])
            .args(["--baseline-rev", revision]),
    )
}
