//! Picks the memory of the image's board, passes the link arguments, and finds the show to bake in.
//!
//! A build for a host has nothing to do here.

use std::path::{Path, PathBuf};
use std::{env, fs};

#[path = "src/show.rs"]
#[expect(dead_code, unreachable_pub, reason = "the library's own file, of which this reads a show")]
mod show;

/// Images, and the link scripts each needs beside `link.x`. The reference board's memory is the
/// workspace's `memory.x`, which `link.x` includes; a script of another board overrides its numbers.
const BOARDS: [(&str, &[&str]); 4] = [
    ("mps2_an386", &["mps2_an386.x"]),
    ("nucleo_f446re", &["defmt.x"]),
    ("audit", &["mps2_an386.x"]),
    ("parity", &["mps2_an386.x"]),
];

/// Images that have no show baked in: `cargo xtask audit` does not run its own, `cargo xtask parity` sends shows.
const WITHOUT_SHOW: [&str; 2] = ["audit", "parity"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=SINEW_SHOW");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let has_feature =
        |board: &str| env::var_os(format!("CARGO_FEATURE_{}", board.to_uppercase())).is_some();
    let chosen: Vec<_> = BOARDS.iter().filter(|(board, _)| has_feature(board)).collect();
    let (image, scripts) = match chosen.as_slice() {
        [] => return,
        [board] => board,
        _ => panic!("choose one board: each of {:?} is an image of its own", BOARDS.map(|b| b.0)),
    };
    let package = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    println!("cargo:rustc-link-search={}", package.join("memory").display());
    println!("cargo:rerun-if-changed=memory");
    println!("cargo:rerun-if-changed=../memory.x");
    println!("cargo:rustc-link-search={}", package.join("..").display());
    println!("cargo:rustc-link-arg-bin={image}=--nmagic");
    for script in scripts.iter().chain(&["link.x"]) {
        println!("cargo:rustc-link-arg-bin={image}=-T{script}");
    }
    if !WITHOUT_SHOW.contains(image) {
        bake(Path::new(&env::var_os("OUT_DIR").expect("cargo sets it")));
    }
}

/// Puts the show where the image includes it from: a show that the image could perform, or the build ends.
fn bake(out: &Path) {
    const HELP: &str = "make a show with `cargo run --release -- bake --out FILE`, or build the images with \
        `cargo xtask firmware`";
    let Some(path) = env::var_os("SINEW_SHOW").map(PathBuf::from) else {
        panic!("SINEW_SHOW must name a show: {HELP}");
    };
    let name = format!("SINEW_SHOW={}", path.display());
    // Cargo runs this in the package's folder, not in the caller's.
    assert!(path.is_absolute(), "{name} must be a whole path, such as $PWD/FILE");
    println!("cargo:rerun-if-changed={}", path.display());
    let show = fs::read(&path).unwrap_or_else(|error| panic!("{name}: {error}; {HELP}"));
    if let Err(error) = show::Show::parse(&show) {
        panic!("{name}: {error}; {HELP}");
    }
    fs::write(out.join("show.snws"), show).expect("cargo's folder can be written to");
}
