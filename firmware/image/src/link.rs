//! Link arguments.

use std::env;
use std::path::Path;

use crate::Board;

/// The workspace's folder.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// The board whose memory is the workspace's `memory.x`.
///
/// `link.x` includes `memory.x`, and linkers look for it in the working directory before any search path: that is the
/// workspace, for every image. So the `memory.x` of another board does not replace that file but overrides its numbers.
const REFERENCE: &str = "nucleo_f446re";

/// Passes what the images of the crate that is built need to be linked for a board, with `scripts` beside `link.x`.
///
/// For a host there is nothing to do.
///
/// # Panics
/// If the board has no memory.
pub fn link(board: Board, scripts: &[&str]) {
    println!("cargo:rerun-if-changed=build.rs");
    if variable("CARGO_CFG_TARGET_OS") != "none" {
        return;
    }
    println!("cargo:rustc-link-search={ROOT}");
    println!("cargo:rerun-if-changed={ROOT}/memory.x");
    println!("cargo:rustc-link-arg-bins=--nmagic");
    if board.name != REFERENCE {
        let memory = format!("{ROOT}/{}/memory.x", board.folder);
        assert!(Path::new(&memory).exists(), "{memory} is missing: where the board has its memory");
        println!("cargo:rerun-if-changed={memory}");
        println!("cargo:rustc-link-arg-bins=-T{memory}");
    }
    for script in scripts.iter().chain(&["link.x"]) {
        println!("cargo:rustc-link-arg-bins=-T{script}");
    }
}

/// What cargo tells a build script.
pub(crate) fn variable(name: &str) -> String {
    env::var(name).unwrap_or_else(|_| panic!("cargo sets {name} for build scripts"))
}
