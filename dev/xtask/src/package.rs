//! Checks the crates for other projects: whether they can be published, and whether the oldest compiler that they
//! name builds them.

use std::fs;

use anyhow::{Context, Result};

use sinew_steps::{arm, step};

use crate::setup;

/// Folders of the crates that are published. Each crate is listed after its dependencies.
const FOLDERS: [&str; 5] = ["core/fpu", "core", "crates/mocap", "crates/servo-bus", "crates/link"];

/// The manifest of a crate that is no part of the workspace and depends on the core.
const OUTSIDE: &str = "dev/outside/Cargo.toml";

/// Content of a manifest.
struct Package {
    name: String,
    rust_version: String,
}

/// Packs all these crates, and builds each from its package only.
pub(crate) fn run() -> Result<()> {
    let packages = FOLDERS.iter().map(|folder| read(folder)).collect::<Result<Vec<Package>>>()?;
    let mut pack = step::cargo();
    // Uncommitted changes are packed, too: this is a check, not a release.
    pack.args(["package", "--locked", "--allow-dirty"]);
    for package in &packages {
        pack.args(["--package", &package.name]);
    }
    step::run("packages for crates.io", &mut pack)?;

    outside()?;

    let in_use = step::output(step::command("rustc").arg("--version")).unwrap_or_default();
    for Package { name, rust_version } in &packages {
        // Clippy and the tests have built it with this version.
        if in_use.starts_with(&format!("rustc {rust_version}.")) {
            continue;
        }
        if !setup::rust(rust_version) {
            eprintln!(
                "\n{name} is NOT checked with Rust {rust_version}, the oldest that it names: rustup cannot bring that"
            );
            continue;
        }
        step::run(
            &format!("{name} with Rust {rust_version}, the oldest that it names"),
            step::command("rustup")
                .args(["run", rust_version, "cargo", "check", "--locked", "--all-features"])
                // A separate folder; otherwise each compiler would rebuild everything.
                .args(["--package", name, "--target-dir", "target/oldest"])
                .env_remove("RUSTC"),
        )?;
    }
    Ok(())
}

/// Runs the tests of a crate outside of the workspace and the core's first example in it, and builds it for a board.
fn outside() -> Result<()> {
    let host = |verb: &str| {
        let mut cargo = step::cargo();
        cargo.args([verb, "--locked", "--manifest-path", OUTSIDE, "--target-dir"]);
        cargo.arg(step::root().join("target/outside"));
        cargo
    };
    step::run("tests of a crate outside of the workspace", &mut host("test"))?;
    step::run("the core's first example in it", &mut host("run"))?;
    let mut board = arm::toolchain()?.cargo_for(arm::TARGET, "build");
    board.args(["--manifest-path", OUTSIDE, "--lib"]);
    step::run("that crate for a board", &mut board)
}

fn read(folder: &str) -> Result<Package> {
    let path = step::root().join(folder).join("Cargo.toml");
    let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let value = |key: &str| -> Result<String> {
        let line = text.lines().find_map(|line| line.strip_prefix(key)?.trim().strip_prefix('='));
        let value = line.with_context(|| format!("{} has no {key}", path.display()))?;
        Ok(value.trim().trim_matches('"').to_owned())
    };
    Ok(Package { name: value("name")?, rust_version: value("rust-version")? })
}
