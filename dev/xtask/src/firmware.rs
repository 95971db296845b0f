//! Builds the boards' images, and compares the emulated board with the host.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use anyhow::{Context as _, Result, ensure};
use sinew_image::{BOARDS, Baked, Board, EMULATED};
use sinew_steps::image::{Image, baked_show};
use sinew_steps::{arm, step};

use crate::{measure, nextest};

/// An environment variable of a test, and the file that it names.
pub(crate) type Variable = (&'static str, PathBuf);

/// Builds the images of all boards, or of the named one, says what they take, and compares torques.
pub(crate) fn run(name: Option<&str>) -> Result<()> {
    let is_meant = |board: &Board| name.is_none_or(|name| name == board.name);
    let boards: Vec<Board> = BOARDS.iter().copied().filter(is_meant).collect();
    let names = || BOARDS.iter().map(|board| board.name).collect::<Vec<_>>().join(", ");
    ensure!(!boards.is_empty(), "{}: no such board; there are {}", name.unwrap_or(""), names());
    let given = given()?;
    nextest::build()?;
    for &board in &boards {
        build(board, given.as_deref())?;
    }
    let mut arguments = vec!["sizes"];
    arguments.extend(name);
    measure::run(&arguments)?;
    if boards.contains(&EMULATED) {
        step::run("torques in QEMU and on the host", &mut test()?)?;
    }
    Ok(())
}

/// Builds the images of all boards with our own shows.
pub(crate) fn all() -> Result<()> {
    nextest::build()?;
    BOARDS.iter().try_for_each(|board| build(*board, None))
}

/// Returns the test that compares torques, with the show that the image has.
pub(crate) fn test() -> Result<Command> {
    let mut test = nextest::run()?;
    test.args(["--run-ignored", "only", "--filterset", "test(the_emulated_board_is_the_host)"]);
    test.envs(variables()).envs(given()?.map(|show| ("SINEW_BOARD_SHOW", show)));
    Ok(test)
}

/// Returns where tests find the image that QEMU runs, and its show.
pub(crate) fn variables() -> [Variable; 2] {
    [("SINEW_BOARD_IMAGE", Image::of(EMULATED).path()), ("SINEW_BOARD_SHOW", baked_show(EMULATED))]
}

/// Returns the whole path of the caller's show.
fn given() -> Result<Option<PathBuf>> {
    let Some(show) = env::var_os("SINEW_SHOW") else { return Ok(None) };
    let path = Path::new(&show).canonicalize();
    path.map(Some).with_context(|| {
        let show = Path::new(&show).display();
        format!("SINEW_SHOW={show}; make one with `cargo run --release -- bake --out FILE`")
    })
}

/// Builds the image of a board; if it performs a show by itself, with the one that is given, or with ours.
pub(crate) fn build(board: Board, given: Option<&Path>) -> Result<()> {
    let show = match (board.baked, given) {
        (None, _) => None,
        (Some(_), Some(show)) => Some(show.to_owned()),
        (Some(baked), None) => Some(bake(board, baked)?),
    };
    let title = format!("build {} with {}", board.name, arm::toolchain()?.name());
    let mut build = Image::of(board).cargo("build")?;
    step::run(&title, build.envs(show.map(|show| ("SINEW_SHOW", show))))
}

/// Bakes the show of a board.
fn bake(board: Board, Baked { seconds, .. }: Baked) -> Result<PathBuf> {
    let show = baked_show(board);
    fs::create_dir_all(show.parent().context("the show has a folder")?)?;
    let mut bake = Command::new(nextest::program("sinew")?);
    bake.current_dir(step::root()).args(["bake", "kicks_01", "--scale", "1.1"]);
    bake.args(["--seconds", &seconds.to_string(), "--out"]).arg(&show);
    step::run(&format!("bake the show of {}", board.name), &mut bake)?;
    Ok(show)
}
