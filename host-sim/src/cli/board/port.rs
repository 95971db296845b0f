//! The option that names a controller's port.

use std::path::{Path, PathBuf};

use sinew_board_client::{Board, SerialBoard, port};
use sinew_host_util::command::note;

/// A controller at a serial port.
pub(in crate::cli) type PortBoard = Board<SerialBoard>;

/// Which controller.
#[derive(Debug, Clone, clap::Args)]
pub(in crate::cli) struct BoardPort {
    /// The controller's serial port, such as /dev/ttyACM0, or the link of `sinew board simulate`. Without it, or with
    /// `auto`: the one at a USB port that answers.
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = AUTO)]
    board: Option<PathBuf>,
}

/// In place of a port.
const AUTO: &str = "auto";

impl BoardPort {
    /// Opens it.
    pub(in crate::cli) fn open(&self) -> anyhow::Result<PortBoard> {
        open(self.board.as_deref())
    }
}

/// Opens a controller's port; none or `auto`: the one that answers.
pub(in crate::cli) fn open(path: Option<&Path>) -> anyhow::Result<PortBoard> {
    if let Some(path) = path.filter(|path| *path != Path::new(AUTO)) {
        Ok(port::open(path)?)
    } else {
        let (path, board) = port::find(None)?;
        note(format_args!("the controller at {}", path.display()));
        Ok(board)
    }
}
