//! Builds the images, says what they take, and compares the emulated board with the host.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSegment};
use sinew_firmware::replay::{METHODS, Replay, TorqueHash};
use sinew_firmware::show::Show;

use crate::{arm, step};

/// Bodies of the figure, as the images have it.
const CAPACITY: usize = 18;

/// The image that QEMU runs.
const QEMU_BOARD: &str = "mps2_an386";

/// An image and how long a show fits its flash.
const IMAGES: [(&str, &str); 2] = [(QEMU_BOARD, "21"), ("nucleo_f446re", "10")];

pub(crate) fn run() -> Result<()> {
    build()?;
    println!("\n{:<16} {:>10} {:>10}", "image", "flash, B", "RAM, B");
    for (board, _) in IMAGES {
        let (flash, ram) = size(&arm::image(board))?;
        println!("{board:<16} {flash:>10} {ram:>10}");
    }
    let board = qemu()?;
    let host = host()?;
    println!(
        "\n{:<20} {:>6} {:>21} {:>21}   {:<16}   {:<16}",
        "method",
        "ticks",
        "instructions, control",
        "instructions, observe",
        "hash, QEMU",
        "hash, host"
    );
    for (on_board, on_host) in board.iter().zip(&host) {
        println!(
            "{:<20} {:>6} {:>21} {:>21}   {:<16}   {on_host:016x}",
            on_board.method, on_board.ticks, on_board.control, on_board.observe, on_board.hash
        );
    }
    let equal = board.len() == host.len()
        && board.iter().zip(&host).all(|(board, host)| board.hash == format!("{host:016x}"));
    ensure!(equal, "the board and the host compute different torques");
    println!("QEMU and the host give the same bits.");
    Ok(())
}

/// Builds both images with the show that is baked for each.
pub(crate) fn build() -> Result<()> {
    let toolchain = arm::toolchain()?;
    for (board, seconds) in IMAGES {
        let show = show(board);
        fs::create_dir_all(show.parent().context("the show has a folder")?)?;
        step::run(
            &format!("bake the show of {board}"),
            step::cargo()
                .args(["run", "--quiet", "--release", "--package", "sinew-sim", "--", "bake"])
                .args(["--clip", "kicks_01", "--scale", "1.1", "--seconds", seconds, "--out"])
                .arg(&show),
        )?;
        step::run(
            &format!("build {board} with {}", toolchain.name()),
            toolchain
                .cargo("build")
                .args(["--package", "sinew-firmware", "--profile", "firmware"])
                .args(["--features", board, "--bin", board])
                .env("SINEW_SHOW", &show),
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
                .env("SINEW_SHOW", show(board)),
        )?;
    }
    Ok(())
}

/// The image for QEMU and the show in it, for tests that run them.
pub(crate) fn qemu_image() -> (PathBuf, PathBuf) {
    (arm::image(QEMU_BOARD), show(QEMU_BOARD))
}

fn show(board: &str) -> PathBuf {
    step::root().join("target/shows").join(board).with_extension("snws")
}

/// Where the Cortex-M architecture has SRAM.
const SRAM: std::ops::Range<u64> = 0x2000_0000..0x4000_0000;

/// Flash and RAM of an image, in bytes: what is stored, and what is static. The stack takes what RAM is left.
fn size(image: &Path) -> Result<(u64, u64)> {
    let bytes = fs::read(image).with_context(|| format!("{}", image.display()))?;
    let file = object::File::parse(&*bytes)?;
    let (mut flash, mut ram) = (0, 0);
    for segment in file.segments() {
        let (_, stored) = segment.file_range();
        flash += stored;
        if SRAM.contains(&segment.address()) {
            ram += segment.size();
        }
    }
    Ok((flash, ram))
}

/// What the board said of one method.
struct Report {
    method: String,
    ticks: String,
    control: String,
    observe: String,
    hash: String,
}

fn qemu() -> Result<Vec<Report>> {
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
    text.lines()
        .map(|line| {
            Ok(Report {
                method: field(line, "method")?,
                ticks: field(line, "ticks")?,
                control: field(line, "control")?,
                observe: field(line, "observe")?,
                hash: field(line, "hash")?,
            })
        })
        .collect()
}

/// The hashes of the same run here.
fn host() -> Result<Vec<u64>> {
    let bytes = fs::read(show(QEMU_BOARD))?;
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
