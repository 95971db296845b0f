//! The emulated NUCLEO-F446RE: builds the tool, which stands outside of the workspace with a compiler of its own, and
//! runs what is tried over it.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::arm;
use crate::image::Image;
use crate::parity::Variable;
use crate::{setup, step};

/// What the tool is built with: that of `emulator/rust-toolchain.toml`.
const RUST: &str = "1.98.0";
const MANIFEST: &str = "emulator/Cargo.toml";

/// Tries the chip's peripherals.
pub(crate) const CHIP: Image =
    Image { package: "sinew-emulation-image", name: "chip", feature: None };
/// The node, as it is flashed.
const NUCLEO: Image = Image { package: "nucleo_f446re", name: "nucleo_f446re", feature: None };
/// Leaves out what keeps packets whole: the tests of the bus must notice.
const STALE: Option<&str> = Some("stale-tc");

/// Builds the tool and the images, and runs the tests.
pub(crate) fn run() -> Result<()> {
    match build()? {
        Some(variables) => step::run("the emulated NUCLEO", test().envs(variables)),
        None => Ok(()),
    }
}

/// The tests, which need what [`build`] returns in their environment; the walk's needs `SINEW_DATA`, too.
pub(crate) fn test() -> Command {
    let mut test = step::cargo();
    // Of the whole workspace's features: nothing is built twice.
    test.args(["test", "--locked", "--workspace"]);
    // Those of `sinew play --emulate` are among the shows.
    test.args(["chip", "nucleo", "shows"].iter().flat_map(|of| ["--test", of]));
    test.args(["--", "emulated", "--include-ignored"]);
    if std::env::var_os("SINEW_DATA").is_none() {
        test.args(["--skip", "walks"]);
    }
    test
}

/// Builds the tool and the images, and says where tests find them; none where the tool's compiler cannot be had.
pub(crate) fn build() -> Result<Option<[Variable; 4]>> {
    if !setup::rust(RUST) {
        eprintln!("\n== the emulated NUCLEO: ignored, it needs Rust {RUST} by rustup");
        return Ok(None);
    }
    let target = step::root().join("target/emulator");
    let mut tool = step::command("rustup");
    tool.args(["run", RUST, "cargo", "build", "--locked", "--release"]);
    tool.args(["--manifest-path", MANIFEST, "--target-dir"]).arg(&target);
    // The compiler of this program is named in them.
    for variable in ["CARGO", "RUSTC", "RUSTUP_TOOLCHAIN", "RUSTFLAGS"] {
        tool.env_remove(variable);
    }
    step::run("build the emulator", &mut tool)?;
    let tool = target.join("release/sinew-emulator");
    Ok(Some([
        ("SINEW_EMULATOR", tool),
        ("SINEW_CHIP_IMAGE", image(CHIP)?),
        ("SINEW_STALE_TC_IMAGE", image(Image { feature: STALE, ..CHIP })?),
        ("SINEW_NUCLEO_IMAGE", image(NUCLEO)?),
    ]))
}

/// Builds an image, and puts it where the next one of the same name does not.
fn image(image: Image) -> Result<PathBuf> {
    let features = image.feature.map(|feature| format!("-{feature}")).unwrap_or_default();
    let name = format!("{}{features}", image.name);
    step::run(&format!("build {name}"), &mut image.cargo("build")?)?;
    let kept = arm::target_dir().join(name).with_extension("elf");
    std::fs::copy(image.path(), &kept)?;
    Ok(kept)
}
