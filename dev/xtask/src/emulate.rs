//! The emulated NUCLEO-F446RE: builds the tool, which is outside of the workspace and needs another compiler, and
//! runs the tests on it.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context as _, Result};

use crate::firmware::Variable;
use sinew_steps::arm;
use sinew_steps::image::Image;
use sinew_steps::step;
use sinew_steps::step::Beside;

use crate::{nextest, setup};

/// Version of Rust for the tool: that of `dev/nucleo/emulator/rust-toolchain.toml`.
const RUST: &str = "1.98.0";
const MANIFEST: &str = "dev/nucleo/emulator/Cargo.toml";
const TITLE: &str = "build the emulator";

/// Image that tests the chip's peripherals.
const CHIP: Image = Image { package: "sinew-nucleo-image", name: "chip", feature: None };
/// Image of the node, as it is flashed.
const NUCLEO: Image = Image { package: "nucleo_f446re", name: "nucleo_f446re", feature: None };
/// Feature that disables the code that keeps packets whole: the tests of the bus must detect it.
const STALE: Option<&str> = Some("stale-tc");

/// Builds the tool and the images, and runs the tests.
pub(crate) fn run() -> Result<()> {
    let Some(mut tool) = tool(step::command("rustup")) else { return Ok(()) };
    step::run(TITLE, &mut tool)?;
    step::run("the emulated NUCLEO", test()?.envs(variables()?))
}

/// Returns the tests, which need the variables of [`build`]; the test with walks also needs `SINEW_DATA`.
fn test() -> Result<Command> {
    let on_data = std::env::var_os("SINEW_DATA").is_some();
    let without = if on_data { "none()" } else { "test(walks)" };
    let mut test = nextest::run()?;
    test.args([
        "--run-ignored",
        "all",
        "--filterset",
        &format!("test(emulated_) - test(the_emulated_board) - {without}"),
    ]);
    Ok(test)
}

/// Starts to build the tool, in parallel with other steps; `None` if its compiler is not available.
pub(crate) fn begin() -> Result<Option<Beside>> {
    let Some(mut tool) = tool(step::patient("rustup")) else { return Ok(None) };
    let target = target();
    fs::create_dir_all(&target).with_context(|| target.display().to_string())?;
    Beside::begin(TITLE, &mut tool, target.join("build.log")).map(Some)
}

/// Builds the images, waits for the tool, and returns the variables with their paths for the tests. `None` without a
/// tool.
pub(crate) fn build(tool: Option<Beside>) -> Result<Option<[Variable; 4]>> {
    let Some(tool) = tool else { return Ok(None) };
    let variables = variables()?;
    tool.end()?;
    Ok(Some(variables))
}

/// Returns the command that builds the tool with this `rustup`, in a folder of its own. `None` if the compiler is not
/// available.
fn tool(mut rustup: Command) -> Option<Command> {
    if !setup::rust(RUST) {
        eprintln!("\n== the emulated NUCLEO: ignored, it needs Rust {RUST} by rustup");
        return None;
    }
    rustup.args(["run", RUST, "cargo", "build", "--locked", "--release"]);
    rustup.args(["--manifest-path", MANIFEST, "--target-dir"]).arg(target());
    // These variables name the compiler of this program.
    for variable in ["CARGO", "RUSTC", "RUSTUP_TOOLCHAIN", "RUSTFLAGS"] {
        rustup.env_remove(variable);
    }
    Some(rustup)
}

/// Builds the images, and returns the variables with the paths of images and tool for the tests.
fn variables() -> Result<[Variable; 4]> {
    Ok([
        ("SINEW_EMULATOR", target().join("release/sinew-emulator")),
        ("SINEW_CHIP_IMAGE", image(CHIP)?),
        ("SINEW_STALE_TC_IMAGE", image(Image { feature: STALE, ..CHIP })?),
        ("SINEW_NUCLEO_IMAGE", image(NUCLEO)?),
    ])
}

/// Returns the folder in which the tool is built.
fn target() -> PathBuf {
    step::root().join("target/emulator")
}

/// Builds an image, and copies it to a path that the next image of this name does not overwrite.
fn image(image: Image) -> Result<PathBuf> {
    let features = image.feature.map(|feature| format!("-{feature}")).unwrap_or_default();
    let name = format!("{}{features}", image.name);
    step::run(&format!("build {name}"), &mut image.cargo("build")?)?;
    let kept = arm::target_dir().join(name).with_extension("elf");
    fs::copy(image.path(), &kept)?;
    Ok(kept)
}
