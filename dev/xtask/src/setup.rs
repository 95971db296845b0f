//! Installs missing tools for developers.

use std::process::Command;

use anyhow::{Result, bail};

use crate::targets::X86_32;
use sinew_steps::arm::{self, DEBIAN_PACKAGES, SOFT_FLOAT, TARGET, Toolchain, has_target};
use sinew_steps::step;

pub(crate) fn run() -> Result<()> {
    eprintln!("== set-up");
    // An invalid choice of compilers fails here, before anything is installed.
    Toolchain::allowed()?;
    for (component, tool) in [("rustfmt", "fmt"), ("clippy", "clippy")] {
        let found = || step::output(step::cargo().args([tool, "--version"])).is_some();
        need(component, found, || {
            succeeds(step::command("rustup").args(["component", "add", component]))
        })?;
    }
    for target in [TARGET, SOFT_FLOAT] {
        let arm = || arm::toolchain_for(target).is_ok();
        // If rustup cannot reach its server, Debian's compiler is used.
        need(target, arm, || (add_target(target) && arm()) || apt_install(&DEBIAN_PACKAGES))?;
    }
    eprintln!("   boards are built with {}", arm::toolchain()?.name());
    if let Some(target) = X86_32
        && !(has_target(target) || add_target(target))
    {
        eprintln!("   {target}: cannot be had; bit parity leaves it out");
    }
    let qemu = || step::output(Command::new("qemu-system-arm").arg("--version")).is_some();
    need("QEMU for Arm", qemu, || apt_install(&["qemu-system-arm"]))?;
    need("Chromium", || chromium().is_some(), || apt_install(&["chromium"]))?;
    python()
}

/// Installs Python with virtual environments, for foreign programs.
pub(crate) fn python() -> Result<()> {
    let found =
        || step::output(Command::new("python3").args(["-c", "import ensurepip, venv"])).is_some();
    need("Python with venv", found, || apt_install(&["python3-venv"]))
}

/// Installs another version of Rust, beside the one that runs this program. Returns whether it is available.
pub(crate) fn rust(version: &str) -> bool {
    let rustup = |arguments: &[&str]| {
        let mut command = step::command("rustup");
        command.args(arguments);
        command
    };
    let found = || step::output(&mut rustup(&["run", version, "cargo", "--version"])).is_some();
    let install = ["toolchain", "install", "--profile", "minimal", "--no-self-update", version];
    found() || (succeeds(&mut rustup(&install)) && found())
}

/// Returns the browser that reads the report in tests: `SINEW_CHROMIUM`, otherwise an installed Chromium or Chrome.
/// `None` if none runs.
pub(crate) fn chromium() -> Option<String> {
    let chosen = std::env::var("SINEW_CHROMIUM").ok();
    let known = ["chromium", "chromium-browser", "google-chrome"].map(str::to_owned);
    let found = |name: &String| step::output(Command::new(name).arg("--version")).is_some();
    chosen.into_iter().chain(known).find(found)
}

/// Installs a tool if it is missing, and prints its state.
fn need(what: &str, found: impl Fn() -> bool, install: impl FnOnce() -> bool) -> Result<()> {
    if found() {
        eprintln!("   {what}: found");
        return Ok(());
    }
    eprintln!("   {what}: missing, installing");
    if install() && found() {
        eprintln!("   {what}: installed");
        return Ok(());
    }
    bail!(
        "{what} could not be installed (see the lines above). By hand: `rustup target add {TARGET} {SOFT_FLOAT}` or, on \
         Debian, `apt-get install {} qemu-system-arm chromium python3-venv`",
        DEBIAN_PACKAGES.join(" ")
    )
}

fn add_target(target: &str) -> bool {
    succeeds(step::command("rustup").args(["target", "add", target]))
}

fn apt_install(packages: &[&str]) -> bool {
    let apt = |arguments: &[&str]| {
        let is_root = step::output(Command::new("id").arg("-u")).is_some_and(|id| id.trim() == "0");
        let mut command = if is_root {
            Command::new("apt-get")
        } else {
            let mut command = Command::new("sudo");
            command.arg("apt-get");
            command
        };
        // Standard output must contain only the command's own output, not the tools' progress.
        succeeds(command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive"))
    };
    let install = [&["install", "-y", "-qq", "--no-install-recommends"], packages].concat();
    apt(&["update", "-qq"]) && apt(&install)
}

fn succeeds(command: &mut Command) -> bool {
    command.stdout(std::io::stderr()).status().is_ok_and(|status| status.success())
}
