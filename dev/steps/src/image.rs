//! Images: programs of the workspace that run without an operating system.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;
use sinew_image::{BOARDS, Board};

use crate::{arm, step};

/// A program of a package.
#[derive(Debug, Clone, Copy)]
pub struct Image {
    pub package: &'static str,
    /// Name of the program.
    pub name: &'static str,
    /// Feature of the package that the program needs; `None` if it needs none.
    pub feature: Option<&'static str>,
}

impl Image {
    /// Image of everything that a board may call, linked without a panic handler.
    pub const AUDIT: Self = Self { package: "sinew-audit", name: "audit", feature: None };

    /// Returns the image of a board.
    pub const fn of(board: Board) -> Self {
        Self { package: board.name, name: board.name, feature: None }
    }

    /// Returns a cargo command for it: `cargo VERB --bin NAME ..`.
    ///
    /// # Errors
    /// If there is no compiler for boards.
    pub fn cargo(self, verb: &str) -> Result<Command> {
        self.cargo_for(arm::TARGET, verb)
    }

    /// Returns a cargo command for it and another Arm target.
    ///
    /// # Errors
    /// If there is no compiler for it.
    pub fn cargo_for(self, target: &str, verb: &str) -> Result<Command> {
        let mut command = arm::toolchain_for(target)?.cargo_for(target, verb);
        command.args(["--package", self.package, "--bin", self.name]);
        command.args(["--profile", profile_of(self.name)]);
        if let Some(feature) = self.feature {
            command.args(["--features", feature]);
        }
        Ok(command)
    }

    /// Returns the path of the built image.
    pub fn path(self) -> PathBuf {
        self.path_for(arm::TARGET)
    }

    /// Returns the path of the built image for another Arm target.
    pub fn path_for(self, target: &str) -> PathBuf {
        path_of(target, self.name)
    }
}

/// Returns the files that are built into the image of an emulated board, with the environment variables that name
/// them: the human figure in a rig's compact form, and a show of it.
pub fn built_in() -> [(&'static str, PathBuf); 2] {
    let file = |extension| step::root().join("target/shows/figure").with_extension(extension);
    [("SINEW_RIG", file("snwr")), ("SINEW_SHOW", file("show"))]
}

/// Returns the path of the image with a name.
pub fn path_of(target: &str, name: &str) -> PathBuf {
    arm::target_dir().join(target).join(profile_of(name)).join(name)
}

/// Name of the profile of images.
const FIRMWARE: &str = "firmware";

/// Returns the profile of an image. Boards that run the node have a profile that is optimized for size.
fn profile_of(name: &str) -> &'static str {
    let is_node = |board: &Board| board.name == name && board.qemu_machine.is_none();
    if BOARDS.iter().any(is_node) { "node" } else { FIRMWARE }
}
