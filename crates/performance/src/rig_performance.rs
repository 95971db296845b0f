//! A performance of a rig: a motion looped, fitted, and baked as a show.

use std::borrow::Cow;
use std::path::Path;

use anyhow::{Context as _, bail, ensure};
use sinew_mocap::{Kind, read};
use sinew_retarget::feasibility::{
    Curve, Fit, FitSettings, Limits, LoopError, LoopedMotion, Report, RigMotion, check, fit,
    looped, rate_at_rows,
};
use sinew_retarget::mapping::Mapping;
use sinew_rig::review::Servos;
use sinew_rig::{Description, Mechanism};
use sinew_show::TimeCode;
use sinew_show::write::Settings;

use super::bake::{BakeError, Baked, Baker, CHECK_HZ, ShowMarks, ShowPlayback, course};
use super::following::{Allowance, FollowingCheck, Prediction};
use super::left::{JointLeft, headline};
use super::likeness::{Likeness, helps, way_share};
use super::play::Options;
use super::retargeted_clip::RetargetedClip;
use super::rig::LoadedRig;
use super::rounding::is_rounding;
use super::table::{self, fitted};

/// Lowest rate of the check that finds which changes of the rig would preserve more of a motion, Hz.
const HELP_HZ: f64 = 100.0;

/// Choices for the changes of a motion before its use.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MotionChoices {
    /// Whether the motion is fitted within all limits of the rig.
    pub fit: bool,
    /// Whether a fit keeps the time: where the motion exceeds a limit, it becomes smaller or smoother, but not slower.
    pub keep_time: bool,
    /// Length of the blend of a loop's end into its start, s; `None`: no loop.
    pub loop_blend_s: Option<f64>,
    /// Drive of the servos: following errors are predicted for servos in position mode.
    pub driven: Options,
}

/// Choices for a show.
#[derive(Debug, Clone, Copy, Default)]
pub struct ShowChoices<'a> {
    /// The CRC of the rig's compact form, or 0.
    pub rig_crc: u32,
    /// Error bounds of the show.
    pub settings: Settings,
    /// Cues: names, and times in the clip, s.
    pub cues: &'a [(String, f64)],
    /// The time code of the first row; `None` for a show without time code.
    pub time_code: Option<TimeCode>,
}

/// A motion on a rig, and the changes that were made to it.
pub struct RigPerformance {
    /// Name of the clip.
    pub name: String,
    /// Time of its first frame in the clip's file, s.
    pub start_s: f64,
    /// The clip on the rig; for a loop, with the looped motion.
    pub clip: RetargetedClip,
    /// The limits of the rig.
    pub limits: Limits,
    /// The changes made for a loop, whose motion is in `clip`; `None` if the motion is not a loop.
    pub looped: Option<LoopedMotion>,
    /// The fitted motion; `None` if no fit was chosen.
    pub fit: Option<Fit>,
    /// Predicted following errors of the baked show; `None` before it is baked, and if no servo closes its own loop and
    /// reports its position.
    pub predicted: Option<Prediction>,
    /// The rig, and how it is driven.
    played: (Description, Options),
    loop_blend_s: Option<f64>,
}

impl RigPerformance {
    /// Makes a loop of the motion and fits it within the rig's limits, if that is chosen.
    ///
    /// # Errors
    /// The motion cannot be looped or fitted.
    pub fn new(
        rig: &LoadedRig,
        name: &str,
        start_s: f64,
        mut clip: RetargetedClip,
        choices: MotionChoices,
    ) -> anyhow::Result<Self> {
        let mechanism = &rig.mechanism;
        let limits = Limits::of(mechanism, &Servos::of(&rig.description, mechanism)?);
        let on_rig = || format!("{name} on {}", rig.description.name);
        let led = |blend_s| -> Result<LoopedMotion, LoopError> {
            let looped = looped(mechanism, &clip.motion, blend_s)?;
            // With a fit, the whole motion is brought within the limits later.
            if !choices.fit {
                looped.check(mechanism, &limits, &clip.motion)?;
            }
            Ok(looped)
        };
        let loop_blend_s = choices.loop_blend_s;
        let looped = loop_blend_s.map(led).transpose().with_context(on_rig)?;
        if let Some(looped) = &looped {
            clip.motion.clone_from(&looped.motion);
        }
        let fit = choices
            .fit
            .then(|| {
                let keep_time = choices.keep_time;
                let from_rest = loop_blend_s.is_none();
                let settings = FitSettings { keep_time, from_rest, ..FitSettings::default() };
                fit(mechanism, &limits, &clip.motion, settings)
            })
            .transpose()
            .with_context(on_rig)?;
        let (name, predicted) = (name.to_owned(), None);
        let played = (rig.description.clone(), choices.driven);
        Ok(Self { name, start_s, clip, limits, looped, fit, predicted, played, loop_blend_s })
    }

    /// Bakes the motion as a show, and checks the show against the rig's limits. A fitted motion is fitted again if
    /// the show would exceed a limit.
    ///
    /// # Errors
    /// There is no such show, a cue is not within the clip, or a fitted show stops the simulated rig.
    pub fn bake(
        &mut self,
        mechanism: &Mechanism,
        choices: &ShowChoices<'_>,
    ) -> anyhow::Result<(Baked, Report)> {
        let ShowChoices { rig_crc, settings, time_code, .. } = *choices;
        let baker = Baker { mechanism, rig: rig_crc, settings };
        let is_loop = self.loop_blend_s.is_some();
        let marks = |cues, course| ShowMarks { cues, time_code, course, is_loop };
        // Cues outside the clip are refused before the work.
        let cues = self.cues(None, choices.cues)?;
        let (rig, driven) = &self.played;
        let following = FollowingCheck::new(rig, mechanism, *driven, rig_crc)?;
        let Some(fit) = self.fit.take() else {
            let baked = baker.bake(&self.clip.motion, &marks(cues, Vec::new()))?;
            let played = ShowPlayback::new(&baked.written.bytes)?;
            let mut report = check(mechanism, &self.limits, &played, CHECK_HZ)?;
            let rounding = &baked.written.rounding;
            report
                .excesses
                .retain(|excess| !is_rounding(mechanism, &self.limits, rounding, excess));
            if let Some(following) = &following {
                let predicted =
                    following.of(&baked.written.bytes, &report, Allowance::Supervisor)?;
                report.add(predicted.excesses.iter().cloned());
                self.predicted = Some(predicted);
            }
            return Ok((baked, report));
        };
        let mut predicted = None;
        let judge = |baked: &Baked, report: &mut Report| {
            if let Some(following) = &following {
                let found = following.of(&baked.written.bytes, report, Allowance::Fit)?;
                // An excess may cause the stop; another fit then removes both.
                if found.excesses.is_empty()
                    && let Some(why) = &found.stopped
                {
                    bail!("the fitted show does not play to its end on the simulated rig: {why}");
                }
                report.add(found.excesses.iter().cloned());
                predicted = Some(found);
            }
            anyhow::Ok(())
        };
        let (fit, baked, report) =
            baker.bake_within(&self.limits, &self.clip.motion, fit, judge, |fit| {
                let course = time_code.map(|code| course(fit, code)).unwrap_or_default();
                let cues = self.cues(Some(fit), choices.cues).unwrap_or_default();
                // A fit does not keep a loop closed: it may change one end a little more than the other. The loop is
                // therefore closed again.
                let closed = |blend_s| looped(mechanism, &fit.motion, blend_s);
                let closed = self.loop_blend_s.map(closed).transpose().map_err(BakeError::Loop)?;
                let motion =
                    closed.map_or(Cow::Borrowed(&fit.motion), |looped| Cow::Owned(looped.motion));
                Ok((motion, marks(cues, course)))
            })?;
        self.fit = Some(fit);
        self.predicted = predicted;
        Ok((baked, report))
    }

    /// Returns the rows of cues in the motion, or in a fit's motion. The times of the cues are times of the clip.
    fn cues(
        &self,
        fit: Option<&Fit>,
        cues: &[(String, f64)],
    ) -> anyhow::Result<Vec<(u32, String)>> {
        let given_s = self.clip.motion.duration_s();
        let cue = |(name, time_s): &(String, f64)| {
            ensure!(
                *time_s <= given_s,
                "--cue {name}@{time_s}: expected a time within the clip, which lasts {given_s:.2} s"
            );
            Ok((u32::try_from(self.row_at(fit, *time_s))?, name.clone()))
        };
        cues.iter().map(cue).collect()
    }

    /// Returns the row of the motion, or of a fit's motion, at a time of the clip.
    fn row_at(&self, fit: Option<&Fit>, given_s: f64) -> usize {
        let motion = &self.clip.motion;
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

    /// Describes the changes by a fit; `None` if no fit was chosen.
    pub fn fit_summary(&self, mechanism: &Mechanism) -> Option<String> {
        let given_s = self.clip.motion.duration_s();
        self.fit.as_ref().map(|fit| fitted(&self.limits, fit, given_s, &self.left(mechanism)))
    }

    /// Returns the line about the predicted following errors; `None` without a prediction.
    pub fn following_line(&self) -> Option<String> {
        self.predicted.as_ref().map(|predicted| table::following(&self.limits, predicted))
    }

    /// Returns the headline of a fit; `None` without a fit, or if the change is not worth a headline.
    pub fn headline(&self, mechanism: &Mechanism) -> Option<String> {
        let fit = self.fit.as_ref()?;
        let given = &self.clip.motion;
        let times_s = [given, &fit.motion].map(RigMotion::duration_s);
        let left = self.left(mechanism);
        headline(times_s, way_share(&fit.motion, given), fit.settings.keep_time.then_some(&left))
    }

    /// Compares each joint's motion with its motion before the fit.
    pub fn left(&self, mechanism: &Mechanism) -> Vec<JointLeft> {
        JointLeft::each(mechanism, self.motion(), &self.clip.motion)
    }

    /// Converts a time of the clip to a time of the used motion, s.
    pub fn time_s(&self, given_s: f64) -> f64 {
        self.row_at(self.fit.as_ref(), given_s) as f64 * self.motion().dt_s
    }

    /// Compares the used motion with the performer, and with the motion before a fit.
    pub fn likeness(&self, mechanism: &Mechanism) -> Likeness {
        let motion = self.motion();
        let (mut limbs, mut hands) = (Mean::default(), Mean::default());
        for (row, q) in motion.rows.iter().enumerate() {
            let time_s = row as f64 * motion.dt_s;
            let clip_s = self.fit.as_ref().map_or(time_s, |fit| fit.given_time_s(time_s));
            let poses = mechanism.poses(q);
            self.clip.limb_errors_deg(clip_s, &poses).for_each(|error| limbs.add(error));
            self.clip.hand_errors(clip_s, &poses).for_each(|error| hands.add(error));
        }
        let way = way_share(motion, &self.clip.motion);
        Likeness { limbs_deg: limbs.mean_and_most(), hands: hands.mean_and_most(), way }
    }

    /// Describes which changes of the rig would preserve more of the motion than the fit did, one line for each kind of
    /// limit.
    ///
    /// # Errors
    /// The motion cannot be checked.
    pub fn helps(&self, mechanism: &Mechanism) -> anyhow::Result<Vec<String>> {
        let motion = &self.clip.motion;
        let curve = Curve::new(mechanism, motion)?;
        let given = check(mechanism, &self.limits, &curve, rate_at_rows(HELP_HZ, motion.dt_s))?;
        Ok(helps(&self.limits, &given))
    }

    /// Returns the used motion: the fitted one, if there is one.
    pub fn motion(&self) -> &RigMotion {
        self.fit.as_ref().map_or(&self.clip.motion, |fit| &fit.motion)
    }
}

/// Mean and largest value of some numbers.
#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    sum: f64,
    most: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.most = self.most.max(value);
        self.count += 1;
    }

    fn mean_and_most(self) -> Option<[f64; 2]> {
        (self.count > 0).then(|| [self.sum / f64::from(self.count), self.most])
    }
}

/// Reads a mapping of a clip's joints to a rig.
///
/// # Errors
/// The file is not a mapping.
pub fn read_mapping(path: &Path) -> anyhow::Result<Mapping> {
    let expected = "a mapping on the rig, as `sinew clip map --rig` proposes it";
    let text = read::text_of(path, expected, &[Kind::RigMapping, Kind::Toml])
        .with_context(|| path.display().to_string())?;
    Mapping::read(&text).with_context(|| path.display().to_string())
}
