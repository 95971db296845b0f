//! The checks and tests: a gate for every change, all of them before an issue is resolved, and those that take an
//! hour.

use std::env;

use anyhow::Result;
use sinew_image::{BOARDS, EMULATED};
use sinew_steps::image::Image;
use sinew_steps::step;
use sinew_steps::step::Beside;

use crate::lints::WITH_DEFMT;
use crate::scope::Scope;
use crate::{
    clients, deny, docs, emulate, firmware, limits, lints, measure, nextest, node, package, parity,
    retargeting, setup, studies, wheel,
};

/// Runs checks and tests, and prints the duration of each step.
pub(crate) fn run(scope: Scope) -> Result<()> {
    let mut slowest = None;
    let result = checks(scope, &mut slowest);
    if let Some(slowest) = slowest {
        eprintln!("\n   the slowest tests, in seconds\n{slowest}");
    }
    eprintln!("\n   all steps, in seconds, without the build of xtask itself\n{}", step::table());
    result
}

/// Runs the checks that take an hour: thousands of random cases, whole plays in QEMU, and all runs on all machines.
pub(crate) fn soak() -> Result<()> {
    setup::run()?;
    let result = soaking();
    eprintln!("\n   all steps, in seconds\n{}", step::table());
    result
}

fn soaking() -> Result<()> {
    let mut random = nextest::run()?;
    // Each run draws new random cases.
    random.env("INSTA_UPDATE", "no").env("PROPTEST_CASES", "4096").env("SINEW_SOAK_S", "3600");
    random.env("SINEW_IDLE_S", "3600");
    step::run("tests with 4,096 new random cases each", &mut random)?;
    limits::run()?;
    parity::run()?;
    node::run()?;
    emulate::run()?;
    if let Some(chromium) = setup::chromium() {
        let mut sound = nextest::run()?;
        sound.args(["--run-ignored", "all", "--filterset", "test(the_sound_keeps_the_time)"]);
        sound.env("SINEW_CHROMIUM", chromium).env("SINEW_SOUND_S", "600");
        step::run("the sound of a show of 10 minutes", &mut sound)?;
    }
    let has = |variable| env::var_os(variable).is_some();
    if has("SINEW_DATA") && has(retargeting::REFERENCE) {
        retargeting::run(false)?;
    }
    Ok(())
}

fn checks(scope: Scope, slowest: &mut Option<String>) -> Result<()> {
    step::of("set-up", setup::run)?;
    step::run("format", step::cargo().args(["fmt", "--all", "--check"]))?;
    wheel::format()?;
    docs::text()?;
    deny::run()?;
    if scope == Scope::All {
        lints::rest(&nextest::UNTESTED)?;
        published()?;
    }

    // The emulator has its own compiler and folder, so it is built while images are linked, which uses one core
    // each.
    let emulator = if scope == Scope::All { emulate::begin()? } else { None };
    nextest::build()?;
    wheel::check()?;
    if scope == Scope::All {
        studies::build()?;
    }
    docs::commands()?;
    firmware::build(EMULATED)?;
    // Linking an image uses one core, and this step the other. It uses the same build profile as the first image,
    // so both cannot be linked at the same time.
    let audit = Beside::begin(
        "link what boards may call without a panic handler",
        &mut Image::AUDIT.cargo("rustc")?,
        step::root().join("target/audit.log"),
    )?;
    // The gate builds one of the boards that are flashed.
    let flashed = BOARDS.iter().filter(|board| board.name != EMULATED.name);
    for &board in flashed.filter(|board| scope == Scope::All || board.name == "nucleo_f446re") {
        firmware::build(board)?;
    }
    lints::images(scope)?;
    audit.end()?;

    let mut tests = nextest::run()?;
    tests
        .args(["--test-threads", &nextest::threads().to_string()])
        .env("INSTA_UPDATE", "no")
        // The random cases are the same in every run, so that a failure is caused by the change. Plain `cargo test`
        // draws new ones, except for the core's tests, whose seed is this one, too (`property` in tests/support).
        .env("PROPTEST_RNG_SEED", "20261121")
        .envs(firmware::variables());
    let data = env::var_os("SINEW_DATA").is_some();
    if !data {
        eprintln!("\nSINEW_DATA is not set: tests on real mocap report as ignored.");
    }
    if scope == Scope::Gate {
        tests.args(["--profile", "gate"]);
        if data {
            tests.args(["--run-ignored", "all"]);
        } else {
            // Two runs, so that the other ignored tests are counted as ignored.
            step::run("torques in QEMU and on the host", &mut firmware::test()?)?;
        }
        let result = step::run("tests", &mut tests);
        *slowest = nextest::slowest("gate");
        result?;
        return examples();
    }

    let mut of_measure = step::cargo();
    of_measure.args(["test", "--locked", "--package", "sinew-measure"]);
    step::run("tests of what measures", &mut of_measure)?;
    measure::run(&["budget"])?;
    measure::run(&["audit", "--self-test"])?;
    measure::run(&["audit"])?;
    clients::run()?;
    let machines = parity::build()?;
    let image = node::build()?;
    let emulator = emulate::build(emulator)?;
    // Number of frames that the two hostile hosts send together.
    tests.env("SINEW_FRAMES", "1000000");
    if data {
        tests.args(["--run-ignored", "all"]);
    } else {
        let result = step::run("tests that need nothing but the workspace", &mut tests);
        *slowest = nextest::slowest("default");
        result?;
        tests.args(["--run-ignored", "only"]);
    }
    tests
        .envs(machines.into_iter().chain([image]))
        .envs(emulator.iter().flatten().cloned())
        .env("SINEW_CHROMIUM", setup::chromium().unwrap_or_default());
    let without = if emulator.is_none() { "test(emulated_)" } else { "none()" };
    let tested = if data { "all()" } else { nextest::WITHOUT_DATA };
    tests.args(["--filterset", &format!("({tested}) - {without}")]);
    let result = step::run("tests", &mut tests);
    if data {
        *slowest = nextest::slowest("default");
    }
    result?;
    studies::test()?;
    wheel::run()?;
    examples()
}

/// Checks published packages and documentation.
fn published() -> Result<()> {
    package::run()?;
    step::run(
        "documentation",
        step::cargo()
            // Building examples lets this step share checked dependencies with clippy.
            .args(["doc", "--locked", "--no-deps", "--lib", "--bins", "--examples"])
            .args(["--workspace", "--exclude", "sinew-tests", "--exclude", "xtask", WITH_DEFMT])
            // A crate for tests only.
            .args(["--exclude", "sinew-fuzz"])
            // A crate that is empty for a host.
            .args(["--exclude", "sinew-stm32"])
            .env("RUSTDOCFLAGS", "--deny warnings"),
    )?;
    docs::book()
}

/// Runs the documentation's examples, with the crates that the tests were built with.
fn examples() -> Result<()> {
    let mut command = step::cargo();
    command.args(["test", "--locked", "--doc", "--workspace"]).args(nextest::without_untested());
    step::run("examples", lints::while_compiling(&mut command))
}
