//! Fuzz targets, each crate's in a workspace of its own: they build, and take their corpus.

use anyhow::Result;

use crate::step;

pub(crate) fn run() -> Result<()> {
    for of in ["bus", "link", "firmware"] {
        let manifest = format!("{of}/fuzz/Cargo.toml");
        let mut tests = step::cargo();
        tests.args(["test", "--locked", "--manifest-path", &manifest]);
        // What it shares with the product's workspace is built once. Bolero would draw other cases in each run.
        tests.args(["--target-dir", "target", "--no-default-features"]);
        step::run(&format!("fuzz targets of {of}"), &mut tests)?;
    }
    Ok(())
}
