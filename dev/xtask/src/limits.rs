//! Checks the limits of `sinew evaluate verify` on many rigs: `tests/tests/cross_crate/limits`.

use anyhow::Result;

use sinew_steps::step;

use crate::nextest;

/// Number of rigs, and of figures.
const CASES: &str = "10000";

pub(crate) fn run() -> Result<()> {
    let mut test = nextest::run()?;
    // One table after the other; each uses all processors.
    test.args(["--no-capture", "--filterset", "test(/^limits::/)"]).env("SINEW_CASES", CASES);
    step::run("limits of 10,000 rigs and figures", &mut test)
}
