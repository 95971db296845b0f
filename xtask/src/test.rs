//! Everything that must hold.

use anyhow::Result;

use crate::{audit, budget, features, firmware, setup, step};

pub(crate) fn run() -> Result<()> {
    setup::run()?;
    step::run("format", step::cargo().args(["fmt", "--all", "--check"]))?;
    let deny = ["--", "--deny", "warnings"];
    step::run(
        "clippy",
        step::cargo().args(["clippy", "--locked", "--workspace", "--all-targets"]).args(deny),
    )?;
    features::run()?;
    step::run(
        "documentation",
        step::cargo()
            // Examples, of which there are none, let it share with clippy what is checked of the dependencies.
            .args(["doc", "--locked", "--no-deps", "--lib", "--bins", "--examples"])
            .args(["--workspace", "--exclude", "sinew-tests", "--exclude", "xtask"])
            .env("RUSTDOCFLAGS", "--deny warnings"),
    )?;

    budget::run(false)?;
    firmware::lint()?;
    audit::lint()?;
    audit::self_test()?;
    audit::run()?;
    let (image, show) = firmware::qemu_image();
    let mut tests = step::cargo();
    tests
        .args(["test", "--locked", "--workspace"])
        .env("INSTA_UPDATE", "no")
        .env("SINEW_QEMU_IMAGE", image)
        .env("SINEW_QEMU_SHOW", show);
    let browser = setup::chromium().unwrap_or_default();
    tests.env("SINEW_CHROMIUM", &browser);
    if std::env::var_os("SINEW_DATA").is_some() {
        tests.args(["--", "--include-ignored"]);
        step::run("tests, those on real mocap too", &mut tests)
    } else {
        eprintln!("\nSINEW_DATA is not set: tests on real mocap report as ignored.");
        step::run("tests", &mut tests)?;
        let mut parity = step::cargo();
        let (image, show) = firmware::qemu_image();
        parity
            .args(["test", "--locked", "--workspace", "--test", "parity", "--", "--ignored"])
            .env("SINEW_QEMU_IMAGE", image)
            .env("SINEW_QEMU_SHOW", show);
        step::run("bit parity with QEMU", &mut parity)?;
        let mut report = step::cargo();
        report
            .args(["test", "--locked", "--workspace", "--test", "report_browser"])
            .args(["--", "--ignored"])
            .env("SINEW_CHROMIUM", browser);
        step::run("the report in a browser", &mut report)
    }
}
