//! Fuzz targets, each crate's in a workspace of its own: they build, and take their corpus.

use anyhow::Result;

use crate::step;

pub(crate) fn run() -> Result<()> {
    for of in ["bus", "link", "firmware"] {
        step::run(&format!("fuzz targets of {of}"), &mut of_crate("test", of))?;
    }
    // Their corpus is replayed by the tests of the crate.
    step::run("fuzz targets of host-sim", of_crate("check", "host-sim").arg("--tests"))
}

fn of_crate(verb: &str, of: &str) -> std::process::Command {
    let manifest = format!("{of}/fuzz/Cargo.toml");
    let mut cargo = step::cargo();
    cargo.args([verb, "--locked", "--manifest-path", &manifest]);
    // What it shares with the product's workspace is built once. Bolero would draw other cases in each run.
    cargo.args(["--target-dir", "target", "--no-default-features"]);
    cargo
}
