//! The show to play: read from a file, or baked from a clip.

use std::path::Path;

use anyhow::{Context as _, bail};
use sinew_host_util::command::note;
use sinew_mocap::Kind;
use sinew_performance::play::{Options, RigParts};
use sinew_performance::rig::LoadedRig;
use sinew_performance::{Baked, RigPerformance, ShowChoices};
use sinew_rig::Mechanism;
use sinew_show::Show;
use sinew_show::sound::{Sound, split};

use super::Args;
use crate::cli::performance::{ON_STAND, PerformanceArgs};
use crate::cli::target::Target;
use crate::cli::unit_args::UnitArgs;

/// Content of a show file.
pub(in crate::cli) struct ShowFile {
    /// The show without the section for a sound, as boards store it.
    pub(in crate::cli) bytes: Vec<u8>,
    /// Sound that belongs to the show.
    pub(in crate::cli) sound: Option<Sound>,
}

/// Reads a show file. Returns `None` for a path that may be a clip: a file of another kind, or the name of a built-in
/// clip.
///
/// # Errors
/// A file whose name ends with `.show` cannot be read or is not a show, or a show is damaged.
pub(in crate::cli) fn read(path: &Path) -> anyhow::Result<Option<ShowFile>> {
    let is_named = path.extension().is_some_and(|extension| extension == "show");
    match sinew_mocap::read::bytes(path) {
        Err(error) if is_named => bail!("{}: {error}", path.display()),
        Ok(bytes) if Kind::of(path, &bytes) == Some(Kind::Show) => {
            let of_file = || path.display().to_string();
            let (show, sound) = split(&bytes).with_context(of_file)?;
            Show::open(show).with_context(of_file)?;
            Ok(Some(ShowFile { bytes: show.to_vec(), sound }))
        }
        Ok(bytes) if is_named => {
            let found = Kind::found(Kind::of(path, &bytes));
            bail!("{}: expected a show of `sinew bake --rig`, found {found}", path.display());
        }
        _ => Ok(None),
    }
}

/// Prints the changes that the fit of a clip made, and what would preserve more of the motion.
fn tell_fit(
    performance: &RigPerformance,
    baked: &Baked,
    mechanism: &Mechanism,
) -> anyhow::Result<()> {
    let likeness = performance.likeness(mechanism);
    let name = &performance.name;
    let headline = performance.headline(mechanism);
    let is_changed = headline.is_some();
    let told = headline.unwrap_or_else(|| "all of the way is left".to_owned());
    note(format_args!("{name}: {:.2} s, fitted to the rig. {told}", baked.duration_s));
    if let Some(summary) = performance.fit_summary(mechanism).filter(|_| is_changed) {
        for line in summary.lines() {
            note(format_args!("fit: {line}"));
        }
    }
    if let Some(line) = performance.following_line().filter(|_| is_changed) {
        note(format_args!("fit: {}", line.trim_end()));
    }
    if let Some(why) = likeness.strange() {
        note(format_args!("warning: the fitted motion is far from the clip: {why}"));
    }
    if is_changed {
        for line in performance.helps(mechanism)? {
            note(format_args!("would help: {line}"));
        }
    }
    Ok(())
}

/// Bakes a clip into a show of a rig, fitted to the rig.
pub(in crate::cli) fn bake(
    (rig, rig_crc): (&LoadedRig, u32),
    clip: &Path,
    on_rig: &PerformanceArgs,
    mapping: Option<&Path>,
    seconds: Option<f64>,
    units: UnitArgs,
) -> anyhow::Result<Vec<u8>> {
    let mut on_rig = on_rig.clone();
    on_rig.fit = true;
    let mut performance = on_rig.perform(rig, clip, mapping, seconds, (ON_STAND, units))?;
    let choices = ShowChoices { rig_crc, ..ShowChoices::default() };
    let (baked, _) = performance.bake(&rig.mechanism, &choices)?;
    tell_fit(&performance, &baked, &rig.mechanism)?;
    Ok(baked.written.bytes)
}

impl Args {
    /// Returns the options of the loop that plays: in this program, or on a board.
    pub(super) fn options(&self) -> Options {
        if self.target == Target::Sim { self.driven.here() } else { self.driven.on_board() }
    }

    /// Returns the show and its sound: reads a show, or bakes a clip. `bare`: the CRC of the rig without the servos of
    /// --servo.
    pub(super) fn read_or_bake(
        &self,
        rig: &LoadedRig,
        parts: &mut RigParts,
        bare: u32,
    ) -> anyhow::Result<ShowFile> {
        let path = Path::new(&self.show);
        let Some(file) = read(path)? else {
            let rig = (rig, parts.rig_crc());
            let mapping = self.mapping.as_deref();
            let mut on_rig = self.on_rig.clone();
            on_rig.driven = self.options();
            let bytes = bake(rig, path, &on_rig, mapping, self.seconds, self.units)?;
            return Ok(ShowFile { bytes, sound: None });
        };
        let clip_only = self.mapping.as_ref().map(|_| "--mapping");
        let clip_only = clip_only.or(self.seconds.map(|_| "--seconds"));
        let clip_only = clip_only.or(self.on_rig.of_clips()).or(self.on_rig.of_own());
        if let Some(option) = clip_only.or(self.units.given()) {
            bail!("{option}: is of clips, and {} is a show", path.display());
        }
        let show = Show::open(&file.bytes)?;
        if show.check_rig(parts.rig_crc()).is_err() && show.check_rig(bare).is_ok() {
            note(format_args!(
                "note: {} was baked before servos were put on the rig: it may ask for more than they can do",
                path.display()
            ));
            parts.take_shows_of(bare);
        }
        Ok(file)
    }
}
