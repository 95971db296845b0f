//! The studies of articles: a workspace of its own, since the framework that they train with is larger than the
//! product.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;
use sinew_steps::step;

const MANIFEST: &str = "dev/studies/Cargo.toml";

fn cargo(verb: &str) -> Command {
    let mut cargo = step::cargo();
    cargo.args([verb, "--locked", "--manifest-path", MANIFEST, "--target-dir"]).arg(target());
    cargo
}

fn target() -> PathBuf {
    step::root().join("target/studies")
}

/// Returns the path of the program, once [`build`] has made it.
pub(crate) fn program() -> PathBuf {
    target().join("debug/sinew-studies").with_extension(std::env::consts::EXE_EXTENSION)
}

/// Lints them.
pub(crate) fn lint() -> Result<()> {
    let mut clippy = cargo("clippy");
    step::run("clippy of the studies", clippy.args(["--all-targets", "--", "--deny", "warnings"]))
}

/// Builds the program and its tests.
pub(crate) fn build() -> Result<()> {
    step::run("build the studies", cargo("test").arg("--no-run"))
}

/// Runs their tests, those on real mocap too if there is any.
pub(crate) fn test() -> Result<()> {
    let mut test = cargo("test");
    test.env("INSTA_UPDATE", "no");
    if std::env::var_os("SINEW_DATA").is_some() {
        test.args(["--", "--include-ignored"]);
    }
    step::run("tests of the studies", &mut test)
}
