//! Features of the core and the firmware's library as nothing else in the workspace has them. Clippy of the workspace
//! has the core with serde, and images have it with defmt alone.

use anyhow::Result;

use crate::{arm, step};

pub(crate) fn run() -> Result<()> {
    let mut clippy = step::cargo();
    clippy.args(["clippy", "--locked", "--all-targets"]);
    clippy.args(["--package", "sinew-core", "--package", "sinew-firmware"]);
    clippy.args(["--package", "sinew-parity", "--features"]);
    clippy.arg("sinew-core/serde,sinew-core/defmt,sinew-firmware/defmt,sinew-parity/defmt");
    step::run(
        "clippy of core, firmware and the servos' stand-in with all features",
        clippy.args(["--", "--deny", "warnings"]),
    )?;
    // The workspace's tests have the core as hosts do, with `large`; boards have it without.
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
