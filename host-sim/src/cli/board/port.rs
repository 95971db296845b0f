//! The option that names a controller's port.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use sinew_board_client::{Board, ClientError, SerialBoard, port};
use sinew_host_util::command::note;

/// A controller at a serial port.
pub(in crate::cli) type PortBoard = Board<SerialBoard>;

/// The option that names a controller.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct BoardPort {
    /// Serial port of the board, such as /dev/ttyACM0, or the link of `sinew board simulate`. Default, and `auto`: the
    /// USB port where a board answers.
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = AUTO)]
    port: Option<PathBuf>,
}

/// In place of a port.
const AUTO: &str = "auto";

impl BoardPort {
    /// Opens it.
    pub(super) fn open(&self) -> anyhow::Result<PortBoard> {
        open(self.port.as_deref(), "--port")
    }
}

/// Opens a controller's port; without one, or of `auto`, the one that answers. `option` is what names a port.
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
