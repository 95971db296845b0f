//! The core and the firmware's library with their features: nothing else in the workspace switches them on.

use anyhow::Result;

use crate::{arm, step};

pub(crate) fn run() -> Result<()> {
    let deny = ["--", "--deny", "warnings"];
    let clippy = |title: &str, packages: &[&str], features: &str| {
        let mut command = step::cargo();
        command.args(["clippy", "--locked", "--all-targets", "--features", features]);
        for package in packages {
            command.args(["--package", package]);
        }
        step::run(title, command.args(deny))
    };
    clippy("clippy of the core with serde", &["sinew-core"], "serde")?;
    clippy("clippy of the core with serde and defmt", &["sinew-core"], "serde,defmt")?;
    clippy(
        "clippy of core, firmware and the servos' stand-in with defmt",
        &["sinew-core", "sinew-firmware", "sinew-parity"],
        "sinew-core/defmt,sinew-firmware/defmt,sinew-parity/defmt",
    )?;
    step::run(
        "tests of the core with serde",
        step::cargo().args(["test", "--locked", "--package", "sinew-core", "--features", "serde"]),
    )?;
    step::run(
        "documentation of the core with all features",
        step::cargo()
            .args(["doc", "--locked", "--no-deps", "--package", "sinew-core", "--all-features"])
            .env("RUSTDOCFLAGS", "--deny warnings"),
    )?;
    // What needs `std` does not build for a board.
    step::run(
        "the core with all features, for Arm",
        arm::toolchain()?.cargo_for(arm::TARGET, "check").args([
            "--package",
            "sinew-core",
            "--all-features",
        ]),
    )?;
    step::run(
        "the board's part of a rig, for Arm",
        arm::toolchain()?.cargo_for(arm::TARGET, "check").args([
            "--package",
            "sinew-rig",
            "--no-default-features",
        ]),
    )
}
