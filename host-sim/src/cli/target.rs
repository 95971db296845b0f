//! The option `--target`: where a rig moves.

use std::convert::Infallible;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::bail;

/// The controller and servos that move the rig.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Target {
    /// Simulated servos, under the controller in this program.
    Sim,
    /// The image of the NUCLEO-F446RE on an emulated chip, with simulated servos.
    Nucleo,
    /// The controller at a serial port; for `auto`, the controller at a USB port that answers.
    Port(PathBuf),
}

impl FromStr for Target {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
            "sim" => Self::Sim,
            "nucleo" => Self::Nucleo,
            port => Self::Port(port.into()),
        })
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sim => f.write_str("sim"),
            Self::Nucleo => f.write_str("nucleo"),
            Self::Port(port) => port.display().fmt(f),
        }
    }
}

impl Target {
    /// Refuses the first given option that has no effect on this target. `of`: the targets for which it has an
    /// effect.
    pub(super) fn refuse(&self, given: &[(bool, &str)], of: &str) -> anyhow::Result<()> {
        if let Some((_, option)) = given.iter().find(|(is_given, _)| *is_given) {
            bail!("{option} has no effect with `--target {self}`; it is for {of}");
        }
        Ok(())
    }
}
