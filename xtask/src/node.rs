//! Builds a whole node as an image, and compares it in QEMU with the same in process.

use std::process::Command;

use anyhow::Result;

use crate::image::Image;
use crate::parity::Variable;
use crate::step;

/// The image.
pub(crate) const IMAGE: Image = Image { package: "sinew-emulated", name: "node", feature: None };

/// Builds the image and runs the test.
pub(crate) fn run() -> Result<()> {
    let image = build()?;
    step::run("the node in QEMU", test().envs([image]))
}

/// The test, which needs what [`build`] returns in its environment.
pub(crate) fn test() -> Command {
    let mut test = step::cargo();
    // Of the whole workspace's features: nothing is built twice.
    test.args(["test", "--locked", "--workspace", "--test", "node", "emulated"]).args([
        "--",
        "--include-ignored",
        "--nocapture",
    ]);
    test
}

/// Builds the image, and says where `firmware/tests/node/emulated.rs` finds it.
pub(crate) fn build() -> Result<Variable> {
    step::run(&format!("build {}", IMAGE.name), &mut IMAGE.cargo("build")?)?;
    Ok(("SINEW_NODE_IMAGE", IMAGE.path()))
}
