//! The studies of articles. They are a separate workspace, because their training framework is larger than the
//! product.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;
use sinew_steps::step;

use crate::lints;

const MANIFEST: &str = "dev/studies/Cargo.toml";

fn cargo(verb: &str) -> Command {
    let mut cargo = step::cargo();
    cargo.args([verb, "--locked", "--manifest-path", MANIFEST, "--target-dir"]).arg(target());
    cargo
}

fn target() -> PathBuf {
    step::root().join("target/studies")
}

/// Returns the path of the program that [`build`] makes.
pub(crate) fn program() -> PathBuf {
    target().join("debug/sinew-studies").with_extension(std::env::consts::EXE_EXTENSION)
}

/// Builds the program and its tests, and lints them. A separate check of the framework would take six minutes.
pub(crate) fn build() -> Result<()> {
    let mut build = cargo("test");
    step::run("build and lint the studies", lints::while_compiling(build.arg("--no-run")))
}

/// Runs the tests of the studies, including those on real mocap if it is available.
pub(crate) fn test() -> Result<()> {
    let mut test = cargo("test");
    lints::while_compiling(&mut test).env("INSTA_UPDATE", "no");
    if std::env::var_os("SINEW_DATA").is_some() {
        test.args(["--", "--include-ignored"]);
    }
    step::run("tests of the studies", &mut test)
}
