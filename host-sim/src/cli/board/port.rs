//! Options that name a controller's port, and the time without messages after which a rig is no longer driven.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::anyhow;
use sinew_board_client::{Board, ClientError, SILENCE, SerialBoard, port};
use sinew_host_util::command::note;

/// A controller at a serial port.
pub(in crate::cli) type PortBoard = Board<SerialBoard>;

/// The option that names a controller.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct BoardPort {
    /// Serial port of the board, such as /dev/ttyACM0, or the link of `sinew board simulate`. Default, and `auto`:
    /// the USB port where a board answers.
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = AUTO)]
    port: Option<PathBuf>,
}

/// The option of commands that drive a rig on a board.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(in crate::cli) struct SilenceArg {
    /// End after S seconds without a valid message from the board, from 0.2 to 60. The command asks the board to stop
    /// and then sends nothing more, so that the board lowers the rig. Default: 1.
    #[arg(long, value_name = "S", value_parser = silence, allow_negative_numbers = true)]
    silence_s: Option<f64>,
}

impl SilenceArg {
    /// Returns whether the option is given.
    pub(in crate::cli) fn is_given(self) -> bool {
        self.silence_s.is_some()
    }

    /// Returns the time without messages after which the command ends.
    pub(in crate::cli) fn time(self) -> Duration {
        self.silence_s.map_or(SILENCE, Duration::from_secs_f64)
    }
}

fn silence(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(seconds) if (0.2..=60.0).contains(&seconds) => Ok(seconds),
        _ => Err("expected a number of seconds from 0.2 to 60".into()),
    }
}

/// Value of the option that lets this program find the port.
const AUTO: &str = "auto";

impl BoardPort {
    /// Returns the port that is given; `None` if the program must find it.
    #[cfg(unix)]
    pub(super) fn path(&self) -> Option<&Path> {
        self.port.as_deref().filter(|path| *path != Path::new(AUTO))
    }

    /// Opens the port.
    pub(super) fn open(&self) -> anyhow::Result<PortBoard> {
        open(self.port.as_deref(), "--port")
    }
}

/// Opens a controller's port; without a path, or with `auto`, the USB port where a board answers. `option`: name of
/// the option for the port, for messages.
pub(in crate::cli) fn open(path: Option<&Path>, option: &str) -> anyhow::Result<PortBoard> {
    if let Some(path) = path.filter(|path| *path != Path::new(AUTO)) {
        Ok(port::open(path)?)
    } else {
        let found = port::find(None).map_err(|error| match error {
            ClientError::NoneFound(_) | ClientError::Several(_) => {
                anyhow!("{error}: name its port, `{option} PORT`")
            }
            error => error.into(),
        });
        let (path, board) = found?;
        note(format_args!("the controller at {}", path.display()));
        Ok(board)
    }
}
