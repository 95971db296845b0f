//! Options that name a controller's port, and the time without messages after which a rig is no longer driven.

use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{anyhow, bail};
use sinew_board_client::{Board, ClientError, SILENCE, SerialBoard, port};
use sinew_console::local::{Request, ask, consoles, name_of_port};
use sinew_host_util::command::note;
use sinew_servo_tools::usb_ports;

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
    pub(super) fn path(&self) -> Option<&Path> {
        self.port.as_deref().filter(|path| *path != Path::new(AUTO))
    }

    /// Opens the port.
    pub(super) fn open(&self) -> anyhow::Result<PortBoard> {
        Ok(self.open_named()?.0)
    }

    /// Opens the port. Returns the board, and the name by which other commands reach it.
    pub(super) fn open_named(&self) -> anyhow::Result<(PortBoard, String)> {
        open(self.port.as_deref(), "--port")
    }
}

/// Longest wait until a watching command has closed the port that this command asked for.
const YIELDS: Duration = Duration::from_secs(3);
/// Longest wait for a port that is still open in a command that ends.
const CLOSES: Duration = Duration::from_millis(300);
/// Interval of attempts to open the port.
const AGAIN: Duration = Duration::from_millis(50);

/// Opens a controller's port; without a path, or with `auto`, the USB port where a board answers. `option`: name of the
/// option for the port, for messages. Returns the board, and the name by which other commands reach it.
pub(in crate::cli) fn open(
    path: Option<&Path>,
    option: &str,
) -> anyhow::Result<(PortBoard, String)> {
    let named = path.filter(|path| *path != Path::new(AUTO));
    let waited = if let Some(path) = named {
        ask_for(path)?
    } else {
        // Commands that only watch close their ports; a command that drives a rig keeps its port.
        usb_ports().iter().any(|path| ask_for(path).unwrap_or_default())
    };
    let end = Instant::now() + if waited { YIELDS } else { CLOSES };
    loop {
        let found = match named {
            Some(path) => port::open(path, &lowers).map(|board| (path.to_owned(), board)),
            None => port::find(None, &lowers),
        };
        match found {
            Err(ClientError::Port(_)) if Instant::now() < end => sleep(AGAIN),
            Err(ClientError::NoneFound(_)) if waited && Instant::now() < end => sleep(AGAIN),
            Err(error @ (ClientError::NoneFound(_) | ClientError::Several(_))) => {
                return Err(anyhow!("{error}: name its port, `{option} PORT`"));
            }
            found => {
                let (path, board) = found?;
                if named.is_none() {
                    note(format_args!("the controller at {}", path.display()));
                }
                return Ok((board, name_of_port(&path)));
            }
        }
    }
}

fn lowers() {
    note(format_args!(
        "the program that drove this rig has ended: this command waits until the board has lowered the rig"
    ));
}

/// Opens a port to stop a rig, whichever program drives it. Returns the board, and whether the board executes only a
/// stop and an e-stop because its rig still belongs to another program.
pub(in crate::cli) fn open_to_end(
    path: Option<&Path>,
    option: &str,
) -> anyhow::Result<(PortBoard, bool)> {
    match path.filter(|path| *path != Path::new(AUTO)) {
        Some(path) => Ok(port::open_any(path)?),
        None => Ok((open(path, option)?.0, false)),
    }
}

/// Asks the command of this user that uses a port to close it. Returns `false` if no command uses the port.
///
/// # Errors
/// The command drives the rig.
fn ask_for(path: &Path) -> anyhow::Result<bool> {
    let name = name_of_port(path);
    if !consoles().contains(&name) {
        return Ok(false);
    }
    match ask(&name, &Request::Yield) {
        Ok(reply) if !reply.ok => bail!("{}: {}", path.display(), reply.text),
        // A command that does not answer is about to end.
        _ => Ok(true),
    }
}
