//! What a study prints and writes: one home for `--format` and `--out`.

use std::path::{Path, PathBuf};
use std::{fs, io};

use anyhow::Context as _;
use clap::ValueEnum;
use serde_json::Value;

use sinew_sim::command::{note, print};
use sinew_sim::output::Folder;

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

/// Says where pictures are.
pub(super) fn tell_pictures(files: &[PathBuf]) {
    let is_picture =
        |file: &&PathBuf| file.extension().is_some_and(|of| of == "png" || of == "svg");
    for picture in files.iter().filter(is_picture) {
        note(format_args!("{}", picture.display()));
    }
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
            let folder = Folder::open(out, name, &[])?;
            let stage = folder.stage();
            let cannot = || format!("{}: cannot be written", out.display());
            pictures(&stage).with_context(cannot)?;
            for (extension, text) in [("txt", tables), ("json", &json)] {
                fs::write(stage.join(format!("{name}.{extension}")), text).with_context(cannot)?;
            }
            tell_pictures(&folder.finish()?);
        }
        print(match self.format {
            Format::Table => tables,
            Format::Json => &json,
        })?;
        Ok(())
    }
}
