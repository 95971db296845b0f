//! Builds the boards' images, and compares the emulated board with the host.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use sinew_bit_parity::replay::{METHODS, Replay, TorqueHash};
use sinew_firmware::show::Show;
use sinew_image::{BOARDS, Baked, Board, EMULATED};

use crate::budget::{self, Figures, Place, field, number};
use crate::image::Image;
use crate::{arm, step};

/// Bodies that this program holds: as many as any board. The bits do not depend on it.
const CAPACITY: usize = 64;

/// Instructions of ticks over the whole show of the image for QEMU.
const SECTION: &str = "show_instructions";

/// Builds all images, and says what they take.
pub(crate) fn run() -> Result<Figures> {
    of(BOARDS, None)
}

/// Builds the images of boards, with a show of the caller's in place of ours, and says what they take.
fn of(boards: &[Board], given: Option<&Path>) -> Result<Figures> {
    let given = given.map(checked).transpose()?;
    let show_of =
        |board: Board| board.baked.is_some().then(|| given.clone().unwrap_or_else(|| baked(board)));
    if given.is_none() {
        bake(boards)?;
    }
    for &board in boards {
        build(board, show_of(board))?;
    }

    let mut figures = Figures::default();
    for &board in boards {
        let show_bytes =
            show_of(board).map_or(Ok(0), |show| fs::metadata(show).map(|it| it.len()))?;
        let image = Image::of(board).path();
        figures.extend(budget::size(board.name, &image, show_bytes)?);
        if board.baked.is_none() {
            figures.extend(budget::node(board.name, &image)?);
        }
    }
    for &board in boards.iter().filter(|board| board.qemu_machine.is_some()) {
        let Some(show) = show_of(board) else { continue };
        let runs = emulated(board)?;
        compare(board, &runs, &host(&show)?)?;
        // One board's are enough: the instructions are those of the processor.
        for run in runs.iter().filter(|_| board == EMULATED) {
            for (column, instructions) in &run.instructions {
                figures.add(Place::new(SECTION, &run.method, column), *instructions);
            }
        }
    }
    Ok(figures)
}

/// Prints the hashes of a board's runs beside the host's, and fails if they differ.
fn compare(board: Board, runs: &[Run], host: &[u64]) -> Result<()> {
    let name = board.name;
    let mut rows =
        vec![["method", "ticks", "hash, QEMU", "hash, host"].map(str::to_owned).to_vec()];
    for (Run { method, ticks, hash, .. }, on_host) in runs.iter().zip(host) {
        rows.push(vec![method.clone(), ticks.clone(), hash.clone(), format!("{on_host:016x}")]);
    }
    println!("\n{}", budget::aligned(&rows));
    let equal = runs.len() == host.len()
        && runs.iter().zip(host).all(|(run, host)| run.hash == format!("{host:016x}"));
    ensure!(equal, "{name} and the host compute different torques");
    println!("{name} in QEMU and the host give the same bits.\n");
    Ok(())
}

/// The same of all boards or of a named one, and prints what the images take.
pub(crate) fn show(name: Option<&str>, given: Option<&Path>) -> Result<()> {
    let boards: Vec<Board> =
        BOARDS.iter().copied().filter(|board| name.is_none_or(|name| name == board.name)).collect();
    let names = || BOARDS.iter().map(|board| board.name).collect::<Vec<_>>().join(", ");
    ensure!(!boards.is_empty(), "{}: no such board; there are {}", name.unwrap_or(""), names());
    let figures = of(&boards, given)?;
    for section in figures.names(|place| Some(&place.section)) {
        println!("{}", budget::section(&figures, None, section));
    }
    Ok(())
}

/// The whole path of a show, if the images can perform it.
fn checked(show: &Path) -> Result<PathBuf> {
    let whole_path = || -> Result<PathBuf> {
        Show::parse(&fs::read(show)?)?.tree::<CAPACITY>()?;
        Ok(show.canonicalize()?)
    };
    whole_path().with_context(|| {
        format!(
            "SINEW_SHOW={} is no show; make one with `cargo run --release -- bake --out FILE`",
            show.display()
        )
    })
}

/// Bakes the show of each image that performs one by itself.
fn bake(boards: &[Board]) -> Result<()> {
    if boards.iter().all(|board| board.baked.is_none()) {
        return Ok(());
    }
    // With a test beside it, the simulator is built of the very crates that the tests are: nothing is built twice.
    step::run(
        "build the simulator",
        step::cargo().args([
            "build",
            "--locked",
            "--workspace",
            "--bin",
            "sinew",
            "--test",
            "memory",
        ]),
    )?;
    let simulator = env::current_exe()?.with_file_name(format!("sinew{}", env::consts::EXE_SUFFIX));
    let simulator = simulator.to_str().context("the target folder's name is not UTF-8")?;
    for &board in boards {
        let Some(Baked { seconds, .. }) = board.baked else { continue };
        let show = baked(board);
        fs::create_dir_all(show.parent().context("the show has a folder")?)?;
        step::run(
            &format!("bake the show of {}", board.name),
            step::command(simulator)
                .args(["bake", "kicks_01", "--scale", "1.1"])
                .args(["--seconds", &seconds.to_string(), "--out"])
                .arg(&show),
        )?;
    }
    Ok(())
}

/// Builds the image of one board, with its show, if it performs one by itself.
fn build(board: Board, show: Option<PathBuf>) -> Result<()> {
    step::run(
        &format!("build {} with {}", board.name, arm::toolchain()?.name()),
        Image::of(board).cargo("build")?.envs(show.map(|show| ("SINEW_SHOW", show))),
    )
}

/// Where the show that is baked for a board lies.
pub(crate) fn baked(board: Board) -> PathBuf {
    step::root().join("target/shows").join(board.name).with_extension("snws")
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

/// The hashes of the same run here.
fn host(show: &Path) -> Result<Vec<u64>> {
    let bytes = fs::read(show)?;
    let show = Show::parse(&bytes)?;
    METHODS
        .into_iter()
        .map(|method| {
            let mut replay = Replay::<CAPACITY>::new(show, method)?;
            let mut hash = TorqueHash::default();
            for tick in 0..u32::try_from(show.frame_count())? {
                hash.update(replay.step(tick)?.torques());
            }
            Ok(hash.value())
        })
        .collect()
}
