//! The boards' own images: their flash and RAM, and the instructions that QEMU counts in the one that it can run.

use std::fs;

use anyhow::{Context as _, Result, bail, ensure};
use sinew_image::{BOARDS, Board, EMULATED};
use sinew_steps::image::{Image, built_in};

use super::figures::{FigureKey, Figures};
use super::printed::{field, number};
use super::trace::qemu;
use super::{images, tables};

/// Instructions of the ticks over the whole show of the image for QEMU.
const SECTION: &str = "show_instructions";

/// Prints the sizes of the named boards' images; without names, of all. They must have been built.
pub(crate) fn sizes(names: &[&str]) -> Result<()> {
    let is_meant = |board: &Board| names.is_empty() || names.contains(&board.name);
    let boards: Vec<Board> = BOARDS.iter().copied().filter(is_meant).collect();
    ensure!(names.len() <= boards.len(), "{}: no such board", names.join(", "));
    let figures = of(&boards)?;
    for section in figures.names(|place| Some(&place.section)) {
        println!("{}", tables::section(&figures, None, section));
    }
    Ok(())
}

/// Returns the sizes of all boards' images.
pub(super) fn all() -> Result<Figures> {
    of(BOARDS)
}

/// Returns the sizes of boards' images, without the files that are built into that of an emulated board.
fn of(boards: &[Board]) -> Result<Figures> {
    let mut figures = Figures::default();
    for &board in boards {
        let image = Image::of(board).path();
        let files = if board.qemu_machine.is_some() { built_in().to_vec() } else { Vec::new() };
        let lengths = files.iter().map(|(_, file)| fs::metadata(file).map(|it| it.len()));
        let show_bytes = lengths.sum::<std::io::Result<u64>>()?;
        figures.extend(images::size(board.name, &image, show_bytes)?);
        if board.qemu_machine.is_none() {
            figures.extend(images::node(board.name, &image)?);
        }
    }
    // One board is enough: the instructions depend only on the processor.
    if boards.contains(&EMULATED) {
        figures.extend(instructions(EMULATED)?);
    }
    Ok(figures)
}

/// Runs a board's image in QEMU, and returns the mean and largest number of instructions of its ticks.
fn instructions(board: Board) -> Result<Vec<(FigureKey, u64)>> {
    let output = qemu(board, &Image::of(board).path(), &["-icount", "shift=0"])?
        .output()
        .context("cannot start qemu-system-arm; run `cargo xtask setup`")?;
    let text = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        bail!("QEMU: {}\n{text}{}", output.status, String::from_utf8_lossy(&output.stderr));
    }
    let mut figures = Vec::new();
    for line in text.lines() {
        let method = field(line, "method")?;
        for (column, of) in [("tick", "tick"), ("worst_tick", "worst")] {
            figures.push((FigureKey::new(SECTION, method, column), number(line, of)?));
        }
    }
    Ok(figures)
}
