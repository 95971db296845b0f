//! Builds a whole node as an image, and compares it in QEMU with the node in a test's process: an arm with a faulty
//! line, and shows on rigs.

use std::process::Command;

use anyhow::Result;

use crate::firmware::Variable;
use crate::nextest;
use sinew_steps::image::Image;
use sinew_steps::step;

/// Image of the node.
const IMAGE: Image = Image { package: "sinew-qemu-node", name: "node", feature: None };

/// Builds the image and runs the tests.
pub(crate) fn run() -> Result<()> {
    let image = build()?;
    step::run("the node in QEMU", test()?.envs([image]).env("SINEW_NODE_ALL", "1"))
}

/// Returns the tests, which need the variable of [`build`]; the tests with robots also need `SINEW_DATA`.
fn test() -> Result<Command> {
    let on_data = std::env::var_os("SINEW_DATA").is_some();
    let without = if on_data { "none()" } else { "test(robots)" };
    let mut test = nextest::run()?;
    test.args(["--run-ignored", "all", "--no-capture", "--filterset"]);
    test.arg(format!("test(in_qemu) - {without}"));
    Ok(test)
}

/// Builds the image, and returns the variable with its path for the tests.
pub(crate) fn build() -> Result<Variable> {
    step::run(&format!("build {}", IMAGE.name), &mut IMAGE.cargo("build")?)?;
    Ok(("SINEW_NODE_IMAGE", IMAGE.path()))
}
