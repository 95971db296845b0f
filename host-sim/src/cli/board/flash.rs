//! `sinew board flash`: writes firmware into a board with probe-rs.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context as _, bail};
use sinew_board_client::ClientError;
use sinew_host_util::command::{note, print};
use sinew_link::message::{Misfit, State, Version};

use super::BoardPort;

/// Name of each board's chip in `probe-rs`.
const CHIPS: [(&str, &str); 1] = [("nucleo_f446re", "STM32F446RETx")];
/// Folder in which `cargo xtask firmware` stores images.
const IMAGES: &str = "target/arm/thumbv7em-none-eabihf/firmware";

/// Write firmware into a board, through its debugger and `probe-rs`.
///
/// Fails while the rig is armed, and for an image that is not Sinew's firmware, or whose host link has another major
/// version than this program.
#[derive(Debug, clap::Args)]
pub(super) struct FlashArgs {
    /// Image to flash: the name of a board, such as `nucleo_f446re`, or an ELF file. `cargo xtask firmware` builds the
    /// images of boards.
    #[arg(value_name = "BOARD|ELF")]
    image: PathBuf,

    /// Name of the chip in `probe-rs chip list`. Default: the board's chip.
    #[arg(long, value_name = "CHIP")]
    chip: Option<String>,

    #[command(flatten)]
    board: BoardPort,
}

/// Writes the image, and checks which firmware answers.
pub(super) fn run(args: &FlashArgs) -> anyhow::Result<ExitCode> {
    let name = args.image.file_stem().map(|name| name.to_string_lossy().into_owned());
    let known = CHIPS.iter().find(|(board, _)| Some(*board) == name.as_deref());
    let image = match known {
        Some((board, _)) if !args.image.exists() => Path::new(IMAGES).join(board),
        _ => args.image.clone(),
    };
    let chip = args.chip.as_deref().or(known.map(|(_, chip)| *chip)).with_context(|| {
        let boards: Vec<_> = CHIPS.iter().map(|(board, _)| *board).collect();
        format!("which chip? `--chip` names it; known boards: {}", boards.join(", "))
    })?;
    let bytes = std::fs::read(&image).with_context(|| {
        format!("{}: `cargo xtask firmware` builds the images of all boards", image.display())
    })?;
    check(&image, &bytes)?;
    is_limp(&args.board)?;
    let mut command = Command::new("probe-rs");
    command.args(["download", "--chip", chip, "--verify"]).arg(&image);
    let status = match command.status() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => bail!(
            "`probe-rs` is not installed, and nothing was written. `cargo install probe-rs-tools --locked` installs \
             it; its page (https://probe.rs) has programs for all systems. On Linux it needs udev rules, too"
        ),
        status => status.context("probe-rs")?,
    };
    if !status.success() {
        bail!(
            "`probe-rs` failed ({status}): is the board's debugger plugged in, and no other program using it?"
        );
    }
    // Without a reset the board waits for its debugger.
    let _ = Command::new("probe-rs").args(["reset", "--chip", chip]).status();
    match args.board.open() {
        Ok(board) => print(&format!("firmware {} answers\n", board.about().firmware))?,
        Err(error) => note(format_args!("written; but {error:#}")),
    }
    Ok(ExitCode::SUCCESS)
}

/// Checks that a file is an image with this program's version of the host link.
fn check(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let shown = path.display();
    if !bytes.starts_with(b"\x7fELF") {
        bail!("{shown}: is not an ELF file; expected a board's name or its image");
    }
    let speaks = sinew_firmware::node::link_version(bytes);
    let own = Version::CURRENT;
    match speaks {
        Some(version) if version.major == own.major => Ok(()),
        Some(version) => bail!(
            "{shown}: this firmware has version {version} of the host link, this program {own}: nothing was written. \
             Use firmware and program of one release"
        ),
        None => {
            bail!(
                "{shown}: is not firmware of Sinew with a host link, or is older than version 1.1"
            )
        }
    }
}

/// Checks that torque is off. A board that does not answer has no firmware that could hold a rig; a board with another
/// version of the host link cannot be asked.
fn is_limp(port: &BoardPort) -> anyhow::Result<()> {
    let mut board = match port.open() {
        Ok(board) => board,
        Err(error) => match error.downcast_ref::<ClientError>() {
            Some(ClientError::Misfit(Misfit::Busy)) => {
                bail!(
                    "the rig is armed: nothing was written. End the program that drives it, or disarm it"
                )
            }
            Some(
                ClientError::NoController
                | ClientError::NoneFound(_)
                | ClientError::Misfit(Misfit::Version { .. }),
            ) => {
                note(format_args!("no firmware of this version answers yet"));
                return Ok(());
            }
            _ => return Err(error),
        },
    };
    board.telemetry(10.0, sinew_link::message::TelemetryParts::SUMMARY).or_else(
        |error| match error {
            // A board without a rig cannot be armed.
            ClientError::Refused(_) => Ok(sinew_link::message::TelemetrySetting {
                rate_hz: 0.0,
                parts: sinew_link::message::TelemetryParts(0),
            }),
            error => Err(error),
        },
    )?;
    let state = board.fresh_state(std::time::Duration::from_secs(1));
    match state {
        Ok(State::Off | State::Limp | State::Faulted) | Err(ClientError::Impatient(_)) => Ok(()),
        Ok(state) => bail!("the rig is {state}: nothing was written. Disarm it first"),
        Err(error) => Err(error.into()),
    }
}
