//! `sinew board settings`: times, speeds and safety limits that a controller stores.

use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context as _, anyhow};
use clap::Subcommand;
use sinew_board_client::ClientError;
use sinew_firmware::node::SETTING_NAMES;
use sinew_host_util::command::{print, table};
use sinew_link::message::Refusal;

use super::{BoardPort, PortBoard};

/// Longest time until a restarted board answers.
const RESTART: Duration = Duration::from_secs(10);

/// Print or set a board's settings: times, speeds and safety limits.
///
/// Without a sub-command it prints all settings.
#[derive(Debug, clap::Args)]
pub(super) struct SettingsArgs {
    #[command(flatten)]
    board: BoardPort,

    #[command(subcommand)]
    what: Option<What>,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Print a setting.
    Get {
        /// Name of the setting, such as `stop_s`.
        key: String,
    },
    /// Set a setting. The board stores it and restarts; it refuses while the rig is armed.
    Set {
        /// Name of the setting, such as `stop_s`.
        key: String,
        /// Value, in the unit that the name ends with.
        #[arg(allow_negative_numbers = true)]
        value: f32,
    },
}

/// Prints or sets settings.
pub(super) fn run(args: &SettingsArgs) -> anyhow::Result<ExitCode> {
    let key = match &args.what {
        Some(What::Get { key } | What::Set { key, .. }) => Some(number(key)?),
        None => None,
    };
    let mut board = args.board.open()?;
    match (&args.what, key) {
        (Some(What::Get { .. }), Some(key)) => print(&format!("{}\n", board.setting(key)?))?,
        (Some(What::Set { key: name, value }), Some(key)) => {
            let before = board.setting(key)?;
            let now = board.set_setting(key, *value).map_err(in_words)?;
            board.reconnect(RESTART)?;
            print(&format!("{name} is {now} now, before {before}\n"))?;
        }
        _ => print(&all(&mut board)?)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn all(board: &mut PortBoard) -> anyhow::Result<String> {
    let mut table = table(["setting", "value"], [1]);
    for (key, name) in (1..).zip(SETTING_NAMES) {
        table.add_row([name.to_owned(), board.setting(key)?.to_string()]);
    }
    Ok(format!("{table}\n"))
}

/// Adds the setting's name to the text of a refusal. The board knows only the setting's number.
fn in_words(error: ClientError) -> anyhow::Error {
    let ClientError::Refused(Refusal::Setting { key, found, least, most }) = error else {
        return error.into();
    };
    let index = usize::from(key).checked_sub(1);
    let Some(name) = index.and_then(|index| SETTING_NAMES.get(index)) else {
        return error.into();
    };
    anyhow!("the controller refused: {name} is {found}; it must be a number from {least} to {most}")
}

/// Returns the key of the setting with this name.
fn number(name: &str) -> anyhow::Result<u16> {
    let known = (1..).zip(SETTING_NAMES).find(|(_, own)| *own == name).map(|(key, _)| key);
    known.with_context(|| format!("`{name}`: expected one of {}", SETTING_NAMES.join(", ")))
}
