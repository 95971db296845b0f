//! Runs `sinew-measure`, which reads images. It is a separate program because its libraries take longer to build than
//! all other dependencies of `xtask`.

use anyhow::Result;
use sinew_steps::step;

/// Runs one of its commands.
pub(crate) fn run(arguments: &[&str]) -> Result<()> {
    let mut measure = step::cargo();
    measure.args(["run", "--quiet", "--locked", "--package", "sinew-measure", "--"]);
    step::run(&arguments.join(" "), measure.args(arguments))
}
