//! Picks the memory of the image's board, passes the link arguments, and finds the show to bake in.
//!
//! A build for a host has nothing to do here.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// Image, memory, further link scripts.
const BOARDS: [(&str, &str, &[&str]); 2] =
    [("mps2_an386", "memory/mps2_an386.x", &[]), ("nucleo_f446re", "../memory.x", &["-Tdefmt.x"])];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=SINEW_SHOW");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let boards: Vec<_> = BOARDS
        .iter()
        .filter(|(board, ..)| {
            env::var_os(format!("CARGO_FEATURE_{}", board.to_uppercase())).is_some()
        })
        .collect();
    let (image, memory, scripts) = match boards.as_slice() {
        [] => return,
        [board] => board,
        _ => panic!("choose one board: features {:?} are images of their own", BOARDS.map(|b| b.0)),
    };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo:rerun-if-changed={memory}");
    fs::copy(memory, out.join("memory.x")).expect("the board's memory can be copied to OUT_DIR");
    println!("cargo:rustc-link-search={}", out.display());
    for argument in ["--nmagic", "-Tlink.x"].iter().chain(*scripts) {
        println!("cargo:rustc-link-arg-bin={image}={argument}");
    }
    bake(&out);
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
