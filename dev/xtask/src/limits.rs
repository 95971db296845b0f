//! The limits of `sinew verify` on many rigs: `tests/tests/cross_crate/limits`.

use anyhow::Result;

use crate::step;

/// How many rigs, and as many figures.
const CASES: &str = "10000";

pub(crate) fn run() -> Result<()> {
    let mut test = step::cargo();
    // Of the whole workspace's features: nothing is built twice.
    test.args([
        "test",
        "--locked",
        "--workspace",
        "--test",
        "cross_crate",
        "limits::",
        "--",
        "--nocapture",
    ]);
    // One table after the other; each takes all processors.
    test.arg("--test-threads=1").env("SINEW_CASES", CASES);
    step::run("limits of 10,000 rigs and figures", &mut test)
}
