//! Builds the images, holds what they take against the budget, and compares the emulated board with the host.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSegment};
use sinew_firmware::replay::{METHODS, Replay, TorqueHash};
use sinew_firmware::show::Show;

use crate::budget::{self, Budget, Instructions, Measured, Size};
use crate::{arm, step, table};

/// Bodies of the figure, as the images have it.
const CAPACITY: usize = 18;

/// The image that QEMU runs.
const QEMU_BOARD: &str = "mps2_an386";

/// An image and how long a show fits its flash.
const IMAGES: [(&str, &str); 2] = [(QEMU_BOARD, "21"), ("nucleo_f446re", "10")];

/// Builds and measures the images, with a show of the caller's in place of those that the budget is made for.
pub(crate) fn run(given: Option<&Path>) -> Result<()> {
    let given = given.map(checked).transpose()?;
    let budget = match given {
        None => Some(Budget::parse(&fs::read_to_string(step::root().join(budget::FILE))?)?),
        Some(_) => None,
    };
    let show_of = |board: &str| given.clone().unwrap_or_else(|| baked(board));
    if given.is_none() {
        bake()?;
    }
    build(show_of)?;

    let board = qemu()?;
    let shows_bytes = IMAGES
        .iter()
        .map(|(board, _)| Ok(fs::metadata(show_of(board))?.len()))
        .collect::<Result<Vec<_>>>()?;
    let measured = Measured {
        methods: board.iter().map(|run| (run.method.clone(), run.instructions)).collect(),
        images: IMAGES
            .iter()
            .zip(&shows_bytes)
            .map(|((board, _), show)| Ok(((*board).to_owned(), size(&arm::image(board), *show)?)))
            .collect::<Result<_>>()?,
        shows_bytes,
    };
    println!("\n{}", table::images(&measured, budget.as_ref()));
    println!("{}", table::instructions(&measured, budget.as_ref()));

    let host = host(&show_of(QEMU_BOARD))?;
    println!("{:<20} {:>6}   {:<16}   {:<16}", "method", "ticks", "hash, QEMU", "hash, host");
    for (on_board, on_host) in board.iter().zip(&host) {
        println!(
            "{:<20} {:>6}   {:<16}   {on_host:016x}",
            on_board.method, on_board.ticks, on_board.hash
        );
    }
    let equal = board.len() == host.len()
        && board.iter().zip(&host).all(|(board, host)| board.hash == format!("{host:016x}"));
    ensure!(equal, "the board and the host compute different torques");
    println!("QEMU and the host give the same bits.");

    let Some(budget) = budget else {
        println!("{} is for shows of our own: not compared, SINEW_SHOW is set.", budget::FILE);
        return Ok(());
    };
    let mut problems = budget.exceeded_by(&measured);
    // The budget is that of the compiler which the workspace asks for: Debian's makes smaller programs.
    if arm::toolchain()? == arm::Toolchain::Rustup {
        problems.extend(budget.too_generous_for(&measured));
    }
    ensure!(problems.is_empty(), "{} does not hold:\n  {}", budget::FILE, problems.join("\n  "));
    println!("All is within {}.", budget::FILE);
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

/// Bakes the show of each image.
fn bake() -> Result<()> {
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
            "parity",
        ]),
    )?;
    let simulator = env::current_exe()?.with_file_name(format!("sinew{}", env::consts::EXE_SUFFIX));
    let simulator = simulator.to_str().context("the target folder's name is not UTF-8")?;
    for (board, seconds) in IMAGES {
        let show = baked(board);
        fs::create_dir_all(show.parent().context("the show has a folder")?)?;
        step::run(
            &format!("bake the show of {board}"),
            step::command(simulator)
                .args(["bake", "--clip", "kicks_01", "--scale", "1.1"])
                .args(["--seconds", seconds, "--out"])
                .arg(&show),
        )?;
    }
    Ok(())
}

/// Builds both images, each with its show.
fn build(show_of: impl Fn(&str) -> PathBuf) -> Result<()> {
    let toolchain = arm::toolchain()?;
    for (board, _) in IMAGES {
        step::run(
            &format!("build {board} with {}", toolchain.name()),
            toolchain
                .cargo("build")
                .args(["--package", "sinew-firmware", "--profile", "firmware"])
                .args(["--features", board, "--bin", board])
                .env("SINEW_SHOW", show_of(board)),
        )?;
    }
    Ok(())
}

/// Lints the images as the host's crates are.
pub(crate) fn lint() -> Result<()> {
    let toolchain = arm::toolchain()?;
    if toolchain == arm::Toolchain::Debian {
        eprintln!("\n== clippy of the images: left out, Debian's compiler has none");
        return Ok(());
    }
    for (board, _) in IMAGES {
        step::run(
            &format!("clippy of {board}"),
            toolchain
                .cargo("clippy")
                .args(["--package", "sinew-firmware", "--profile", "firmware"])
                .args(["--features", board, "--bin", board, "--", "--deny", "warnings"])
                .env("SINEW_SHOW", baked(board)),
        )?;
    }
    Ok(())
}

/// The image for QEMU and the show in it, for tests that run them.
pub(crate) fn qemu_image() -> (PathBuf, PathBuf) {
    (arm::image(QEMU_BOARD), baked(QEMU_BOARD))
}

/// Where the show that is baked for a board lies.
fn baked(board: &str) -> PathBuf {
    step::root().join("target/shows").join(board).with_extension("snws")
}

/// Where the Cortex-M architecture has SRAM.
const SRAM: std::ops::Range<u64> = 0x2000_0000..0x4000_0000;

/// What of an image is stored beside its show, and what RAM is static. The stack takes what RAM is left.
fn size(image: &Path, show_bytes: u64) -> Result<Size> {
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
    let program_bytes = stored_bytes
        .checked_sub(show_bytes)
        .with_context(|| format!("{} is smaller than its show", image.display()))?;
    Ok(Size { program_bytes, static_ram_bytes })
}

/// What the board said of one method.
struct Run {
    method: String,
    ticks: String,
    instructions: Instructions,
    hash: String,
}

fn qemu() -> Result<Vec<Run>> {
    let folder = step::root().join("target/qemu");
    fs::create_dir_all(&folder)?;
    let output = Command::new("qemu-system-arm")
        .args(["-machine", "mps2-an386", "-nographic", "-icount", "shift=0"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(arm::image(QEMU_BOARD))
        .current_dir(&folder)
        .output()
        .context("cannot start qemu-system-arm; run `cargo xtask setup`")?;
    let text = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        bail!("QEMU: {}\n{text}{}", output.status, String::from_utf8_lossy(&output.stderr));
    }
    let field = |line: &str, name: &str| {
        line.split_whitespace()
            .filter_map(|word| word.split_once('='))
            .find(|(key, _)| *key == name)
            .map(|(_, value)| value.to_owned())
            .with_context(|| format!("QEMU printed no `{name}` in: {line}"))
    };
    let count = |line: &str, name: &str| {
        field(line, name)?
            .parse()
            .with_context(|| format!("QEMU printed no whole number for `{name}` in: {line}"))
    };
    text.lines()
        .map(|line| {
            Ok(Run {
                method: field(line, "method")?,
                ticks: field(line, "ticks")?,
                instructions: Instructions {
                    control: count(line, "control")?,
                    observe: count(line, "observe")?,
                },
                hash: field(line, "hash")?,
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
        .map(|name| {
            let mut replay = Replay::<CAPACITY>::new(show, name)?;
            let mut hash = TorqueHash::default();
            for tick in 0..show.frame_count() {
                replay.observe(tick)?;
                hash.update(replay.control());
            }
            Ok(hash.value())
        })
        .collect()
}
