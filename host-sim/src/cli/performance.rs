//! Options and steps that `bake`, `export` and `evaluate --rig --clips` have in common: a clip on a rig.

use std::path::Path;

use anyhow::{Context as _, ensure};
use clap::ValueEnum;
use sinew_host_util::command::note;
use sinew_mocap::files::ClipFile;
use sinew_mocap::{Kind, read as file};
use sinew_performance::rig::Loaded;
use sinew_performance::{ClipSettings, PreparedClip, TakenOver, fitted, take_over};
use sinew_retarget::exchange::{blender, servos, table};
use sinew_retarget::feasibility::{
    Fit, FitSettings, Limits, LoopError, Looped, RigMotion, fit, looped,
};
use sinew_retarget::mapping::Mapping;
use sinew_retarget::rig::RigMatch;
use sinew_retarget::{Landmark, Side};
use sinew_rig::Mechanism;
use sinew_rig::description::Base;
use sinew_rig::review::Servos;

use super::rig::read;
use super::told::ToldArgs;

/// How a rig's base is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum BaseArg {
    /// Bolted to a stand.
    Stand,
    /// The base travels with the performer.
    Driven,
}

/// Options of a clip on a rig.
#[derive(Debug, Clone, Default, clap::Args)]
pub(super) struct OnRig {
    /// Cutoff of the low-pass filter on clips, in Hz. 0: no filter. Default: 6; for `export` no filter.
    #[arg(long, value_name = "HZ", value_parser = cutoff, allow_negative_numbers = true, requires = "rig")]
    cutoff_hz: Option<f64>,

    /// How the rig's base is held. Default: as the rig's file says; for `export`, a rig with feet travels.
    #[arg(long, value_enum, requires = "rig")]
    base: Option<BaseArg>,

    /// Swap left and right.
    #[arg(long, requires = "rig")]
    mirror: bool,

    /// Fit the motion within all limits of the rig: smooth it, slow it down, or draw it towards the home pose where
    /// needed.
    #[arg(long, requires = "rig")]
    pub(super) fit: bool,

    /// How long before its end the motion is led to its beginning, s: it shall be a loop.
    #[arg(skip)]
    pub(super) blend_s: Option<f64>,
}

/// What a command does where its options say nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Defaults {
    /// Cutoff of the low-pass, Hz; 0: none.
    pub(super) cutoff_hz: f64,
    /// Whether a rig with feet travels, though its file holds it on a stand.
    pub(super) travels: bool,
}

/// Of a rig on its stand.
pub(super) const ON_STAND: Defaults = Defaults { cutoff_hz: 6.0, travels: false };

/// Of motions for other programs: as near to the clip as the rig can.
pub(super) const FOR_OTHERS: Defaults = Defaults { cutoff_hz: 0.0, travels: true };

/// Reads a motion that is the rig's own, and when it begins, s.
type Own = fn(&Loaded, &Path) -> anyhow::Result<(RigMotion, f64)>;

/// A clip on a rig.
pub(super) struct Performed {
    /// Name of the clip.
    pub(super) name: String,
    /// Time of its first frame in the clip's file, s.
    pub(super) start_s: f64,
    pub(super) taken: TakenOver,
    pub(super) limits: Limits,
    /// What was done for a loop; its motion is in `taken`.
    pub(super) looped: Option<Looped>,
    pub(super) fit: Option<Fit>,
}

impl Performed {
    /// Rows of cues that are told by times of the clip, in its motion or in that of a fit.
    pub(super) fn cues(
        &self,
        fit: Option<&Fit>,
        cues: &[(String, f64)],
    ) -> anyhow::Result<Vec<(u32, String)>> {
        let given_s = self.taken.motion.duration_s();
        let cue = |(name, time_s): &(String, f64)| {
            ensure!(
                *time_s <= given_s,
                "--cue {name}@{time_s}: expected a time within the clip, which lasts {given_s:.2} s"
            );
            Ok((u32::try_from(self.row_at(fit, *time_s))?, name.clone()))
        };
        cues.iter().map(cue).collect()
    }

    /// The row of its motion, or of a fit's, where a time of the clip comes.
    fn row_at(&self, fit: Option<&Fit>, given_s: f64) -> usize {
        let motion = &self.taken.motion;
        let (row, rows) = match fit {
            Some(fit) => (fit.given_s.partition_point(|given| *given < given_s), fit.given_s.len()),
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates"
            )]
            None => ((given_s / motion.dt_s).round().max(0.0) as usize, motion.rows.len()),
        };
        row.min(rows.saturating_sub(1))
    }

    /// What a fit has done.
    pub(super) fn done(&self) -> Option<String> {
        let given_s = self.taken.motion.duration_s();
        self.fit.as_ref().map(|fit| fitted(&self.limits, fit, given_s))
    }

    /// When a time of the clip comes in the motion that is used, s.
    pub(super) fn time_s(&self, given_s: f64) -> f64 {
        self.row_at(self.fit.as_ref(), given_s) as f64 * self.motion().dt_s
    }

    /// Angles between the limbs of the motion that is used and the performer's, deg: mean and largest; `None` if no
    /// limb is followed.
    pub(super) fn likeness(&self, mechanism: &Mechanism) -> Option<[f64; 2]> {
        let motion = self.motion();
        let (mut sum, mut most, mut count) = (0.0, 0.0, 0_u32);
        for (row, q) in motion.rows.iter().enumerate() {
            let time_s = row as f64 * motion.dt_s;
            let clip_s = self.fit.as_ref().map_or(time_s, |fit| fit.given_time_s(time_s));
            let poses = mechanism.poses(q);
            for error in self.taken.limb_errors_deg(clip_s, &poses) {
                sum += error;
                most = f64::max(most, error);
                count += 1;
            }
        }
        (count > 0).then(|| [sum / f64::from(count), most])
    }

    /// The motion that is used.
    pub(super) fn motion(&self) -> &RigMotion {
        self.fit.as_ref().map_or(&self.taken.motion, |fit| &fit.motion)
    }
}

impl OnRig {
    /// Options of a motion that is the rig's own: fitted, or as it is.
    pub(super) fn of_motion(fit: bool) -> Self {
        Self { fit, ..Self::default() }
    }

    /// An option that is given and says something of clips alone.
    pub(super) fn of_clips(&self) -> Option<&'static str> {
        [(self.cutoff_hz.is_some(), "--cutoff-hz"), (self.mirror, "--mirror")]
            .into_iter()
            .find_map(|(given, name)| given.then_some(name))
    }

    /// Reads a rig, and holds its base as asked for.
    pub(super) fn rig(&self, path: &Path, defaults: Defaults) -> anyhow::Result<Loaded> {
        let mut rig = read(path)?;
        let base = match self.base {
            None if defaults.travels && has_feet(&rig.mechanism) => Base::Driven,
            None => return Ok(rig),
            Some(BaseArg::Stand) => Base::Fixed,
            Some(BaseArg::Driven) => Base::Driven,
        };
        rig.description.mount.base = base;
        rig.mechanism = rig.description.mechanism()?;
        Ok(rig)
    }

    /// Puts a clip on a rig.
    pub(super) fn perform(
        &self,
        rig: &Loaded,
        clip: &Path,
        mapping: Option<&Path>,
        seconds: Option<f64>,
        (defaults, told): (Defaults, ToldArgs),
    ) -> anyhow::Result<Performed> {
        let own = match clip.extension().and_then(|extension| extension.to_str()) {
            Some("json") => Some(("positions of servos", of_servos as Own)),
            Some("csv") => Some(("joint coordinates", of_coordinates as Own)),
            _ => None,
        };
        if let Some((what, read)) = own {
            ensure!(
                mapping.is_none()
                    && seconds.is_none()
                    && self.of_clips().or(told.given()).is_none(),
                "{}: {what} are the rig's own: only --fit and --base have an effect on them",
                clip.display()
            );
            let (motion, start_s) = read(rig, clip).with_context(|| clip.display().to_string())?;
            return self.fitted(rig, &ClipFile::new(clip).name, start_s, TakenOver::own(motion));
        }
        let file = mapping;
        let mapping = mapping.map(read_mapping).transpose()?;
        let settings = ClipSettings {
            cutoff_hz: Some(self.cutoff_hz.unwrap_or(defaults.cutoff_hz)).filter(|hz| *hz > 0.0),
            told: told.told(),
        };
        let mut clip = PreparedClip::read(&ClipFile::new(clip), settings)?;
        if let Some(seconds) = seconds {
            clip.cut(seconds);
        }
        let name = &clip.clip.name;
        for line in &clip.notes {
            note(format_args!("note: {name}: {line}"));
        }
        let taken =
            take_over(&rig.mechanism, &clip, mapping.as_ref(), self.mirror).with_context(|| {
                match file {
                    Some(file) => {
                        format!("{name} on {} by {}", rig.description.name, file.display())
                    }
                    None => format!("{name} on {}", rig.description.name),
                }
            })?;
        tell(name, rig, &taken);
        let (name, start_s) = (name.clone(), clip.start_s);
        // A long clip is large, and of no more use.
        drop(clip);
        self.fitted(rig, &name, start_s, taken)
    }

    /// The motion as a loop if that is asked for, beside the rig's limits, and within them if that is.
    pub(super) fn fitted(
        &self,
        rig: &Loaded,
        name: &str,
        start_s: f64,
        mut taken: TakenOver,
    ) -> anyhow::Result<Performed> {
        let mechanism = &rig.mechanism;
        let limits = Limits::of(mechanism, &Servos::of(&rig.description, mechanism)?);
        let on_rig = || format!("{name} on {}", rig.description.name);
        let led = |blend_s| -> Result<Looped, LoopError> {
            let looped = looped(mechanism, &taken.motion, blend_s)?;
            // A fit brings all of it within the limits.
            if !self.fit {
                looped.check(mechanism, &limits, &taken.motion)?;
            }
            Ok(looped)
        };
        let looped = self.blend_s.map(led).transpose().with_context(on_rig)?;
        if let Some(looped) = &looped {
            taken.motion.clone_from(&looped.motion);
        }
        let fit = self
            .fit
            .then(|| fit(mechanism, &limits, &taken.motion, FitSettings::default()))
            .transpose()
            .with_context(on_rig)?;
        Ok(Performed { name: name.to_owned(), start_s, taken, limits, looped, fit })
    }
}

/// How near the rig comes to the performer.
fn tell(name: &str, rig: &Loaded, taken: &TakenOver) {
    let rig = &rig.description.name;
    if taken.limbs > 0 {
        note(format_args!(
            "{name} on {rig}: {} limbs followed, {:.1} deg off in the mean, {:.1} at most{}",
            taken.limbs,
            taken.limbs_mean_deg,
            taken.limbs_max_deg,
            if taken.at_range > 0.0 { "" } else { "; no joint is at an end of its range" }
        ));
    }
    if let Some((joint, share)) = &taken.most_held {
        note(format_args!(
            "a joint is at an end of its range in {:.0} % of the frames, most often {joint}: {:.0} %",
            100.0 * taken.at_range,
            100.0 * share
        ));
    }
    if taken.curves > 0 {
        note(format_args!("{name} on {rig}: {} joint(s) follow by curves", taken.curves));
    }
}

/// The motion of a rig whose servos do what the Blender servo animation add-on wrote.
fn of_servos(rig: &Loaded, path: &Path) -> anyhow::Result<(RigMotion, f64)> {
    let text = sinew_mocap::read::text(path)?;
    let (tracks, fps) = blender::read(&text, &rig.description)?;
    let motion = servos::motion(&rig.description, &rig.mechanism, &tracks, fps.recip())?;
    Ok((motion, 0.0))
}

/// The motion of a rig as `sinew record` and `sinew clip export` write it, and when it begins, s.
fn of_coordinates(rig: &Loaded, path: &Path) -> anyhow::Result<(RigMotion, f64)> {
    let text = sinew_mocap::read::text(path)?;
    Ok(table::read(&rig.mechanism, &text)?)
}

fn read_mapping(path: &Path) -> anyhow::Result<Mapping> {
    let expected = "a mapping on the rig, as `sinew clip map --rig` proposes it";
    let text = file::text_of(path, expected, &[Kind::RigMapping, Kind::Toml])
        .with_context(|| path.display().to_string())?;
    Mapping::read(&text).with_context(|| path.display().to_string())
}

fn has_feet(mechanism: &Mechanism) -> bool {
    let rig = RigMatch::of(mechanism);
    rig.is_ok_and(|rig| Side::ALL.iter().all(|side| !rig.joints(Landmark::Ankle(*side)).is_empty()))
}

fn cutoff(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(hz) if (0.0..=1000.0).contains(&hz) => Ok(hz),
        _ => Err("expected a number of Hz from 0 to 1000".into()),
    }
}
