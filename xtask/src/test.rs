//! Everything that must hold.

use anyhow::Result;

use crate::{audit, budget, docs, features, image, package, parity, setup, step};

pub(crate) fn run() -> Result<()> {
    setup::run()?;
    step::run("format", step::cargo().args(["fmt", "--all", "--check"]))?;
    let deny = ["--", "--deny", "warnings"];
    step::run(
        "clippy",
        step::cargo().args(["clippy", "--locked", "--workspace", "--all-targets"]).args(deny),
    )?;
    features::run()?;
    package::run()?;
    step::run(
        "documentation",
        step::cargo()
            // Examples let it share with clippy what is checked of the dependencies.
            .args(["doc", "--locked", "--no-deps", "--lib", "--bins", "--examples"])
            .args(["--workspace", "--exclude", "sinew-tests", "--exclude", "xtask"])
            .env("RUSTDOCFLAGS", "--deny warnings"),
    )?;
    docs::run()?;

    budget::run(false)?;
    image::lint()?;
    audit::self_test()?;
    audit::run()?;
    let machines = parity::build()?;
    let mut tests = step::cargo();
    tests
        .args(["test", "--locked", "--workspace"])
        .env("INSTA_UPDATE", "no")
        .envs(machines.iter().cloned());
    let browser = setup::chromium().unwrap_or_default();
    tests.env("SINEW_CHROMIUM", &browser);
    if std::env::var_os("SINEW_DATA").is_some() {
        tests.args(["--", "--include-ignored"]);
        step::run("tests, those on real mocap too", &mut tests)
    } else {
        eprintln!("\nSINEW_DATA is not set: tests on real mocap report as ignored.");
        step::run("tests", &mut tests)?;
        step::run("bit parity", parity::test().envs(machines))?;
        let mut report = step::cargo();
        report
            .args(["test", "--locked", "--workspace", "--test", "report_browser"])
            .args(["--", "--ignored"])
            .env("SINEW_CHROMIUM", browser);
        step::run("the report in a browser", &mut report)
    }
}
