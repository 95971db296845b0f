//! The core and the firmware's library with their features: nothing else in the workspace switches them on.

use anyhow::Result;

use crate::{arm, step};

pub(crate) fn run() -> Result<()> {
    let deny = ["--", "--deny", "warnings"];
    let clippy = |title: &str, package: &str, features: &str| {
        let of_package = ["clippy", "--locked", "--package", package, "--features", features];
        step::run(title, step::cargo().args(of_package).arg("--all-targets").args(deny))
    };
    for features in ["defmt", "serde", "defmt,serde"] {
        clippy(&format!("clippy of the core with {features}"), "sinew-core", features)?;
    }
    clippy("clippy of the firmware's library with defmt", "sinew-firmware", "defmt")?;
    clippy("clippy of the servos' stand-in with defmt", "sinew-parity", "defmt")?;
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
