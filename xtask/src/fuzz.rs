//! Fuzz targets, each crate's in a workspace of its own: they build, and take their corpus.

use std::process::Command;

use anyhow::Result;

use crate::step;

pub(crate) fn run() -> Result<()> {
    for of in ["bus", "link", "firmware"] {
        // Bolero would draw other cases in each run.
        let mut tests = of_crate("test", of);
        step::run(&format!("fuzz targets of {of}"), tests.arg("--no-default-features"))?;
    }
    // Their corpus is replayed by the tests of the crate.
    step::run("fuzz targets of host-sim", of_crate("check", "host-sim").arg("--tests"))
}

fn of_crate(verb: &str, of: &str) -> Command {
    let manifest = format!("{of}/fuzz/Cargo.toml");
    let mut cargo = step::cargo();
    // What it shares with the product's workspace is built once.
    cargo.args([verb, "--locked", "--manifest-path", &manifest, "--target-dir", "target"]);
    cargo
}
