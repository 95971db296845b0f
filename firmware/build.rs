//! Picks the memory of the image's board, passes the link arguments, and finds the show to bake in.
//!
//! A build for a host has nothing to do here.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// Images, and the link scripts each needs beside `link.x`. The reference board's memory is the
/// workspace's `memory.x`, which `link.x` includes; a script of another board overrides its numbers.
const BOARDS: [(&str, &[&str]); 2] =
    [("mps2_an386", &["mps2_an386.x"]), ("nucleo_f446re", &["defmt.x"])];

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
    bake(Path::new(&env::var_os("OUT_DIR").expect("cargo sets it")));
}

/// Puts the show where the image includes it from.
fn bake(out: &Path) {
    let Some(show) = env::var_os("SINEW_SHOW") else {
        panic!(
            "SINEW_SHOW must name a baked show: make one with `cargo run --release -- bake --out FILE`, \
             or build the images with `cargo xtask firmware`"
        );
    };
    println!("cargo:rerun-if-changed={}", show.display());
    if let Err(error) = fs::copy(&show, out.join("show.snws")) {
        panic!("SINEW_SHOW={}: {error}", show.display());
    }
}
