//! Builds the programs whose numbers are compared bit by bit, and compares them.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::{arm, step};

/// 32-bit x86 with a C library of its own, where this machine can run it: it needs no linker but Rust's.
pub(crate) const X86_32: Option<&str> = if cfg!(all(target_arch = "x86_64", target_os = "linux")) {
    Some("i686-unknown-linux-musl")
} else {
    None
};

/// The image for emulated boards, and the program for hosts.
const IMAGE: &str = "parity";
const PROGRAM: &str = "parity_host";

/// Where `tests/tests/parity.rs` finds a machine's program; empty for one that cannot be built here.
pub(crate) type Variable = (&'static str, PathBuf);

/// Builds the programs and runs the test.
pub(crate) fn run() -> Result<()> {
    let programs = build()?;
    step::run("bit parity", test().envs(programs))
}

/// The test, which needs what [`build`] returns in its environment.
pub(crate) fn test() -> Command {
    let mut test = step::cargo();
    // Of the whole workspace's features: nothing is built twice.
    test.args(["test", "--locked", "--workspace", "--test", "parity", "--", "--include-ignored"])
        .arg("--nocapture");
    test
}

/// Builds a program for every machine.
pub(crate) fn build() -> Result<Vec<Variable>> {
    let mut programs = Vec::new();
    for (variable, target) in
        [("SINEW_PARITY_M4F", arm::TARGET), ("SINEW_PARITY_M4", arm::SOFT_FLOAT)]
    {
        let mut cargo = arm::toolchain_for(target)?.cargo_for(target, "build");
        cargo.args(["--package", "sinew-firmware", "--profile", "firmware"]).args([
            "--features",
            IMAGE,
            "--bin",
            IMAGE,
        ]);
        step::run(&format!("build {IMAGE} for {target}"), &mut cargo)?;
        programs.push((variable, arm::image_for(target, IMAGE)));
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

/// Lints the image for emulated boards; the hosts' program is linted with the workspace.
pub(crate) fn lint() -> Result<()> {
    let toolchain = arm::toolchain()?;
    if toolchain == arm::Toolchain::Debian {
        return Ok(());
    }
    step::run(
        &format!("clippy of {IMAGE}"),
        toolchain
            .cargo("clippy")
            .args(["--package", "sinew-firmware", "--profile", "firmware"])
            .args(["--features", IMAGE, "--bin", IMAGE, "--", "--deny", "warnings"]),
    )
}

/// The release program for this machine, or for a target that it can run.
fn host(target: Option<&str>) -> Result<PathBuf> {
    let mut folder = step::root().join("target");
    let mut cargo = step::cargo();
    cargo.args(["build", "--locked", "--release", "--package", "sinew-firmware", "--bin", PROGRAM]);
    cargo.arg("--target-dir").arg(&folder);
    if let Some(target) = target {
        folder.push(target);
        cargo.args(["--target", target]);
        let name = target.replace('-', "_").to_uppercase();
        cargo.env(format!("CARGO_TARGET_{name}_LINKER"), "rust-lld");
    }
    step::run(&format!("build {PROGRAM} for {}", target.unwrap_or("this host")), &mut cargo)?;
    let program =
        folder.join("release").join(PROGRAM).with_extension(std::env::consts::EXE_EXTENSION);
    program.canonicalize().with_context(|| format!("{}", program.display()))
}
