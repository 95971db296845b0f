//! The bench crate's images, and what images take of flash and RAM.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};
use object::{Object, ObjectSection, ObjectSegment};

use super::figures::Place;
use crate::elf::Elf;
use crate::{arm, step};

/// What images take beside their shows.
pub(crate) const SECTION: &str = "image_bytes";

/// The images of the bench crate.
const IMAGES: [&str; 2] = ["kernels", CORE_ALONE];

/// World, Linear Compensation and inverse dynamics, and nothing else.
const CORE_ALONE: &str = "core_alone";

/// Names that tell the instances of a generic function apart, and frame sizes in the image.
const FLAGS: &str = "-C symbol-mangling-version=v0 -Z emit-stack-sizes";

/// Builds the images.
pub(crate) fn build() -> Result<()> {
    for image in IMAGES {
        step::run(&format!("build {image}"), cargo("build", image)?.env("RUSTFLAGS", FLAGS))?;
    }
    Ok(())
}

/// Lints the images as the host's crates are.
pub(crate) fn lint() -> Result<()> {
    for image in IMAGES {
        let mut clippy = cargo("clippy", image)?;
        step::run(&format!("clippy of {image}"), clippy.args(["--", "--deny", "warnings"]))?;
    }
    Ok(())
}

fn cargo(verb: &str, image: &str) -> Result<Command> {
    let mut command = arm::toolchain()?.cargo(verb);
    command
        .args(["--package", "sinew-bench", "--profile", "firmware"])
        .args(["--features", "mps2_an386", "--bin", image])
        // The frame sizes are a flag of nightly compilers.
        .env("RUSTC_BOOTSTRAP", "1");
    Ok(command)
}

/// The tick of the core alone, of 18 bodies and without room for resolved acceleration.
const CORE_TICK: &str = "<sinew_bench::rig::Rig<18>>::tick";

/// What the core alone takes: as an image, and of it what a tick can execute, with all constants.
pub(crate) fn core_alone() -> Result<impl Iterator<Item = (Place, u64)>> {
    let image = arm::image(CORE_ALONE);
    let elf = Elf::load(&image)?;
    let tick = elf.named(CORE_TICK).with_context(|| format!("the image has no `{CORE_TICK}`"))?;
    let code = elf.reachable_from(&[tick]).into_iter().map(|index| elf.functions()[index].size);
    let bytes = fs::read(&image)?;
    let file = object::File::parse(&*bytes)?;
    let constants = file.section_by_name(".rodata").map_or(0, |section| section.size());
    let tick_bytes = code.sum::<u64>() + constants;
    let tick = (Place::new(SECTION, CORE_ALONE, "tick"), tick_bytes);
    Ok(size(CORE_ALONE, &image, 0)?.chain([tick]))
}

/// Where the Cortex-M architecture has SRAM.
const SRAM: std::ops::Range<u64> = 0x2000_0000..0x4000_0000;

/// What of an image is stored beside its show, and what RAM is static. The stack takes what RAM is left.
pub(crate) fn size(
    name: &str,
    image: &Path,
    show_bytes: u64,
) -> Result<impl Iterator<Item = (Place, u64)> + use<>> {
    let bytes = fs::read(image).with_context(|| format!("{}", image.display()))?;
    let file = object::File::parse(&*bytes)?;
    let (mut stored_bytes, mut static_ram_bytes) = (0, 0);
    for segment in file.segments() {
        let (_, stored) = segment.file_range();
        stored_bytes += stored;
        if SRAM.contains(&segment.address()) {
            static_ram_bytes += segment.size();
        }
    }
    let flash_bytes = stored_bytes
        .checked_sub(show_bytes)
        .with_context(|| format!("{} is smaller than its show", image.display()))?;
    let columns = [("flash", flash_bytes), ("static_ram", static_ram_bytes)];
    Ok(columns.map(|(column, bytes)| (Place::new(SECTION, name, column), bytes)).into_iter())
}
