//! `sinew board upload`: uploads a rig or a show to a controller.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, bail, ensure};
use clap::Subcommand;
use indicatif::{ProgressBar, ProgressStyle};
use sinew_board_client::{Board, ClientError, Line, item};
use sinew_firmware::node::{RIG_SCHEMA, SHOW_SCHEMA};
use sinew_host_util::command::{note, print};
use sinew_link::message::{Command, Item, Kind, Refusal};
use sinew_mocap::Kind as FileKind;
use sinew_performance::play::{RigParts, ServoChoice, put_servos};
use sinew_show::Show;
use sinew_show::sound::split;

use super::BoardPort;
use crate::cli::driven::DrivenArgs;
use crate::cli::rig::read;

/// Upload a rig or a show to a board.
///
/// An interrupted upload continues where it stopped. The board refuses uploads while the rig is armed.
#[derive(Debug, clap::Args)]
pub(super) struct UploadArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Upload a rig, and the list of servos on each bus line of the board. The board then restarts with this rig.
    Rig {
        /// A rig.toml, a URDF or an MJCF file.
        #[arg(value_name = "FILE")]
        file: PathBuf,

        /// Add a servo of this kind to each joint that has none, as `sinew play` does. May be repeated.
        #[arg(long, value_name = "[JOINT=]KIND")]
        servo: Vec<ServoChoice>,

        #[command(flatten)]
        driven: DrivenArgs,

        #[command(flatten)]
        common: Common,
    },
    /// Upload a show of `sinew bake` into a free slot.
    Show {
        /// The show file.
        #[arg(value_name = "FILE")]
        file: PathBuf,

        /// Slot whose show the board deletes before the upload.
        #[arg(long, value_name = "SLOT")]
        replace: Option<u8>,

        #[command(flatten)]
        common: Common,
    },
}

#[derive(Debug, clap::Args)]
struct Common {
    #[command(flatten)]
    board: BoardPort,

    /// Name of the person who approves this upload. Stored on the board.
    #[arg(long, value_name = "NAME", default_value = "sinew board upload")]
    approved_by: String,
}

/// Uploads the rig or the show.
pub(super) fn run(args: &UploadArgs) -> anyhow::Result<ExitCode> {
    match &args.what {
        What::Rig { file, servo, driven, common } => rig(file, servo, *driven, common),
        What::Show { file, replace, common } => show(file, *replace, common),
    }
}

fn rig(
    file: &Path,
    servo: &[ServoChoice],
    driven: DrivenArgs,
    common: &Common,
) -> anyhow::Result<ExitCode> {
    let of_file = || file.display().to_string();
    let mut rig = read(file)?;
    if put_servos(&mut rig.description, servo).with_context(of_file)? > 0 {
        rig.mechanism = rig.description.mechanism()?;
    }
    let parts = RigParts::new(&rig.description, &rig.mechanism, driven.on_board());
    let parts = parts.with_context(of_file)?;
    let bytes = parts.board_rig().map_err(anyhow::Error::msg);
    let bytes = bytes.with_context(of_file)?;
    for line in &parts.lines {
        note(format_args!(
            "bus {:?}: the board talks to its servos at {} bit/s, in {} ticks a second",
            line.name, line.baud, parts.rate_hz
        ));
    }
    let mut board = common.board.open()?;
    let item = item(Kind::Rig, RIG_SCHEMA, &bytes, 0, &common.approved_by)?;
    put(&mut board, &item, &bytes)?;
    let now = board.about().rig;
    print(&format!("the board has rig {now:08x} ({}), {} bytes\n", file.display(), bytes.len()))?;
    Ok(ExitCode::SUCCESS)
}

fn show(file: &Path, replace: Option<u8>, common: &Common) -> anyhow::Result<ExitCode> {
    let bytes = sinew_mocap::read::bytes(file).with_context(|| file.display().to_string())?;
    let found = FileKind::of(file, &bytes);
    ensure!(
        found == Some(FileKind::Show),
        "{}: expected a show of `sinew bake --rig`, found {}",
        file.display(),
        FileKind::found(found)
    );
    // The section for a sound is not uploaded.
    let (bytes, _) = split(&bytes).with_context(|| file.display().to_string())?;
    Show::open(bytes).with_context(|| file.display().to_string())?;
    let mut board = common.board.open()?;
    if let Some(slot) = replace {
        board.ask(Command::DeleteShow { slot })?;
    }
    let slot = put_show(&mut board, bytes, &common.approved_by)?;
    print(&format!("{} is in slot {slot}\n", file.display()))?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the slot of a show on a board. If no slot has the show, uploads it first.
pub(in crate::cli) fn put_show<L: Line>(
    board: &mut Board<L>,
    bytes: &[u8],
    by: &str,
) -> anyhow::Result<u8> {
    let item = item(Kind::Show, SHOW_SCHEMA, bytes, board.about().rig, by)?;
    if let Some(slot) = board.slot_of(&item)? {
        note(format_args!("the show is on the board already, in slot {slot}"));
        return Ok(slot);
    }
    match put(board, &item, bytes) {
        Err(ClientError::Refused(Refusal::NoFreeSlot)) => {
            let shows = board.shows()?;
            let count = shows.iter().flatten().count();
            bail!(
                "the board has room for {} shows of {} bytes, and holds {count}: `sinew board upload show FILE \
                 --replace SLOT` deletes one first",
                shows.len(),
                board.about().capacities.slot_bytes
            )
        }
        put => put?,
    }
    board.slot_of(&item)?.context("the board accepted the show, but does not have it")
}

/// Uploads an item, with a progress bar.
pub(in crate::cli) fn put<L: Line>(
    board: &mut Board<L>,
    item: &Item,
    bytes: &[u8],
) -> Result<(), ClientError> {
    let style = ProgressStyle::with_template("{bytes} of {total_bytes} {bar:40} {bytes_per_sec}");
    let bar = ProgressBar::new(item.length.into());
    let bar = style.map_or(bar.clone(), |style| bar.with_style(style));
    let uploaded = board.upload(item, bytes, &mut |next| bar.set_position(next.into()));
    bar.finish_and_clear();
    uploaded
}
