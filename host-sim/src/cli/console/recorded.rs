//! Recordings: a recorded session on the console's page, and the recording of the present session.

use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, bail};
use sinew_console::{NewRecord, RECORD_HZ, Records, Replay, Scene, Source};
use sinew_performance::play::{Recorder, Recording, RigParts};
use sinew_performance::rig::LoadedRig;
use sinew_rig::toml_file;

use super::ConsoleArgs;
use crate::cli::report::rig_of;
use crate::cli::stop::Stop;

/// First bytes of a Parquet file.
const MAGIC: &[u8; 4] = b"PAR1";
/// Maximum number of recordings that pages begin in a folder.
const SESSIONS: u32 = 9999;

impl ConsoleArgs {
    /// Returns the recording among the files of the command line, if there is one. It must be the only file.
    pub(super) fn recording(&self) -> anyhow::Result<Option<&Path>> {
        let recordings = || self.shows.iter().filter(|name| is_recording(Path::new(name)));
        let Some(name) = recordings().next() else { return Ok(None) };
        let given = [
            (self.shows.len() > 1, "another show"),
            (!self.servo.is_empty(), "--servo"),
            (self.target != crate::cli::target::Target::Sim, "--target"),
            (!self.fault.is_empty(), "--fault"),
            (self.unattended, "--unattended"),
            (self.allow_drive, "--allow-drive"),
            (self.record.is_some(), "--record"),
            (self.idle.is_some(), "--idle"),
        ];
        let given = given.into_iter().chain(self.driven.given());
        if let Some((_, option)) = given.into_iter().find(|(is_given, _)| *is_given) {
            bail!(
                "{name}: {option} has no effect on a recording, which is shown alone and moves no rig"
            );
        }
        Ok(Some(Path::new(name)))
    }

    /// Shows a recording until Ctrl-C.
    pub(super) fn replay(&self, path: &Path) -> anyhow::Result<ExitCode> {
        let named = || path.display().to_string();
        let recording = Recording::open(path).with_context(named)?;
        let (rig, mechanism) = rig_of(&recording, path, self.rig.as_deref())?;
        let parts = RigParts::new(&rig, &mechanism, self.driven.on_board()).with_context(named)?;
        let scene = Scene::new(&rig.name, &mechanism, &parts, Source::Recording);
        let replay = Replay::new(&recording, &scene, &parts).with_context(named)?;
        let stop = Stop::new()?;
        let console = self.open()?;
        let _redirect = self.tell(&console.addresses())?;
        let name = recording.note("show").map_or_else(named, ToOwned::to_owned);
        console.replay(&replay, (&scene, &name), &|| stop.times())?;
        Ok(ExitCode::SUCCESS)
    }

    /// Returns the recordings of the session: that of `--record`, and those that a page begins.
    pub(super) fn records<'a>(
        &self,
        rig: &LoadedRig,
        parts: &'a RigParts,
    ) -> anyhow::Result<Records<'a>> {
        let rig = toml_file::write(&rig.description);
        let new = move |path: &Path| {
            let notes = [("show", "a session of the console")];
            let recorder = Recorder::new(path, (parts, RECORD_HZ), &rig, &notes)
                .with_context(|| path.display().to_string())?;
            anyhow::Ok(NewRecord { recorder, file: path.display().to_string() })
        };
        let first = self.record.as_deref().map(&new).transpose()?;
        let begin = move || {
            let begun = new_file().and_then(|path| new(&path));
            begun.map_err(|error| format!("{error:#}"))
        };
        Ok(Records { first, begin: Some(Box::new(begin)) })
    }
}

/// Creates the first file session-1.parquet, session-2.parquet, .. of the working folder that does not exist, and
/// returns its path. The file keeps its name for this recording, also if another console records in this folder.
fn new_file() -> anyhow::Result<PathBuf> {
    let folder = std::env::current_dir().context("the working folder")?;
    for number in 1..=SESSIONS {
        let path = folder.join(format!("session-{number}.parquet"));
        match File::create_new(&path) {
            Ok(_) => return Ok(path),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error).with_context(|| path.display().to_string()),
        }
    }
    bail!("{}: it has session-1.parquet to session-{SESSIONS}.parquet already", folder.display())
}

fn is_recording(path: &Path) -> bool {
    let mut magic = [0; MAGIC.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    read.is_ok() && magic == *MAGIC || path.extension().is_some_and(|end| end == "parquet")
}
