//! What a study prints and writes: one home for `--format` and `--out`.

use std::path::{Path, PathBuf};
use std::{fs, io};

use anyhow::Context as _;
use clap::ValueEnum;
use serde_json::Value;

use sinew_sim::command::{note, print};

#[derive(Debug, Clone, clap::Args)]
pub(super) struct ResultArgs {
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,

    /// Folder for tables, JSON and pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Tables as text.
    Table,
    /// One JSON object with every figure.
    Json,
}

impl ResultArgs {
    /// Prints tables or JSON; writes both, and the pictures, into the folder.
    pub(super) fn write(
        &self,
        name: &str,
        tables: &str,
        json: &Value,
        pictures: impl FnOnce(&Path) -> io::Result<Vec<PathBuf>>,
    ) -> anyhow::Result<()> {
        let json = format!("{json:#}\n");
        if let Some(out) = &self.out {
            let pictures =
                pictures(out).with_context(|| format!("{}: cannot be written", out.display()))?;
            for (extension, text) in [("txt", tables), ("json", &json)] {
                let path = out.join(format!("{name}.{extension}"));
                fs::write(&path, text)
                    .with_context(|| format!("{}: cannot be written", path.display()))?;
            }
            for picture in pictures {
                note(format_args!("{}", picture.display()));
            }
        }
        print(match self.format {
            Format::Table => tables,
            Format::Json => &json,
        })?;
        Ok(())
    }
}
