//! Fuzz targets, which lie in workspaces of their own: they build, and take their corpus.

use anyhow::Result;

use crate::step;

const FOLDERS: [&str; 2] = ["bus/fuzz", "link/fuzz"];

pub(crate) fn run() -> Result<()> {
    // What both depend on is built once.
    let target = step::root().join("target/fuzz");
    for folder in FOLDERS {
        let mut tests = step::cargo();
        tests
            .args(["test", "--locked", "--manifest-path"])
            .arg(step::root().join(folder).join("Cargo.toml"))
            .arg("--target-dir")
            .arg(&target)
            // Bolero draws new cases in each run. Here what fails was changed here: one case, always the same.
            .env("BOLERO_RANDOM_ITERATIONS", "0")
            .env("BOLERO_RANDOM_SEED", "16");
        step::run(&format!("fuzz targets of {folder}"), &mut tests)?;
    }
    Ok(())
}
