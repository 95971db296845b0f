//! Passes the link arguments of the images for the emulated board.

use std::env;
use std::path::PathBuf;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory");
    println!("cargo:rerun-if-changed=../memory.x");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let package = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    println!("cargo:rustc-link-search={}", package.join("memory").display());
    println!("cargo:rustc-link-search={}", package.join("..").display());
    println!("cargo:rustc-link-arg-bins=--nmagic");
    for script in ["mps2_an386.x", "link.x"] {
        println!("cargo:rustc-link-arg-bins=-T{script}");
    }
}
