//! Chooses the compiler for the boards: rustup's, or Debian's if rustup cannot install the target.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::step;

pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Target for the same processor without a floating-point unit.
pub const SOFT_FLOAT: &str = "thumbv7em-none-eabi";

/// Debian's packages for building for Arm: a compiler that needs no bootstrap, the library's source, a linker.
pub const DEBIAN_PACKAGES: [&str; 4] = ["rustc-web", "rust-web-src", "cargo-web", "lld"];

/// The environment variable that selects the compiler for the boards: `rustup` or `debian`.
pub const CHOICE: &str = "SINEW_ARM";

/// The compiler for the boards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Toolchain {
    /// The toolchain that runs this program, with the target installed.
    Rustup,
    /// `/usr/bin/rustc`, which builds the standard library itself.
    Debian,
}

impl Toolchain {
    /// Returns the allowed toolchains: both, rustup's first, or the one in [`CHOICE`].
    ///
    /// # Errors
    /// If the variable has another value.
    pub fn allowed() -> Result<&'static [Self]> {
        match env::var(CHOICE).as_deref() {
            Err(_) => Ok(&[Self::Rustup, Self::Debian]),
            Ok("rustup") => Ok(&[Self::Rustup]),
            Ok("debian") => Ok(&[Self::Debian]),
            Ok(other) => bail!("{CHOICE}={other}: it must be `rustup` or `debian`"),
        }
    }

    /// Returns whether the toolchain is on this machine and builds for a target.
    fn builds_for(self, target: &str) -> bool {
        match self {
            Self::Rustup => has_target(target),
            Self::Debian => {
                let sysroot =
                    step::output(Command::new("/usr/bin/rustc").args(["--print", "sysroot"]));
                let has = |program| step::output(Command::new(program).arg("--version")).is_some();
                sysroot.is_some_and(|sysroot| {
                    Path::new(sysroot.trim()).join("lib/rustlib/src/rust/library").is_dir()
                }) && has("/usr/bin/cargo")
                    && has("ld.lld")
            }
        }
    }

    /// Returns the name of the toolchain.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rustup => "rustup's target",
            Self::Debian => "Debian's rustc-web",
        }
    }

    /// Returns a cargo command for an Arm target: `cargo VERB --target ..`.
    pub fn cargo_for(self, target: &str, verb: &str) -> Command {
        let mut command = match self {
            Self::Rustup => {
                let mut command = step::cargo();
                command.arg(verb);
                command
            }
            Self::Debian => {
                let mut command = step::command("/usr/bin/cargo");
                command
                    .env("RUSTC", "/usr/bin/rustc")
                    .env("RUSTC_BOOTSTRAP", "1")
                    .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "ld.lld")
                    .env("CARGO_TARGET_THUMBV7EM_NONE_EABI_LINKER", "ld.lld")
                    .env_remove("RUSTUP_TOOLCHAIN")
                    .env_remove("RUSTC_WRAPPER")
                    .env_remove("RUSTFLAGS")
                    .args([verb, "-Zbuild-std=core"]);
                command
            }
        };
        command.args(["--locked", "--target", target, "--target-dir"]).arg(target_dir());
        command
    }
}

/// Returns whether the toolchain that runs this program has the standard library for a target.
pub fn has_target(target: &str) -> bool {
    let installed = step::output(step::command("rustup").args(["target", "list", "--installed"]));
    installed.is_some_and(|list| list.lines().any(|line| line == target))
}

/// Returns the target folder for boards. It is separate from the host's, so that two compilers do not invalidate each
/// other's files.
pub fn target_dir() -> PathBuf {
    step::root().join("target/arm")
}

/// Returns the toolchain for boards.
///
/// # Errors
/// If there is no compiler for them. The error says what to run.
pub fn toolchain() -> Result<Toolchain> {
    toolchain_for(TARGET)
}

/// Returns the toolchain for an Arm target.
///
/// # Errors
/// If there is no compiler for it.
pub fn toolchain_for(target: &str) -> Result<Toolchain> {
    let found = Toolchain::allowed()?.iter().find(|toolchain| toolchain.builds_for(target));
    found
        .copied()
        .with_context(|| format!("there is no compiler for {target} yet: run `cargo xtask setup`"))
}
