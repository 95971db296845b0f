//! Builds the boards' images, and compares the emulated board with the host.

use std::env;
use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use sinew_image::{BOARDS, Board, EMULATED};

use crate::budget::{self, Figures, Place, field, number};
use crate::image::Image;
use crate::{arm, step};

/// Instructions of ticks over the whole show of the image for QEMU.
const SECTION: &str = "show_instructions";

/// Builds all images, and says what they take.
pub(crate) fn run() -> Result<Figures> {
    of(BOARDS)
}

/// Builds the images of boards, compares the emulated one with this machine, and says what they take.
fn of(boards: &[Board]) -> Result<Figures> {
    let emulates = boards.iter().any(|board| board.qemu_machine.is_some());
    let host = emulates.then(make_show).transpose()?;
    for &board in boards {
        build(board)?;
    }

    let mut figures = Figures::default();
    for &board in boards {
        let built_in = if board.qemu_machine.is_some() { built_in().to_vec() } else { Vec::new() };
        let lengths = built_in.iter().map(|(_, file)| fs::metadata(file).map(|it| it.len()));
        let built_in_bytes = lengths.sum::<std::io::Result<u64>>()?;
        let image = Image::of(board).path();
        figures.extend(budget::size(board.name, &image, built_in_bytes)?);
        if board.qemu_machine.is_none() {
            figures.extend(budget::node(board.name, &image)?);
        }
    }
    for &board in boards.iter().filter(|board| board.qemu_machine.is_some()) {
        let runs = emulated(board)?;
        compare(board, &runs, host.as_deref().unwrap_or_default())?;
        // One board's are enough: the instructions are those of the processor.
        for run in runs.iter().filter(|_| board == EMULATED) {
            for (column, instructions) in &run.instructions {
                figures.add(Place::new(SECTION, &run.method, column), *instructions);
            }
        }
    }
    Ok(figures)
}

/// Prints what a board said of its runs beside what this machine says, and fails if they differ.
fn compare(board: Board, runs: &[Run], host: &[String]) -> Result<()> {
    let name = board.name;
    let mut rows =
        vec![["method", "ticks", "hash, QEMU", "hash, host"].map(str::to_owned).to_vec()];
    let mut is_equal = runs.len() == host.len();
    for (Run { method, ticks, hash, .. }, line) in runs.iter().zip(host) {
        rows.push(vec![
            method.clone(),
            ticks.clone(),
            hash.clone(),
            field(line, "hash")?.to_owned(),
        ]);
        is_equal &= *line == format!("method={method} ticks={ticks} hash={hash}");
    }
    println!("\n{}", budget::aligned(&rows));
    ensure!(is_equal, "{name} and the host compute different torques");
    println!("{name} in QEMU and the host give the same bits.\n");
    Ok(())
}

/// The same of all boards or of a named one, and prints what the images take.
pub(crate) fn show(name: Option<&str>) -> Result<()> {
    let boards: Vec<Board> =
        BOARDS.iter().copied().filter(|board| name.is_none_or(|name| name == board.name)).collect();
    let names = || BOARDS.iter().map(|board| board.name).collect::<Vec<_>>().join(", ");
    ensure!(!boards.is_empty(), "{}: no such board; there are {}", name.unwrap_or(""), names());
    let figures = of(&boards)?;
    for section in figures.names(|place| Some(&place.section)) {
        println!("{}", budget::section(&figures, None, section));
    }
    Ok(())
}

/// The files that are built into the image of an emulated board, by the environment variables that name them: the human
/// figure in a rig's compact form, and a show of it.
pub(crate) fn built_in() -> [(&'static str, PathBuf); 2] {
    let file = |extension| step::root().join("target/shows/figure").with_extension(extension);
    [("SINEW_RIG", file("snwr")), ("SINEW_SHOW", file("show"))]
}

/// Writes these files, and returns what this machine computes for the show: a line for each method.
fn make_show() -> Result<Vec<String>> {
    // With a test beside it, the program is built of the very crates that the tests are: nothing is built twice.
    step::run(
        "build the figure's show",
        step::cargo().args([
            "build",
            "--locked",
            "--workspace",
            "--bin",
            "figure_show",
            "--test",
            "parity",
        ]),
    )?;
    let name = format!("figure_show{}", env::consts::EXE_SUFFIX);
    let program = env::current_exe()?.with_file_name(name);
    let files = built_in().map(|(_, file)| file);
    for folder in files.iter().filter_map(|file| file.parent()) {
        fs::create_dir_all(folder)?;
    }
    let program = program.to_str().context("the target folder's name is not UTF-8")?;
    let output = step::command(program).args(files).output()?;
    if !output.status.success() {
        bail!("figure_show: {}\n{}", output.status, String::from_utf8_lossy(&output.stderr));
    }
    Ok(String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect())
}

/// Builds the image of one board.
fn build(board: Board) -> Result<()> {
    step::run(
        &format!("build {} with {}", board.name, arm::toolchain()?.name()),
        Image::of(board).cargo("build")?.envs(built_in()),
    )
}

/// What the board said of one method.
struct Run {
    method: String,
    ticks: String,
    /// On average, and the most of a tick.
    instructions: Vec<(&'static str, u64)>,
    hash: String,
}

/// Runs a board's image in QEMU.
fn emulated(board: Board) -> Result<Vec<Run>> {
    let folder = step::root().join("target/qemu");
    fs::create_dir_all(&folder)?;
    let output = budget::qemu(board, &Image::of(board).path(), &["-icount", "shift=0"])?
        .current_dir(&folder)
        .output()
        .context("cannot start qemu-system-arm; run `cargo xtask setup`")?;
    let text = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        bail!("QEMU: {}\n{text}{}", output.status, String::from_utf8_lossy(&output.stderr));
    }
    text.lines()
        .map(|line| {
            let (tick, worst) = (number(line, "tick")?, number(line, "worst")?);
            Ok(Run {
                method: field(line, "method")?.to_owned(),
                ticks: field(line, "ticks")?.to_owned(),
                instructions: vec![("tick", tick), ("worst_tick", worst)],
                hash: field(line, "hash")?.to_owned(),
            })
        })
        .collect()
}
