//! Builds the programs whose numbers are compared bit by bit, and compares them.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use sinew_steps::image::Image;
use sinew_steps::{arm, step};

use crate::firmware::Variable;
use crate::nextest;
use crate::targets::X86_32;

/// The program for emulated boards. Programs for hosts have the same name.
const IMAGE: Image = Image { package: "sinew-bit-parity", name: "parity", feature: None };

/// Builds the programs and runs the test.
pub(crate) fn run() -> Result<()> {
    let programs = build()?;
    step::run("bit parity", test()?.envs(programs).env("SINEW_PARITY_ALL", "1"))
}

/// Returns the test, which needs the variables of [`build`].
fn test() -> Result<Command> {
    let recorded =
        std::env::var_os("SINEW_DATA").map_or("", |_| " + test(recorded_shows_are_decoded)");
    let mut test = nextest::run()?;
    test.args(["--run-ignored", "all", "--no-capture", "--filterset"]);
    test.arg(format!("test(every_machine_computes){recorded}"));
    Ok(test)
}

/// Builds a program for every machine, and returns the variables with their paths for the tests; the path is empty if
/// a program cannot be built here.
pub(crate) fn build() -> Result<Vec<Variable>> {
    let mut programs = Vec::new();
    for (variable, target) in
        [("SINEW_PARITY_M4F", arm::TARGET), ("SINEW_PARITY_M4", arm::SOFT_FLOAT)]
    {
        let title = format!("build {} for {target}", IMAGE.name);
        step::run(&title, &mut IMAGE.cargo_for(target, "build")?)?;
        programs.push((variable, IMAGE.path_for(target)));
    }
    programs.push(("SINEW_PARITY_RELEASE", host(None)?));
    let x86_32 = X86_32.filter(|target| arm::has_target(target));
    if x86_32.is_none() {
        eprintln!("\n== bit parity leaves 32-bit x86 out: it cannot be built or run here");
    }
    let program = x86_32.map(|target| host(Some(target))).transpose()?.unwrap_or_default();
    programs.push(("SINEW_PARITY_I686", program));
    Ok(programs)
}

/// Builds the release program for this machine, or for a target that this machine can run.
fn host(target: Option<&str>) -> Result<PathBuf> {
    let mut folder = step::root().join("target");
    let mut cargo = step::cargo();
    let Image { package, name, .. } = IMAGE;
    cargo.args(["build", "--locked", "--release", "--package", package, "--bin", name]);
    cargo.arg("--target-dir").arg(&folder);
    if let Some(target) = target {
        folder.push(target);
        cargo.args(["--target", target]);
        let target = target.replace('-', "_").to_uppercase();
        cargo.env(format!("CARGO_TARGET_{target}_LINKER"), "rust-lld");
    }
    step::run(&format!("build {name} for {}", target.unwrap_or("this host")), &mut cargo)?;
    let program = folder.join("release").join(name).with_extension(std::env::consts::EXE_EXTENSION);
    program.canonicalize().with_context(|| format!("{}", program.display()))
}
