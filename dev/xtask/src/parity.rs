//! Builds the programs whose numbers are compared bit by bit, and compares them.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::image::Image;
use crate::{arm, step};

/// 32-bit x86 with a C library of its own, where this machine can run it: it needs no linker but Rust's.
pub(crate) const X86_32: Option<&str> = if cfg!(all(target_arch = "x86_64", target_os = "linux")) {
    Some("i686-unknown-linux-musl")
} else {
    None
};

/// The program for emulated boards; hosts' is of the same name.
pub(crate) const IMAGE: Image =
    Image { package: "sinew-bit-parity", name: "parity", feature: None };

/// Where `tests/tests/cross_crate/parity.rs` finds a machine's program; empty for one that cannot be built here.
pub(crate) type Variable = (&'static str, PathBuf);

/// Builds the programs and runs the test.
pub(crate) fn run() -> Result<()> {
    let programs = build()?;
    step::run("bit parity", test().envs(programs).env("SINEW_PARITY_ALL", "1"))
}

/// The test, which needs what [`build`] returns in its environment.
pub(crate) fn test() -> Command {
    let mut test = step::cargo();
    // Of the whole workspace's features: nothing is built twice.
    test.args([
        "test",
        "--locked",
        "--workspace",
        "--test",
        "cross_crate",
        "parity::",
        "--",
        "--include-ignored",
    ])
    .arg("--nocapture");
    if std::env::var_os("SINEW_DATA").is_none() {
        test.args(["--skip", "recorded"]);
    }
    test
}

/// Builds a program for every machine.
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

/// The release program for this machine, or for a target that it can run.
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
