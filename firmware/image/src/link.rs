//! Link arguments.

use std::env;
use std::path::Path;

use crate::Board;

/// Folder of the workspace.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Name of the board whose memory is the workspace's `memory.x`.
///
/// `link.x` includes `memory.x`, and linkers look for that file in the working directory before any search path. For
/// every image the working directory is the workspace. The `memory.x` of another board therefore does not replace
/// that file but overrides its numbers.
const REFERENCE: &str = "nucleo_f446re";

/// Passes the link arguments for a board to the images of the crate that is built, with the linker scripts `scripts` in
/// addition to `link.x`.
///
/// Does nothing if the target is a host.
///
/// # Panics
/// Panics if the board has no memory.
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

/// Returns a variable that cargo sets for a build script.
pub(crate) fn variable(name: &str) -> String {
    env::var(name).unwrap_or_else(|_| panic!("cargo sets {name} for build scripts"))
}
