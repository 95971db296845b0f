//! Builds a whole node as an image, and compares it in QEMU with the same in process: an arm and its bad line, and
//! `sinew play`.

use std::process::Command;

use anyhow::Result;

use crate::image::Image;
use crate::parity::Variable;
use crate::step;

/// The image.
pub(crate) const IMAGE: Image = Image { package: "sinew-qemu-node", name: "node", feature: None };

/// Builds the image and runs the tests.
pub(crate) fn run() -> Result<()> {
    let image = build()?;
    step::run("the node in QEMU", test().envs([image]).env("SINEW_NODE_ALL", "1"))
}

/// The tests, which need what [`build`] returns in their environment; those of robots need `SINEW_DATA`, too.
pub(crate) fn test() -> Command {
    let mut test = step::cargo();
    // Of the whole workspace's features: nothing is built twice.
    test.args(["test", "--locked", "--workspace", "--test", "firmware", "--test", "shows"]).args([
        "--",
        "emulated",
        "in_qemu",
        "--include-ignored",
        "--nocapture",
        // It needs the emulator, and is one of its tests.
        "--skip",
        "emulated_nucleo",
    ]);
    if std::env::var_os("SINEW_DATA").is_none() {
        test.args(["--skip", "robots"]);
    }
    test
}

/// Builds the image, and says where the tests find it.
pub(crate) fn build() -> Result<Variable> {
    step::run(&format!("build {}", IMAGE.name), &mut IMAGE.cargo("build")?)?;
    Ok(("SINEW_NODE_IMAGE", IMAGE.path()))
}
