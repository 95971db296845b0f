//! The show to play: read from a file, or baked from a clip.

use std::path::Path;

use anyhow::{Context as _, bail};
use sinew_host_util::command::note;
use sinew_mocap::Kind;
use sinew_performance::ShowChoices;
use sinew_performance::play::RigParts;
use sinew_performance::rig::LoadedRig;
use sinew_show::Show;

use super::Args;
use crate::cli::performance::ON_STAND;

impl Args {
    /// Returns the bytes of the show: read, or baked from a clip. `bare`: the CRC of the rig without the servos of
    /// --servo.
    pub(super) fn read_or_bake(
        &self,
        rig: &LoadedRig,
        parts: &mut RigParts,
        bare: u32,
    ) -> anyhow::Result<Vec<u8>> {
        let path = Path::new(&self.show);
        let read = sinew_mocap::read::bytes(path);
        if let Err(error) = &read
            && path.extension().is_some_and(|extension| extension == "show")
        {
            bail!("{}: {error}", path.display());
        }
        let bytes = match read {
            Ok(bytes) if Kind::of(path, &bytes) == Some(Kind::Show) => {
                Show::open(&bytes).with_context(|| path.display().to_string())?;
                Some(bytes)
            }
            Ok(bytes) if path.extension().is_some_and(|extension| extension == "show") => {
                let found = Kind::found(Kind::of(path, &bytes));
                bail!("{}: expected a show of `sinew bake --rig`, found {found}", path.display());
            }
            _ => None,
        };
        let Some(bytes) = bytes else {
            return self.bake(rig, parts.rig_crc());
        };
        let clip_only = self.mapping.as_ref().map(|_| "--mapping");
        let clip_only = clip_only.or(self.seconds.map(|_| "--seconds"));
        let clip_only = clip_only.or(self.on_rig.of_clips()).or(self.on_rig.of_own());
        if let Some(option) = clip_only.or(self.units.given()) {
            bail!("{option}: is of clips, and {} is a show", path.display());
        }
        let show = Show::open(&bytes)?;
        if show.check_rig(parts.rig_crc()).is_err() && show.check_rig(bare).is_ok() {
            note(format_args!(
                "note: {} was baked before servos were put on the rig: it may ask for more than they can do",
                path.display()
            ));
            parts.take_shows_of(bare);
        }
        Ok(bytes)
    }

    fn bake(&self, rig: &LoadedRig, rig_crc: u32) -> anyhow::Result<Vec<u8>> {
        let mut on_rig = self.on_rig.clone();
        on_rig.fit = true;
        let (clip, mapping) = (Path::new(&self.show), self.mapping.as_deref());
        let mut performance =
            on_rig.perform(rig, clip, mapping, self.seconds, (ON_STAND, self.units))?;
        let choices = ShowChoices { rig_crc, ..ShowChoices::default() };
        let (baked, _) = performance.bake(&rig.mechanism, &choices)?;
        note(format_args!("{}: {:.2} s, fitted to the rig", performance.name, baked.duration_s));
        Ok(baked.written.bytes)
    }
}
