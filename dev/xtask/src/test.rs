//! Everything that must hold.

use std::process::Command;

use anyhow::Result;
use sinew_image::BOARDS;

use crate::image::Image;
use crate::{
    arm, audit, budget, clients, deny, docs, emulate, firmware, nextest, node, package, parity,
    setup, step,
};

/// Core and firmware with `defmt`, too, which nothing else has.
const WITH_DEFMT: &str = "--features=sinew-firmware/defmt";

pub(crate) fn run() -> Result<()> {
    setup::run()?;
    step::run("format", step::cargo().args(["fmt", "--all", "--check"]))?;
    docs::text()?;
    let deny = ["--", "--deny", "warnings"];
    step::run(
        "clippy",
        step::cargo()
            .args(["clippy", "--locked", "--workspace", "--all-targets", WITH_DEFMT])
            // Fuzz targets as a fuzzer builds them.
            .args(
                ["bus", "link", "firmware", "sim"]
                    .map(|of| format!("--features=sinew-{of}-fuzz/bolero")),
            )
            .args(deny),
    )?;
    deny::run()?;
    // The workspace's tests have the core as hosts do, with `large`; boards have it without.
    step::run(
        "tests of the core as boards have it",
        step::cargo().args(["test", "--locked", "--package", "sinew-core", "--features", "serde"]),
    )?;
    // What needs `std` does not build for a board.
    let mut board = arm::toolchain()?.cargo_for(arm::TARGET, "check");
    board.args(["--package", "sinew-core", "--package", "sinew-firmware"]);
    board.arg("--features=sinew-core/serde,sinew-core/large,sinew-firmware/defmt");
    step::run("core and firmware with all features, for Arm", &mut board)?;
    package::run()?;
    step::run(
        "documentation",
        step::cargo()
            // Examples let it share with clippy what is checked of the dependencies.
            .args(["doc", "--locked", "--no-deps", "--lib", "--bins", "--examples"])
            .args(["--workspace", "--exclude", "sinew-tests", "--exclude", "xtask", WITH_DEFMT])
            // They hold nothing but tests.
            .args(["--exclude", "sinew-*-fuzz"])
            // It is empty for a host.
            .args(["--exclude", "sinew-stm32"])
            .env("RUSTDOCFLAGS", "--deny warnings"),
    )?;
    docs::with_programs()?;

    // Of its own compiler and folder: it is built while images are linked, each by one core.
    let emulator = emulate::begin()?;
    budget::run(false, firmware::run)?;
    lint_images()?;
    audit::self_test()?;
    audit::run()?;
    clients::run()?;
    let machines = parity::build()?;
    let image = node::build()?;
    let emulator = emulate::build(emulator)?;
    let mut tests = nextest::run()?;
    tests
        .env("INSTA_UPDATE", "no")
        // The same random cases in every run, so that what fails here was changed here. Plain `cargo test` draws new
        // ones, but for the core's: this is their seed, too (`property` in tests/src/lib.rs).
        .env("PROPTEST_RNG_SEED", "20261121")
        .envs(machines.iter().cloned().chain([image.clone()]))
        .envs(emulator.iter().flatten().cloned());
    let browser = setup::chromium().unwrap_or_default();
    tests.env("SINEW_CHROMIUM", &browser);
    if std::env::var_os("SINEW_DATA").is_some() {
        tests.args(["--run-ignored", "all"]);
        if emulator.is_none() {
            tests.args(["--filterset", "not test(emulated_)"]);
        }
        step::run("tests, those on real mocap too", &mut tests)?;
    } else {
        eprintln!("\nSINEW_DATA is not set: tests on real mocap report as ignored.");
        step::run("tests", &mut tests)?;
        step::run("bit parity", parity::test().envs(machines))?;
        step::run("the node in QEMU", node::test().envs([image]))?;
        if let Some(emulator) = emulator {
            step::run("the emulated NUCLEO", emulate::test().envs(emulator))?;
        }
        let mut report = step::cargo();
        report
            .args(["test", "--locked", "--workspace", "--test", "browser"])
            .args(["--", "--ignored"])
            .env("SINEW_CHROMIUM", browser);
        step::run("pages in a browser", &mut report)?;
    }
    step::run("examples", step::cargo().args(["test", "--locked", "--workspace", "--doc"]))
}

/// Lints all images as the host's crates are.
fn lint_images() -> Result<()> {
    if arm::toolchain()? == arm::Toolchain::Debian {
        eprintln!("\n== clippy of the images: left out, Debian's compiler has none");
        return Ok(());
    }
    let clippy = |image: Image, mut command: Command| {
        let title = format!("clippy of {}", image.name);
        step::run(&title, command.args(["--", "--deny", "warnings"]))
    };
    for &board in BOARDS {
        let image = Image::of(board);
        let mut command = image.cargo("clippy")?;
        command.envs(firmware::built_in());
        clippy(image, command)?;
    }
    for image in
        budget::IMAGES.into_iter().chain([audit::FAULTY, parity::IMAGE, node::IMAGE, emulate::CHIP])
    {
        clippy(image, image.cargo("clippy")?)?;
    }
    Ok(())
}
