//! Retargets clips to robots, scores the results and those of GMR with a foreign program, and compares all scores.
//! `crates/retarget/tests/gmr/README.md` describes the scores.

use std::ffi::OsString;
use std::path::PathBuf;

use anyhow::{Context as _, Result, ensure};

use crate::nextest;
use crate::python::Venv;
use sinew_steps::step;

/// Packages that the scoring script imports, in tested versions.
const PACKAGES: [&str; 3] = ["numpy==2.4.6", "scipy==1.17.1", "mujoco==4.0.0"];
/// File of the committed scores.
const SCORES: &str = "docs/retargeting.csv";
/// Variable with the folder of the scoring script.
pub(crate) const REFERENCE: &str = "SINEW_REFERENCE";

/// Computes scores, and compares them with the committed ones. With `accept`, writes them instead.
pub(crate) fn run(accept: bool) -> Result<()> {
    let folder = |variable| -> Result<OsString> {
        std::env::var_os(variable).with_context(|| format!("{variable} is not set"))
    };
    let reference = PathBuf::from(folder(REFERENCE)?).join("retargeting");
    let data = folder("SINEW_DATA")?;
    let venv = Venv::install("retargeting", &PACKAGES, &PACKAGES.join("\n"), |_| Ok(()))?;
    nextest::build()?;
    let sinew = nextest::program("sinew")?;
    let made = venv.folder.join("made");
    let _ = std::fs::remove_dir_all(&made);
    std::fs::create_dir_all(&made)?;
    let mut python = venv.python(&step::root().join("crates/retarget/tests/gmr/scores.py"));
    python.args([reference.into_os_string(), data, sinew.into(), made.clone().into()]);
    let scored = made.join("scores.csv");
    python.stdout(std::fs::File::create(&scored)?);
    step::run("clips on robots, scored", &mut python)?;
    let (found, committed) = (std::fs::read_to_string(&scored)?, step::root().join(SCORES));
    if accept {
        return std::fs::write(&committed, found).context(SCORES);
    }
    let known = std::fs::read_to_string(&committed).context(SCORES)?;
    let changed = found.lines().zip(known.lines()).find(|(found, known)| found != known);
    let first =
        changed.map_or_else(String::new, |(found, known)| format!("\n  {known}\n  {found}"));
    ensure!(
        found == known,
        "{SCORES} is not what was scored: `cargo xtask retargeting --accept` writes it anew. First line, and \
         what it would be:{first}"
    );
    Ok(())
}
