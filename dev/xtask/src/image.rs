//! Images: the workspace's programs that run without an operating system.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;
use sinew_image::{BOARDS, Board};

use crate::arm;

/// A program of a package.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Image {
    pub(crate) package: &'static str,
    pub(crate) name: &'static str,
    /// What it needs of the package's features.
    pub(crate) feature: Option<&'static str>,
}

impl Image {
    /// The image of a board.
    pub(crate) const fn of(board: Board) -> Self {
        Self { package: board.name, name: board.name, feature: None }
    }

    /// A cargo command for it: `cargo VERB --bin NAME ..`.
    pub(crate) fn cargo(self, verb: &str) -> Result<Command> {
        self.cargo_for(arm::TARGET, verb)
    }

    /// The same for another Arm target.
    pub(crate) fn cargo_for(self, target: &str, verb: &str) -> Result<Command> {
        let mut command = arm::toolchain_for(target)?.cargo_for(target, verb);
        command.args(["--package", self.package, "--bin", self.name]);
        // Clippy finds the same in any profile: in one, what images share is checked once.
        let profile = if verb == "clippy" { FIRMWARE } else { profile_of(self.name) };
        command.args(["--profile", profile]);
        if let Some(feature) = self.feature {
            command.args(["--features", feature]);
        }
        Ok(command)
    }

    /// Where it comes to lie.
    pub(crate) fn path(self) -> PathBuf {
        self.path_for(arm::TARGET)
    }

    /// The same of another Arm target.
    pub(crate) fn path_for(self, target: &str) -> PathBuf {
        path_of(target, self.name)
    }
}

/// Where the image of a name comes to lie.
pub(crate) fn path_of(target: &str, name: &str) -> PathBuf {
    arm::target_dir().join(target).join(profile_of(name)).join(name)
}

/// The profile of images.
const FIRMWARE: &str = "firmware";

/// Boards that run the node have a profile of their own: what is small.
fn profile_of(name: &str) -> &'static str {
    let is_node = |board: &Board| board.name == name && board.qemu_machine.is_none();
    if BOARDS.iter().any(is_node) { "node" } else { FIRMWARE }
}
