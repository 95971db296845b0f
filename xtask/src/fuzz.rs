//! Fuzz targets of the bus, in a workspace of their own: they build, and take their corpus.

use anyhow::Result;

use crate::step;

pub(crate) fn run() -> Result<()> {
    let mut tests = step::cargo();
    tests.args(["test", "--locked", "--manifest-path", "bus/fuzz/Cargo.toml"]);
    // What it shares with the product's workspace is built once. Bolero would draw other cases in each run.
    tests.args(["--target-dir", "target", "--no-default-features"]);
    step::run("fuzz targets of the bus", &mut tests)
}
