//! Recordings: a recorded session on the console's page, and the recording of the present session.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context as _, bail};
use sinew_console::{RECORD_HZ, Replay, Scene, Source};
use sinew_performance::play::{Recorder, Recording, RigParts};
use sinew_performance::rig::LoadedRig;
use sinew_rig::toml_file;

use super::ConsoleArgs;
use crate::cli::report::rig_of;
use crate::cli::stop::Stop;

/// First bytes of a Parquet file.
const MAGIC: &[u8; 4] = b"PAR1";

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

    /// Creates the recording of the session, if `--record` is given.
    pub(super) fn recorder(
        &self,
        rig: &LoadedRig,
        parts: &RigParts,
    ) -> anyhow::Result<Option<Recorder>> {
        let begin = |path: &Path| {
            let rig = toml_file::write(&rig.description);
            let notes = [("show", "a session of the console")];
            Recorder::new(path, (parts, RECORD_HZ), &rig, &notes)
                .with_context(|| path.display().to_string())
        };
        self.record.as_deref().map(begin).transpose()
    }
}

fn is_recording(path: &Path) -> bool {
    let mut magic = [0; MAGIC.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    read.is_ok() && magic == *MAGIC || path.extension().is_some_and(|end| end == "parquet")
}
