//! Runs Clippy on the host's crates and the images.

use std::path::Path;
use std::process::Command;

use anyhow::Result;
use sinew_image::EMULATED;
use sinew_steps::image::built_in;
use sinew_steps::{arm, step};

use crate::scope::Scope;

/// Option that builds core and firmware also with `defmt`, which no other build enables.
pub(crate) const WITH_DEFMT: &str = "--features=sinew-firmware/defmt";

/// Options for clippy's compiler, after those for cargo: a warning is an error.
const DENY: [&str; 3] = ["--", "--deny", "warnings"];

/// Lets a build of tests lint the code that it compiles, since clippy is a compiler. A separate check of all crates
/// and their dependencies would take a fifth of the gate.
///
/// `cargo clippy` sets the same two variables. Builds with them share no artifacts of our crates with builds without
/// them.
pub(crate) fn while_compiling(cargo: &mut Command) -> &mut Command {
    let clippy = Path::new(step::cargo().get_program()).with_file_name("clippy-driver");
    let deny = DENY[1..].iter().map(|option| format!("{option}__CLIPPY_HACKERY__"));
    cargo.env("RUSTC_WORKSPACE_WRAPPER", clippy).env("CLIPPY_ARGS", deny.collect::<String>())
}

/// Lints code that no build of tests compiles: these packages, and features of boards and fuzzers.
pub(crate) fn rest(untested: &[&str]) -> Result<()> {
    let mut clippy = step::cargo();
    clippy.args(["clippy", "--locked", "--all-targets", WITH_DEFMT, "--package=sinew-firmware"]);
    clippy.args(untested.iter().map(|package| format!("--package={package}")));
    // Fuzz targets with the features that a fuzzer uses.
    clippy.args(["--package=sinew-fuzz", "--features=sinew-fuzz/bolero"]);
    step::run("clippy of what no test is built with", clippy.args(DENY))
}

/// Lints the images. All images of a run have the same features.
pub(crate) fn images(scope: Scope) -> Result<()> {
    if arm::toolchain()? == arm::Toolchain::Debian {
        eprintln!("\n== clippy of the images: left out, Debian's compiler has none");
        return Ok(());
    }
    let images = |title: &str, arguments: &[&str]| {
        let mut command = arm::toolchain()?.cargo_for(arm::TARGET, "clippy");
        command.args(arguments).args(["--bins", "--profile", "node"]).args(DENY);
        step::run(title, command.envs(built_in()))
    };
    let mut common = vec!["--package", "nucleo_f446re", "--package", "sinew-audit"];
    if scope == Scope::All {
        common.extend(["--package", "sinew-nucleo-image", "--package", "sinew-bit-parity"]);
        common.extend(["--package", "sinew-bench", "--features", "sinew-bench/mps2_an386"]);
        common.extend(["--package", "sinew-qemu-node"]);
    }
    common.extend(["--package", EMULATED.name]);
    images("clippy of the images", &common)?;
    if scope == Scope::All {
        images("clippy of the STM32G474's image", &["--package", "nucleo_g474re"])?;
    }
    // Code that needs `std` cannot be built for a board.
    let mut core = arm::toolchain()?.cargo_for(arm::TARGET, "clippy");
    core.args(["--package", "sinew-core", "--package", "sinew-firmware", "--lib"]);
    core.arg("--features=sinew-core/serde,sinew-firmware/defmt");
    core.args(["--profile", "node"]).args(DENY);
    step::run("core and firmware with all features, for Arm", &mut core)
}
