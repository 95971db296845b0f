//! Builds the boards' images, and compares the emulated board with the host.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use sinew_image::{BOARDS, Board, EMULATED};
use sinew_steps::image::{Image, built_in};
use sinew_steps::{arm, step};

use crate::{measure, nextest};

/// An environment variable of a test, and the file that it names.
pub(crate) type Variable = (&'static str, PathBuf);

/// Builds the images of all boards, or of the named board, prints their sizes, and compares torques.
pub(crate) fn run(name: Option<&str>) -> Result<()> {
    let is_meant = |board: &Board| name.is_none_or(|name| name == board.name);
    let boards: Vec<Board> = BOARDS.iter().copied().filter(is_meant).collect();
    let names = || BOARDS.iter().map(|board| board.name).collect::<Vec<_>>().join(", ");
    ensure!(!boards.is_empty(), "{}: no such board; there are {}", name.unwrap_or(""), names());
    nextest::build()?;
    for &board in &boards {
        build(board)?;
    }
    let mut arguments = vec!["sizes"];
    arguments.extend(name);
    measure::run(&arguments)?;
    if boards.contains(&EMULATED) {
        step::run("torques in QEMU and on the host", &mut test()?)?;
    }
    Ok(())
}

/// Builds the images of all boards.
pub(crate) fn all() -> Result<()> {
    nextest::build()?;
    BOARDS.iter().try_for_each(|board| build(*board))
}

/// Returns the test that compares torques.
pub(crate) fn test() -> Result<Command> {
    let mut test = nextest::run()?;
    test.args(["--run-ignored", "only", "--filterset", "test(the_emulated_board_is_the_host)"]);
    test.envs(variables());
    Ok(test)
}

/// Returns the variable with the path of the image for QEMU.
pub(crate) fn variables() -> [Variable; 1] {
    [("SINEW_BOARD_IMAGE", Image::of(EMULATED).path())]
}

/// Builds the image of a board. An image that performs a show by itself gets the figure's show.
pub(crate) fn build(board: Board) -> Result<()> {
    let title = format!("build {} with {}", board.name, arm::toolchain()?.name());
    let mut build = Image::of(board).cargo("build")?;
    if board.qemu_machine.is_some() {
        write_show()?;
        build.envs(built_in());
    }
    step::run(&title, &mut build)
}

/// Writes the figure's rig and show.
fn write_show() -> Result<()> {
    let files = built_in().map(|(_, file)| file);
    for folder in files.iter().filter_map(|file| file.parent()) {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let mut write = Command::new(nextest::program("figure_show")?);
    step::run("write the show of the figure", write.current_dir(step::root()).args(files))
}
