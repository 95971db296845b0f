//! Starts `sinew-measure`, which reads images. It is apart, since what reads them takes longer to build than all else
//! that `xtask` needs.

use anyhow::Result;
use sinew_steps::step;

/// Runs one of its commands.
pub(crate) fn run(arguments: &[&str]) -> Result<()> {
    let mut measure = step::cargo();
    measure.args(["run", "--quiet", "--locked", "--package", "sinew-measure", "--"]);
    step::run(&arguments.join(" "), measure.args(arguments))
}
