//! Output of a study: shared code for `--format` and `--out`.

use std::path::{Path, PathBuf};
use std::{fs, io};

use anyhow::Context as _;
use clap::ValueEnum;
use serde_json::Value;
use sinew_host_util::command::{note, print};
use sinew_host_util::output::Folder;

#[derive(Debug, Clone, clap::Args)]
pub(super) struct ResultArgs {
    /// Format of the output.
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
    /// One JSON object with all numbers.
    Json,
}

/// Prints the paths of the pictures.
pub(super) fn tell_pictures(files: &[PathBuf]) {
    let is_picture =
        |file: &&PathBuf| file.extension().is_some_and(|of| of == "png" || of == "svg");
    for picture in files.iter().filter(is_picture) {
        note(format_args!("{}", picture.display()));
    }
}

/// Destination of a study's results. Its folder is locked before the work: a folder that is in use is reported at
/// once, not after hours.
pub(super) struct Results<'a> {
    args: &'a ResultArgs,
    name: &'static str,
    folder: Option<Folder>,
}

impl ResultArgs {
    /// Opens the folder of a study's results, if the option is given.
    pub(super) fn open(&self, name: &'static str) -> anyhow::Result<Results<'_>> {
        let folder = self.out.as_ref().map(|out| Folder::open(out, name, &[])).transpose()?;
        Ok(Results { args: self, name, folder })
    }
}

impl Results<'_> {
    /// Prints tables or JSON; writes both, and the pictures, into the folder.
    pub(super) fn write(
        self,
        tables: &str,
        json: &Value,
        pictures: impl FnOnce(&Path) -> io::Result<Vec<PathBuf>>,
    ) -> anyhow::Result<()> {
        let Self { args, name, folder } = self;
        let json = format!("{json:#}\n");
        if let Some(folder) = folder {
            let stage = folder.stage();
            let cannot = || format!("{}: cannot be written", stage.display());
            pictures(&stage).with_context(cannot)?;
            for (extension, text) in [("txt", tables), ("json", &json)] {
                fs::write(stage.join(format!("{name}.{extension}")), text).with_context(cannot)?;
            }
            tell_pictures(&folder.finish()?);
        }
        print(match args.format {
            Format::Table => tables,
            Format::Json => &json,
        })?;
        Ok(())
    }
}
