//! The compiler for the boards: rustup's, or Debian's where rustup cannot bring the target.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::step;

pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";

/// The same processor without a floating-point unit.
pub(crate) const SOFT_FLOAT: &str = "thumbv7em-none-eabi";

/// Debian's packages that build for Arm: a compiler that needs no bootstrap, the library's source, a linker.
pub(crate) const DEBIAN_PACKAGES: [&str; 4] = ["rustc-web", "rust-web-src", "cargo-web", "lld"];

/// Who builds for the boards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Toolchain {
    /// The toolchain that runs this, with its target installed.
    Rustup,
    /// `/usr/bin/rustc`, which builds the library itself.
    Debian,
}

impl Toolchain {
    /// What is on this machine already that builds for a target.
    pub(crate) fn find(target: &str) -> Option<Self> {
        if has_target(target) {
            return Some(Self::Rustup);
        }
        let source = step::output(Command::new("/usr/bin/rustc").args(["--print", "sysroot"]))
            .map(|sysroot| Path::new(sysroot.trim()).join("lib/rustlib/src/rust/library"))?;
        let has_parts = source.is_dir()
            && step::output(Command::new("/usr/bin/cargo").arg("--version")).is_some()
            && step::output(Command::new("ld.lld").arg("--version")).is_some();
        has_parts.then_some(Self::Debian)
    }

    /// What to call it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Rustup => "rustup's target",
            Self::Debian => "Debian's rustc-web",
        }
    }

    /// A cargo command for an image or a check: `cargo VERB --target .. ARGUMENTS`.
    pub(crate) fn cargo(self, verb: &str) -> Command {
        self.cargo_for(TARGET, verb)
    }

    /// The same for another Arm target.
    pub(crate) fn cargo_for(self, target: &str, verb: &str) -> Command {
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

/// Whether the toolchain that runs this has the library for a target.
pub(crate) fn has_target(target: &str) -> bool {
    let installed = step::output(step::command("rustup").args(["target", "list", "--installed"]));
    installed.is_some_and(|list| list.lines().any(|line| line == target))
}

/// Apart from the host's, so that two compilers do not undo each other's work.
pub(crate) fn target_dir() -> PathBuf {
    step::root().join("target/arm")
}

/// Where an image comes to lie.
pub(crate) fn image(board: &str) -> PathBuf {
    image_for(TARGET, board)
}

/// The same of another Arm target.
pub(crate) fn image_for(target: &str, board: &str) -> PathBuf {
    target_dir().join(target).join("firmware").join(board)
}

/// The toolchain, or what to do.
pub(crate) fn toolchain() -> Result<Toolchain> {
    toolchain_for(TARGET)
}

/// The same for another Arm target.
pub(crate) fn toolchain_for(target: &str) -> Result<Toolchain> {
    Toolchain::find(target)
        .with_context(|| format!("there is no compiler for {target} yet: run `cargo xtask setup`"))
}
