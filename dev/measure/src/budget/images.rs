//! The bench crate's images, and the flash and RAM of images.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use object::{Object, ObjectSection, ObjectSegment};

use super::figures::{FigureKey, Figures};
use super::stack;
use crate::elf::Elf;
use sinew_steps::image::Image;
use sinew_steps::step;

/// Sizes of images without their shows.
pub(crate) const SECTION: &str = "image_bytes";

/// Image with every kernel and every kind of tick, each measured separately.
pub(super) const KERNELS: Image =
    Image { package: "sinew-bench", name: "kernels", feature: Some("mps2_an386") };

/// Image with ticks of rigs of servos.
pub(super) const SERVOS: Image = Image { name: "servos", ..KERNELS };

/// Image with a show of 20 servos.
pub(super) const SHOW: Image = Image { name: "show", ..KERNELS };

/// Image with a cycle of buses of 18 servos.
pub(super) const BUS: Image = Image { name: "bus", ..KERNELS };

/// Image with a tick of the drives of 18 servos.
pub(super) const DRIVES: Image = Image { name: "drives", ..KERNELS };

/// Image with a tick of the whole loop.
pub(super) const WHOLE_LOOP: Image = Image { name: "whole_loop", ..KERNELS };

/// Image with World, Linear Compensation and inverse dynamics only.
const CORE_ALONE: Image = Image { name: "core_alone", ..KERNELS };

/// All images of the bench.
pub(crate) const IMAGES: [Image; 7] = [KERNELS, SERVOS, SHOW, BUS, DRIVES, WHOLE_LOOP, CORE_ALONE];

/// Flags for names that distinguish instances of a generic function, and for frame sizes in the image.
const FLAGS: &str = "-C symbol-mangling-version=v0 -Z emit-stack-sizes";

/// Builds all images in one command: each is optimized as a whole, on one core.
pub(crate) fn build() -> Result<()> {
    let mut cargo = KERNELS.cargo("build")?;
    for image in IMAGES.iter().filter(|image| image.name != KERNELS.name) {
        cargo.args(["--bin", image.name]);
    }
    // The flag for frame sizes needs a nightly compiler, or this variable.
    cargo.env("RUSTFLAGS", FLAGS).env("RUSTC_BOOTSTRAP", "1");
    step::run(&format!("build {}", IMAGES.map(|image| image.name).join(", ")), &mut cargo)
}

/// Name of the tick of the core alone, of 18 bodies and without room for resolved acceleration.
const CORE_TICK: &str = "<sinew_bench::rig::Rig<18>>::tick";

/// Returns the sizes of the core alone: the image, and the part that a tick can execute, with all constants.
pub(crate) fn core_alone() -> Result<impl Iterator<Item = (FigureKey, u64)>> {
    let Image { name, .. } = CORE_ALONE;
    let image = CORE_ALONE.path();
    let tick = (FigureKey::new(SECTION, name, "tick"), reachable_bytes(&image, CORE_TICK)?);
    Ok(size(name, &image, 0)?.chain([tick]))
}

/// Returns the size of the code that a tick of the whole loop can execute, with its constants, by the number of
/// servos. Constants are those of all sizes together, without the rigs and shows of the image, whose sizes are among
/// `figures`.
pub(super) fn whole_loop(sizes: &[&str], figures: &Figures) -> Result<Vec<(FigureKey, u64)>> {
    let Image { name, .. } = WHOLE_LOOP;
    let files = ["loop_rig_file", "loop_show_file"];
    let stored = figures.iter().filter(|(place, _)| files.contains(&place.row.as_str()));
    let stored_bytes: u64 = stored.map(|(_, bytes)| bytes).sum();
    let of_size = |size: &&str| {
        let bytes = reachable_bytes(&WHOLE_LOOP.path(), &format!("{name}::loop_tick::<{size}>"))?;
        let bytes = bytes.checked_sub(stored_bytes).context("the image has no rigs and shows")?;
        Ok((FigureKey::new("loop_flash_bytes", "loop_tick", size), bytes))
    };
    sizes.iter().map(of_size).collect()
}

/// Returns the size of the code that a function can reach, plus all constants of its image.
fn reachable_bytes(image: &Path, function: &str) -> Result<u64> {
    let elf = Elf::load(image)?;
    let root = elf.named(function).with_context(|| format!("the image has no `{function}`"))?;
    let code = elf.reachable_from(&[root]).into_iter().map(|index| elf.functions()[index].size);
    let bytes = fs::read(image)?;
    let file = object::File::parse(&*bytes)?;
    let constants = file.section_by_name(".rodata").map_or(0, |section| section.size());
    Ok(code.sum::<u64>() + constants)
}

const STATIC_RAM: &str = "static_ram";

/// Addresses of SRAM in the Cortex-M architecture.
const SRAM: std::ops::Range<u64> = 0x2000_0000..0x4000_0000;

/// Returns the stored size of an image without its show, and its static RAM. The stack uses the remaining RAM.
pub(crate) fn size(
    name: &str,
    image: &Path,
    show_bytes: u64,
) -> Result<impl Iterator<Item = (FigureKey, u64)> + use<>> {
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
    let columns = [("flash", flash_bytes), (STATIC_RAM, static_ram_bytes)];
    Ok(columns.map(|(column, bytes)| (FigureKey::new(SECTION, name, column), bytes)).into_iter())
}

/// Returns the RAM of the image of a board that runs the node: the largest depth of its stack, and the sum with
/// static RAM.
pub(crate) fn node(name: &str, image: &Path) -> Result<[(FigureKey, u64); 2]> {
    let of_stack = stack::of_image(image)?;
    let is_static = |(place, _): &(FigureKey, u64)| place.column == STATIC_RAM;
    let (_, of_statics) = size(name, image, 0)?.find(is_static).context("it has no RAM")?;
    Ok([("stack", of_stack), ("ram", of_statics + of_stack)]
        .map(|(column, bytes)| (FigureKey::new(SECTION, name, column), bytes)))
}
