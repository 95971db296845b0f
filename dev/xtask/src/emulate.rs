//! The emulated NUCLEO-F446RE: builds the tool, which stands outside of the workspace with a compiler of its own, and
//! runs what is tried over it.

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

/// What the tool is built with: that of `dev/nucleo/emulator/rust-toolchain.toml`.
const RUST: &str = "1.98.0";
const MANIFEST: &str = "dev/nucleo/emulator/Cargo.toml";
const TITLE: &str = "build the emulator";

/// Tries the chip's peripherals.
const CHIP: Image = Image { package: "sinew-nucleo-image", name: "chip", feature: None };
/// The node, as it is flashed.
const NUCLEO: Image = Image { package: "nucleo_f446re", name: "nucleo_f446re", feature: None };
/// Leaves out what keeps packets whole: the tests of the bus must notice.
const STALE: Option<&str> = Some("stale-tc");

/// Builds the tool and the images, and runs the tests.
pub(crate) fn run() -> Result<()> {
    let Some(mut tool) = tool(step::command("rustup")) else { return Ok(()) };
    step::run(TITLE, &mut tool)?;
    step::run("the emulated NUCLEO", test()?.envs(variables()?))
}

/// Returns the tests, which need the variables of [`build`]; the walk's needs `SINEW_DATA`, too.
fn test() -> Result<Command> {
    let on_data = std::env::var_os("SINEW_DATA").is_some();
    let without = if on_data { "none()" } else { "test(walks)" };
    let mut test = nextest::run()?;
    test.args(["--run-ignored", "all", "--filterset", &format!("test(emulated_) - {without}")]);
    Ok(test)
}

/// Begins to build the tool, beside other steps; none where its compiler cannot be had.
pub(crate) fn begin() -> Result<Option<Beside>> {
    let Some(mut tool) = tool(step::patient("rustup")) else { return Ok(None) };
    let target = target();
    fs::create_dir_all(&target).with_context(|| target.display().to_string())?;
    Beside::begin(TITLE, &mut tool, target.join("build.log")).map(Some)
}

/// Builds the images, waits for the tool, and says where tests find them all.
pub(crate) fn build(tool: Option<Beside>) -> Result<Option<[Variable; 4]>> {
    let Some(tool) = tool else { return Ok(None) };
    let variables = variables()?;
    tool.end()?;
    Ok(Some(variables))
}

/// What builds the tool, by this `rustup`, in a folder of its own.
fn tool(mut rustup: Command) -> Option<Command> {
    if !setup::rust(RUST) {
        eprintln!("\n== the emulated NUCLEO: ignored, it needs Rust {RUST} by rustup");
        return None;
    }
    rustup.args(["run", RUST, "cargo", "build", "--locked", "--release"]);
    rustup.args(["--manifest-path", MANIFEST, "--target-dir"]).arg(target());
    // The compiler of this program is named in them.
    for variable in ["CARGO", "RUSTC", "RUSTUP_TOOLCHAIN", "RUSTFLAGS"] {
        rustup.env_remove(variable);
    }
    Some(rustup)
}

/// Builds the images, and says where tests find them and the tool.
fn variables() -> Result<[Variable; 4]> {
    Ok([
        ("SINEW_EMULATOR", target().join("release/sinew-emulator")),
        ("SINEW_CHIP_IMAGE", image(CHIP)?),
        ("SINEW_STALE_TC_IMAGE", image(Image { feature: STALE, ..CHIP })?),
        ("SINEW_NUCLEO_IMAGE", image(NUCLEO)?),
    ])
}

/// Where the tool is built.
fn target() -> PathBuf {
    step::root().join("target/emulator")
}

/// Builds an image, and puts it where the next one of the same name does not.
fn image(image: Image) -> Result<PathBuf> {
    let features = image.feature.map(|feature| format!("-{feature}")).unwrap_or_default();
    let name = format!("{}{features}", image.name);
    step::run(&format!("build {name}"), &mut image.cargo("build")?)?;
    let kept = arm::target_dir().join(name).with_extension("elf");
    fs::copy(image.path(), &kept)?;
    Ok(kept)
}
