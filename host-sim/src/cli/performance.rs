//! Options and steps of commands that make a motion of a rig from a clip or from a file of the rig's own motion, such
//! as `bake` and `export`.

use std::path::Path;

use anyhow::{Context as _, bail, ensure};
use clap::ValueEnum;
use sinew_host_util::command::note;
use sinew_mocap::files::ClipFile;
use sinew_performance::play::Options;
use sinew_performance::rig::{LoadedRig, has_feet};
use sinew_performance::text;
use sinew_performance::{
    ClipSettings, LayerChoice, LayeredMotion, MotionChoices, OwnMotion, PreparedClip,
    RetargetedClip, RigPerformance, read_mapping, retarget_clip,
};
use sinew_retarget::exchange::HeaderUnits;
use sinew_retarget::feasibility::RigMotion;
use sinew_rig::description::Base;
use sinew_rig::mechanism::JointModel;

use super::rig::read;
use super::unit_args::UnitArgs;

/// How a rig's base is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum BaseArg {
    /// The base is bolted to a stand.
    Stand,
    /// The base travels with the performer.
    Driven,
}

/// Unit of the columns of a CSV whose header has none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum UnitArg {
    /// Degrees; slides in mm.
    Deg,
    /// Radians; slides in m.
    Rad,
}

/// Options for a clip on a rig.
#[derive(Debug, Clone, Default, clap::Args)]
pub(super) struct PerformanceArgs {
    /// Cutoff of the low-pass filter on clips, in Hz. 0: no filter. Default: 6; for `export` no filter.
    #[arg(long, value_name = "HZ", value_parser = cutoff, allow_negative_numbers = true, requires = "rig")]
    cutoff_hz: Option<f64>,

    /// How the rig's base is held. Default: as in the rig's file; for `export`, `driven` if the rig has feet.
    #[arg(long, value_enum, requires = "rig")]
    base: Option<BaseArg>,

    /// Swap left and right.
    #[arg(long, requires = "rig")]
    mirror: bool,

    /// Fit the motion within all limits of the rig: smooth it, slow it down, or draw it towards the home pose where
    /// needed.
    #[arg(long, requires = "rig")]
    pub(super) fit: bool,

    /// Fit the motion without slowing it down: where it exceeds a limit, it becomes smaller or smoother. Default: true
    /// for `bake` with --time-code or --sound, otherwise false. `--keep-time=false` then lets `--fit` slow the motion
    /// down.
    #[arg(
        long,
        value_name = "BOOL",
        requires = "rig",
        num_args = 0..=1,
        default_missing_value = "true",
        require_equals = true
    )]
    keep_time: Option<bool>,

    /// Whether the show runs beside a clock or a sound. A fit then keeps the time by default.
    #[arg(skip)]
    pub(super) has_clock: bool,

    /// Unit of the columns of a CSV of joint coordinates whose header has none. Default: a header without units is
    /// refused.
    #[arg(long, value_enum, requires = "rig")]
    unit: Option<UnitArg>,

    /// Motions of the rig that change the motion, in their order.
    #[arg(skip)]
    pub(super) layers: Vec<LayerChoice>,

    /// Length of the blend of the motion's end into its start, s. Set if the motion becomes a loop.
    #[arg(skip)]
    pub(super) blend_s: Option<f64>,

    /// Drive of the servos.
    #[arg(skip)]
    pub(super) driven: Options,
}

/// Values of a command for options that are not given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Defaults {
    /// Cutoff of the low-pass, Hz; 0: none.
    pub(super) cutoff_hz: f64,
    /// Whether a rig with feet travels, even if its file holds it on a stand.
    pub(super) travels: bool,
}

/// Defaults for a rig on its stand.
pub(super) const ON_STAND: Defaults = Defaults { cutoff_hz: 6.0, travels: false };

/// Defaults for motions that other programs use: as near to the clip as the rig can follow.
pub(super) const FOR_OTHERS: Defaults = Defaults { cutoff_hz: 0.0, travels: true };

impl PerformanceArgs {
    /// Returns the name of the first given option that applies to clips only, or `None`.
    pub(super) fn of_clips(&self) -> Option<&'static str> {
        [(self.cutoff_hz.is_some(), "--cutoff-hz"), (self.mirror, "--mirror")]
            .into_iter()
            .find_map(|(given, name)| given.then_some(name))
    }

    /// Returns the name of a given option that applies only to a rig's own motions, or `None`.
    pub(super) fn of_own(&self) -> Option<&'static str> {
        self.unit.map(|_| "--unit")
    }

    /// Returns whether the motion is fitted.
    pub(super) fn fits(&self) -> bool {
        self.fit || self.keep_time == Some(true)
    }

    /// Returns the changes to a motion that the options request.
    pub(super) fn choices(&self) -> MotionChoices {
        MotionChoices {
            fit: self.fits(),
            keep_time: self.keep_time.unwrap_or(self.has_clock),
            loop_blend_s: self.blend_s,
            driven: self.driven,
        }
    }

    /// Reads a rig, and holds its base as the options say.
    pub(super) fn rig(&self, path: &Path, defaults: Defaults) -> anyhow::Result<LoadedRig> {
        let mut rig = read(path)?;
        let base = match self.base {
            None if defaults.travels && has_feet(&rig.mechanism) => Base::Driven,
            None => return Ok(rig),
            Some(BaseArg::Stand) => Base::Fixed,
            Some(BaseArg::Driven) => Base::Driven,
        };
        rig.set_base(base)?;
        Ok(rig)
    }

    /// Retargets a clip to a rig, or reads a file of the rig's own motion, and prints notes on it. Fits the motion and
    /// makes it a loop if the options ask for this.
    pub(super) fn perform(
        &self,
        rig: &LoadedRig,
        path: &Path,
        mapping: Option<&Path>,
        seconds: Option<f64>,
        (defaults, units): (Defaults, UnitArgs),
    ) -> anyhow::Result<RigPerformance> {
        let choices = self.choices();
        if let Some(kind) = OwnMotion::of(path) {
            ensure!(
                mapping.is_none()
                    && seconds.is_none()
                    && self.of_clips().or(units.given()).is_none(),
                "{}: {} are the rig's own: only --fit, --keep-time and --base have an effect on them, and --unit on a CSV",
                path.display(),
                kind.name()
            );
            let mut read = kind.read(rig, path, self.header_units())?;
            let name = ClipFile::new(path).name;
            if let Some(keys) = read.keys {
                note(format_args!(
                    "{name}: {keys} rows of keys, {:.2} s",
                    read.motion.duration_s()
                ));
            }
            for jump in &read.jumps {
                note(format_args!("JUMP: {name}: {jump}"));
            }
            tell_followers(&name, rig, &mut read.motion);
            tell_jumps(&name, rig, &read.motion);
            let (motion, start_s) = self.layered(rig, read.motion, read.start_s, read.is_loop)?;
            return RigPerformance::new(rig, &name, start_s, RetargetedClip::own(motion), choices);
        }
        if let Some(option) = self.of_own() {
            bail!(
                "{option}: is of CSV files of joint coordinates, and {} is a clip",
                path.display()
            );
        }
        let file = mapping;
        let mapping = mapping.map(read_mapping).transpose()?;
        let settings = ClipSettings {
            cutoff_hz: Some(self.cutoff_hz.unwrap_or(defaults.cutoff_hz)).filter(|hz| *hz > 0.0),
            units: units.overrides(),
        };
        let mut clip = PreparedClip::read(&ClipFile::new(path), settings)?;
        if let Some(seconds) = seconds {
            clip.cut(seconds);
        }
        let name = &clip.clip.name;
        for line in &clip.notes {
            note(format_args!("note: {name}: {line}"));
        }
        let mut retargeted = retarget_clip(&rig.mechanism, &clip, mapping.as_ref(), self.mirror)
            .with_context(|| match file {
                Some(file) => {
                    format!("{name} on {} by {}", rig.description.name, file.display())
                }
                None => format!("{name} on {}", rig.description.name),
            })?;
        tell(name, rig, &retargeted);
        if !self.fit {
            tell_speed(name, rig, &retargeted);
        }
        tell_jumps(name, rig, &retargeted.motion);
        let (name, start_s) = (name.clone(), clip.start_s);
        // A long clip is large, and is not needed any more.
        drop(clip);
        let (motion, start_s) = self.layered(rig, retargeted.motion, start_s, false)?;
        retargeted.motion = motion;
        RigPerformance::new(rig, &name, start_s, retargeted, choices)
    }

    /// Returns the unit, given by `--unit`, of columns whose header has none.
    fn header_units(&self) -> Option<HeaderUnits> {
        self.unit.map(|unit| match unit {
            UnitArg::Deg => HeaderUnits::Degrees,
            UnitArg::Rad => HeaderUnits::Si,
        })
    }

    /// Applies the layers to a motion. Returns the motion and the time of its first row, s.
    fn layered(
        &self,
        rig: &LoadedRig,
        motion: RigMotion,
        start_s: f64,
        is_loop: bool,
    ) -> anyhow::Result<(RigMotion, f64)> {
        if self.layers.is_empty() {
            return Ok((motion, start_s));
        }
        let below = LayeredMotion { motion, start_s, is_loop };
        let (layered, lines) = below.with(rig, &self.layers, self.header_units())?;
        for line in lines {
            note(format_args!("{line}"));
        }
        Ok((layered.motion, layered.start_s))
    }
}

/// Moves each joint that follows another joint to the position that its leader requires, and prints which joints had
/// other positions in the file.
fn tell_followers(name: &str, rig: &LoadedRig, motion: &mut RigMotion) {
    let mechanism = &rig.mechanism;
    let ties = mechanism.ties();
    for (body, most) in motion.follow(&ties) {
        let link = &mechanism.bodies[body];
        let leader = &mechanism.bodies[ties.leader_of(body)].joint_name;
        let change = text::change(matches!(link.joint, JointModel::Prismatic(_)), most);
        note(format_args!(
            "note: {name}: `{}` follows `{leader}`: moved there from its own positions, by {change} at most",
            link.joint_name
        ));
    }
}

/// Prints the first jump of more than half a turn, and the number of all such jumps.
fn tell_jumps(name: &str, rig: &LoadedRig, motion: &RigMotion) {
    let jumps = motion.jumps(&rig.mechanism);
    if let Some(first) = jumps.first() {
        let after_s = first.row as f64 * motion.dt_s;
        note(format_args!(
            "note: {name}: {} time(s) an angle jumps by more than half a turn between frames; first `{}`, by {:.0} deg \
             before {after_s:.3} s: angles must count turns, not wrap",
            jumps.len(),
            first.joint,
            first.change_rad.to_degrees(),
        ));
    }
}

/// Prints how near the rig is to the performer.
fn tell(name: &str, rig: &LoadedRig, taken: &RetargetedClip) {
    let rig = &rig.description.name;
    if let Some([mean, most]) = taken.hand_error {
        note(format_args!(
            "{name} on {rig}: the hand's path is followed, {:.1} % of the arm's length off in the mean, {:.1} % at most",
            100.0 * mean,
            100.0 * most
        ));
    }
    if taken.limbs > 0 {
        note(format_args!(
            "{name} on {rig}: {} limbs followed, mean error {:.1} deg, largest {:.1} deg{}",
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

/// Prints which joint exceeds its maximum speed most, if the path of a hand has priority over joint speeds.
fn tell_speed(name: &str, rig: &LoadedRig, taken: &RetargetedClip) {
    let Some((joint, asked, limit)) = taken.too_fast(&rig.mechanism) else { return };
    let slides = matches!(rig.mechanism.bodies[joint].joint, JointModel::Prismatic(_));
    let (unit, factor) = if slides { ("mm/s", 1e3) } else { ("deg/s", 1_f64.to_radians().recip()) };
    note(format_args!(
        "note: {name}: `{}` would move at up to {:.0} {unit}, and its limit is {:.0} {unit}: --fit slows the motion down",
        rig.mechanism.bodies[joint].joint_name,
        asked * factor,
        limit * factor
    ));
}

fn cutoff(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(hz) if (0.0..=1000.0).contains(&hz) => Ok(hz),
        _ => Err("expected a number of Hz from 0 to 1000".into()),
    }
}
