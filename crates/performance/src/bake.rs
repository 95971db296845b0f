//! Makes a show of a rig's motion.

use std::borrow::Cow;
use std::cell::RefCell;

use sinew_retarget::feasibility::{
    CheckError, Curve, Excess, Fit, FitError, Instant, Kind, Limits, LoopError, MotionError,
    Performance, Report, RigMotion, check, rate_at_rows, refit,
};
use sinew_rig::board::BoardRig;
use sinew_rig::mechanism::JointModel;
use sinew_rig::{Description, Mechanism};
use sinew_show::write::{Motion, Settings, ShowTie, WriteError, Writer, Written};
use sinew_show::{Joint, Player, Rate, Show, ShowError, TimeCode};
use thiserror::Error;

/// Channels of the largest rig.
const CHANNELS: usize = 256;
/// Capacities of the largest board. The CRC of a rig does not depend on them.
const BODIES: usize = 64;
const DOFS: usize = 128;
const SERVOS: usize = 64;
/// Rate at which a show is checked against limits, Hz.
pub const CHECK_HZ: f64 = 250.0;
/// Rate at which a show that must not exceed a limit is checked, Hz. Between the checks of a lower rate, the show could
/// exceed the limit for a few milliseconds.
const FITTED_HZ: f64 = 1000.0;
/// Lowest rate of the rough check that precedes the fine check, Hz. It checks at least the samples, where accelerations
/// are largest.
const ROUGH_HZ: f64 = 100.0;
/// Rate of rows, Hz. A motion with a lower rate that misses its error bound gets more rows.
const FINE_HZ: f64 = 100.0;
/// Largest number of fits for one show.
const FITS: usize = 12;
/// Factor on the permitted error of a show in each attempt to bring the show nearer to its motion; and the smallest
/// share of the permitted error that is tried. The accelerations of a curve with short spans are in proportion to its
/// quantization step.
const NEARER: f64 = 0.25;
const NEAREST: f64 = 1.0 / 256.0;
/// Time before and after an excess in which the error is reduced, and time beside it in which the error grows to its
/// old size, s. An error of 0.25 degrees that appears and disappears in 0.4 s needs 0.1 rad/s².
const AROUND_S: f64 = 0.03;
const BESIDE_S: f64 = 0.4;

/// The reason why a motion cannot become a show.
#[derive(Debug, Error)]
pub enum BakeError {
    /// The motion exceeds the bounds of the format.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The written show does not play.
    #[error("the show does not play: {0}")]
    Show(#[from] ShowError),
    /// The motion is invalid for the rig.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The format cannot express the rate.
    #[error("rate: expected a whole number of samples a second, or one over 1.001, found {0}")]
    Rate(f64),
    /// The motion cannot be brought within the rig's limits.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The fitted motion cannot be blended into its start.
    #[error(transparent)]
    Loop(#[from] LoopError),
    /// The show cannot be checked.
    #[error(transparent)]
    Check(#[from] CheckError),
    /// The rounding in the show exceeds a limit, although the motion was fitted again several times.
    #[error(
        "`{joint}`: the {} of the fitted show is {} and its limit is {}; a smaller --tolerance-deg, or more room in \
         rig.toml, helps, and a longer --loop-blend-s of a loop",
        kind.name(),
        kind.shown(*slides, *value),
        kind.shown(*slides, *limit)
    )]
    Rounded {
        /// Name of the dof.
        joint: String,
        /// Whether the dof slides.
        slides: bool,
        /// Quantity that exceeds its limit.
        kind: Kind,
        /// Value in the show.
        value: f64,
        /// Limit of the rig.
        limit: f64,
    },
    /// The show cannot be judged.
    #[error(transparent)]
    Judge(anyhow::Error),
    /// A servo that closes its own loop stays behind, although the motion was fitted again several times.
    #[error(
        "`{joint}`: its servo would be {} behind at {time_s:.2} s of the fitted show, and a fit allows {}: a lower speed \
         limit in rig.toml, a stronger or stiffer servo, or less weight helps",
        Kind::Following.shown(*slides, *value),
        Kind::Following.shown(*slides, *limit)
    )]
    Behind {
        /// Name of the dof.
        joint: String,
        /// Whether the dof slides.
        slides: bool,
        /// Predicted following error, rad or m.
        value: f64,
        /// Limit of a fit, rad or m.
        limit: f64,
        /// Time in the show, s.
        time_s: f64,
    },
}

/// A show of a rig's motion.
#[derive(Debug, Clone)]
pub struct Baked {
    /// The show, and its errors at the samples.
    pub written: Written,
    /// Duration, s.
    pub duration_s: f64,
    /// Number of moving dofs.
    pub dofs: usize,
}

impl Baked {
    /// Returns how many minutes of a show like this fit into a number of bytes.
    pub fn minutes_in(&self, bytes: usize) -> f64 {
        let per_s = self.written.bytes.len() as f64 / self.duration_s;
        bytes as f64 / per_s / 60.0
    }
}

/// Content of a show besides the motion.
#[derive(Debug, Clone, Default)]
pub struct ShowMarks {
    /// Rows of the motion, with names.
    pub cues: Vec<(u32, String)>,
    /// Time code of the first row; `None` for a show without time code.
    pub time_code: Option<TimeCode>,
    /// Pairs of a row of the motion and a row of the motion before it was slowed down: see [`course`].
    pub course: Vec<(u32, u32)>,
    /// Whether the show is a loop: the last row of its motion equals the first.
    pub is_loop: bool,
}

impl ShowMarks {
    /// Returns the motion of a fit, and no marks, for [`Baker::bake_within`].
    ///
    /// # Errors
    /// Never fails: it returns a `Result` only because [`Baker::bake_within`] expects one.
    pub fn of_none(fit: &Fit) -> Result<(Cow<'_, RigMotion>, Self), BakeError> {
        Ok((Cow::Borrowed(&fit.motion), Self::default()))
    }
}

/// Returns pairs of rows, of the fit and of the given motion, so that the time code can follow a slowed-down show.
/// Between pairs the error is at most half a frame plus the rounding to rows. Empty if the motion was not slowed
/// down.
pub fn course(fit: &Fit, time_code: TimeCode) -> Vec<(u32, u32)> {
    let dt_s = fit.motion.dt_s;
    let most = 0.5 / f64::from(time_code.frames_per_second) / dt_s;
    let given: Vec<f64> = fit.given_s.iter().map(|given_s| given_s / dt_s).collect();
    if given.iter().enumerate().all(|(row, given)| (given - row as f64).abs() < 1e-6) {
        return Vec::new();
    }
    let mut pairs = Vec::new();
    let (mut first, mut slopes) = (0, [f64::NEG_INFINITY, f64::INFINITY]);
    for row in 1..given.len() {
        // Slopes that are near enough to each row since the last pair.
        let far = (row - first) as f64;
        let way = given[row] - given[first];
        let to = [f64::max(slopes[0], (way - most) / far), f64::min(slopes[1], (way + most) / far)];
        let is_straight = to[0] <= way / far && way / far <= to[1];
        if is_straight {
            slopes = to;
            continue;
        }
        first = row - 1;
        pairs.push(first);
        let way = given[row] - given[first];
        slopes = [way - most, way + most];
    }
    pairs.push(given.len() - 1);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rows, below 2^30")]
    pairs.into_iter().map(|row| (row as u32, given[row].round() as u32)).collect()
}

/// Data that all shows of a rig share.
#[derive(Debug, Clone, Copy)]
pub struct Baker<'a> {
    /// The rig for which shows are baked.
    pub mechanism: &'a Mechanism,
    /// CRC of the rig's compact form, or 0.
    pub rig: u32,
    /// Error bounds of a show.
    pub settings: Settings,
}

impl Baker<'_> {
    /// Writes a show of a rig's motion.
    ///
    /// # Errors
    /// [`BakeError`] if the format cannot express the motion or its rate, or the motion is not one of the rig.
    pub fn bake(&self, motion: &RigMotion, marks: &ShowMarks) -> Result<Baked, BakeError> {
        let once = |motion: &RigMotion, marks: &ShowMarks| {
            let content = Content::of(self.mechanism, motion, marks)?;
            content.baked(&mut self.writer(&content)?)
        };
        let baked = once(motion, marks);
        if is_beyond_bound(&baked)
            && let Some((motion, marks)) = self.finer(motion, marks)?
        {
            return once(&motion, &marks);
        }
        baked
    }

    /// Returns a motion of few rows with more rows, and its marks: near the ends of a coarse motion, a spline through
    /// few rows cannot reach a small error. `None` for a fine motion.
    fn finer(
        &self,
        motion: &RigMotion,
        marks: &ShowMarks,
    ) -> Result<Option<(RigMotion, ShowMarks)>, BakeError> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 100")]
        let factor = (FINE_HZ * motion.dt_s).ceil().clamp(1.0, FINE_HZ) as u32;
        if factor == 1 {
            return Ok(None);
        }
        let curve = Curve::new(self.mechanism, motion)?;
        let finer = curve.resampled(f64::from(factor) / motion.dt_s);
        let cue = |(row, name): &(u32, String)| (row * factor, name.clone());
        let pair = |(row, given): &(u32, u32)| (row * factor, given * factor);
        let marks = ShowMarks {
            cues: marks.cues.iter().map(cue).collect(),
            course: marks.course.iter().map(pair).collect(),
            ..*marks
        };
        Ok(Some((finer, marks)))
    }

    /// Creates the writer of a content, whose followers have the curves of their leaders.
    fn writer<'c>(&self, content: &'c Content<'_>) -> Result<Writer<'c>, BakeError> {
        let mut writer = Writer::new(content.motion(self.rig), self.settings)?;
        writer.tie(self.mechanism.ties().each().map(|tie| ShowTie {
            joint: tie.body,
            leader: tie.leader,
            factor: tie.factor,
            offset: tie.offset,
        }));
        Ok(writer)
    }

    /// Makes a show of a fitted motion. The show keeps all limits in spite of rounding: if it exceeds a limit, it is
    /// brought nearer to the motion; if it still exceeds the limit, the motion is fitted again with tighter limits.
    /// `given`: the motion before the fit; `judge`: adds what else a show within all limits exceeds to its report;
    /// `of_fit`: returns the motion and the marks of a fit.
    ///
    /// # Errors
    /// [`BakeError`] if there is no such show.
    pub fn bake_within(
        &self,
        limits: &Limits,
        given: &RigMotion,
        mut fitted: Fit,
        mut judge: impl FnMut(&Baked, &mut Report) -> anyhow::Result<()>,
        of_fit: impl Fn(&Fit) -> Result<(Cow<'_, RigMotion>, ShowMarks), BakeError>,
    ) -> Result<(Fit, Baked, Report), BakeError> {
        let settings = fitted.settings;
        let mut tight = limits.clone();
        let mut fits = 0;
        loop {
            let (baked, mut report) = {
                let (motion, marks) = of_fit(&fitted)?;
                self.bake_near(limits, &motion, &marks)?
            };
            if report.excesses.is_empty() {
                judge(&baked, &mut report).map_err(BakeError::Judge)?;
            }
            let Some(worst) = report.excesses.first() else { return Ok((fitted, baked, report)) };
            loop {
                if fits == FITS {
                    return Err(rounded(limits, worst));
                }
                fits += 1;
                tight = tight.tightened(&report);
                let before = fitted.motion.fingerprint();
                // Frees the motion, which may be long, before the next one is made.
                let progress = fitted.into_progress();
                fitted = refit(self.mechanism, &tight, given, &progress, settings)?;
                // An equal motion would give an equal show.
                if fitted.motion.fingerprint() != before {
                    break;
                }
            }
        }
    }

    /// Makes a show that is near enough to its motion to keep the limits. If there is no such show, returns the nearest
    /// one with its report.
    fn bake_near(
        &self,
        limits: &Limits,
        motion: &RigMotion,
        marks: &ShowMarks,
    ) -> Result<(Baked, Report), BakeError> {
        let baked = self.bake_near_once(limits, motion, marks);
        if is_beyond_bound(&baked)
            && let Some((motion, marks)) = self.finer(motion, marks)?
        {
            return self.bake_near_once(limits, &motion, &marks);
        }
        baked
    }

    fn bake_near_once(
        &self,
        limits: &Limits,
        motion: &RigMotion,
        marks: &ShowMarks,
    ) -> Result<(Baked, Report), BakeError> {
        let content = Content::of(self.mechanism, motion, marks)?;
        let mut writer = self.writer(&content)?;
        loop {
            let baked = content.baked(&mut writer)?;
            let played = ShowPlayback::new(&baked.written.bytes)?;
            let rough_hz = rate_at_rows(ROUGH_HZ, motion.dt_s);
            let mut report = check(self.mechanism, limits, &played, rough_hz)?;
            if report.excesses.is_empty() {
                report = check(self.mechanism, limits, &played, FITTED_HZ)?;
            }
            let mut is_nearer = false;
            for excess in &report.excesses {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "not negative, and saturates"
                )]
                let sample = |time_s: f64| (time_s / motion.dt_s).max(0.0).round() as usize;
                let samples = sample(excess.from_s - AROUND_S)..sample(excess.to_s + AROUND_S) + 1;
                let beside = sample(BESIDE_S);
                for joint in self.causes(limits.dofs[excess.dof].joint, excess.kind) {
                    is_nearer |=
                        writer.bring_nearer(joint, samples.clone(), beside, [NEARER, NEAREST]);
                }
            }
            if !is_nearer {
                return Ok((baked, report));
            }
        }
    }

    /// Returns the joints whose curves can cause an excess of a joint.
    fn causes(&self, joint: usize, kind: Kind) -> impl Iterator<Item = usize> {
        let supports = |a, b| self.mechanism.supports(a, b);
        let is_cause = move |other: &usize| match kind {
            Kind::Effort => supports(joint, *other) || supports(*other, joint),
            Kind::Speed | Kind::Acceleration => joint == *other,
            // A fit leaves a margin for errors of positions, and a short error does not heat a servo.
            Kind::Range | Kind::LinkedRange | Kind::Heat | Kind::Following => false,
        };
        (0..self.mechanism.bodies.len()).filter(is_cause)
    }
}

/// Returns whether a show could not reach its error bound.
fn is_beyond_bound<T>(baked: &Result<T, BakeError>) -> bool {
    matches!(baked, Err(BakeError::Write(WriteError::Bound { .. })))
}

/// Content of a show: data from the motion, and the marks.
struct Content<'a> {
    joints: Vec<Joint>,
    q: Vec<f64>,
    rate: Rate,
    cues: Vec<(u32, &'a str)>,
    marks: &'a ShowMarks,
    dofs: usize,
    duration_s: f64,
}

impl<'a> Content<'a> {
    fn of(
        mechanism: &Mechanism,
        motion: &RigMotion,
        marks: &'a ShowMarks,
    ) -> Result<Self, BakeError> {
        // In a loop the first sample follows the last.
        let rows = &motion.rows[..motion.rows.len() - usize::from(marks.is_loop)];
        let last = u32::try_from(rows.len() - 1).unwrap_or(u32::MAX);
        let cue = |(row, name): &'a (u32, String)| ((*row).min(last), name.as_str());
        let kinds = mechanism.bodies.iter().map(|link| link.joint.kind());
        let moving = mechanism.bodies.iter().filter(|link| link.joint != JointModel::Free);
        Ok(Self {
            joints: kinds.map(Joint::from).collect(),
            q: rows.iter().flatten().copied().collect(),
            rate: rate(motion.dt_s)?,
            cues: marks.cues.iter().map(cue).collect(),
            marks,
            dofs: moving.map(|link| link.joint.kind().dof_count()).sum(),
            duration_s: motion.duration_s(),
        })
    }

    fn motion(&self, rig: u32) -> Motion<'_> {
        let ShowMarks { time_code, course, is_loop, .. } = self.marks;
        Motion {
            joints: &self.joints,
            q: &self.q,
            rate: self.rate,
            is_loop: *is_loop,
            rig,
            cues: &self.cues,
            time_code: *time_code,
            course,
        }
    }

    fn baked(&self, writer: &mut Writer<'_>) -> Result<Baked, BakeError> {
        let written = writer.write()?;
        // The show is opened in the same way as on a board.
        Show::open(&written.bytes)?.check_blocks()?;
        Ok(Baked { written, duration_s: self.duration_s, dofs: self.dofs })
    }
}

fn rounded(limits: &Limits, worst: &Excess) -> BakeError {
    let dof = &limits.dofs[worst.dof];
    let (joint, slides) = (dof.name.clone(), dof.slides);
    let Excess { kind, value, limit, worst_s, .. } = *worst;
    if kind == Kind::Following {
        return BakeError::Behind { joint, slides, value, limit, time_s: worst_s };
    }
    BakeError::Rounded { joint, slides, kind, value, limit }
}

/// Returns a rate in the form of a show: an integer number of samples in an integer number of seconds.
fn rate(dt_s: f64) -> Result<Rate, BakeError> {
    let hz = dt_s.recip();
    // Rates of television are a whole number of frames in 1001 s.
    for seconds in [1_u32, 1001] {
        let samples = hz * f64::from(seconds);
        if (samples - samples.round()).abs() < 1e-6 * samples && (1.0..1e6).contains(&samples) {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "1 to 1e6"
            )]
            return Ok(Rate { samples: samples.round() as u32, seconds });
        }
    }
    Err(BakeError::Rate(hz))
}

/// A show as it plays, with the derivatives of its curve, as input for [`check`](sinew_retarget::feasibility::check).
#[derive(Debug)]
pub struct ShowPlayback<'a> {
    player: RefCell<(Player<'a, CHANNELS>, State)>,
}

/// Coordinates with their derivatives, in the board's precision.
#[derive(Debug)]
struct State {
    q: Vec<f32>,
    qd: Vec<f32>,
    qdd: Vec<f32>,
}

impl<'a> ShowPlayback<'a> {
    /// Opens a show.
    ///
    /// # Errors
    /// [`ShowError`] if the bytes are not a show, or the show is larger than any rig.
    pub fn new(bytes: &'a [u8]) -> Result<Self, ShowError> {
        let show = Show::open(bytes)?;
        show.check_blocks()?;
        let none = vec![0.0; show.dof_count()];
        let state = State { q: vec![0.0; show.channel_count()], qd: none.clone(), qdd: none };
        Ok(Self { player: RefCell::new((Player::new(show)?, state)) })
    }

    /// Returns the motion of the show, a row every `dt_s`.
    pub fn motion(&self, dt_s: f64) -> RigMotion {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let last = (self.duration_s() / dt_s).round() as usize;
        let row = |index: usize| {
            let mut instant = Instant::default();
            self.at(index as f64 * dt_s, &mut instant);
            instant.q
        };
        RigMotion { dt_s, rows: (0..=last).map(row).collect() }
    }
}

impl Performance for ShowPlayback<'_> {
    fn duration_s(&self) -> f64 {
        f64::from(self.player.borrow().0.show().duration_s())
    }

    fn at(&self, time_s: f64, instant: &mut Instant) {
        let (player, State { q, qd, qdd }) = &mut *self.player.borrow_mut();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let position = player.show().position_at_us((time_s.max(0.0) * 1e6).round() as u64);
        // The blocks are checked in `new`.
        let _ = player.state_at(position, q, qd, qdd);
        let wide = |numbers: &[f32], out: &mut Vec<f64>| {
            out.clear();
            out.extend(numbers.iter().map(|x| f64::from(*x)));
        };
        wide(q, &mut instant.q);
        wide(qd, &mut instant.qd);
        wide(qdd, &mut instant.qdd);
    }
}

/// Returns the CRC of a rig's compact form, by which a board recognizes its own shows. Returns 0 and a reason if the
/// rig does not fit on any board.
pub fn rig_hash(rig: &Description, mechanism: &Mechanism) -> (u32, Option<String>) {
    let none = |why: String| {
        (0, Some(format!("the show names no rig, because no board can hold this rig: {why}")))
    };
    let board = match BoardRig::<BODIES, DOFS, SERVOS>::bake(rig, mechanism) {
        Ok(board) => board,
        Err(error) => return none(error.to_string()),
    };
    let mut bytes = vec![0; 1 << 16];
    let crc = board.encode(&mut bytes).map(|length| {
        bytes
            .get(..length)
            .and_then(|bytes| bytes.last_chunk::<4>())
            .copied()
            .map(u32::from_le_bytes)
    });
    match crc {
        Ok(crc) => (crc.unwrap_or(0), None),
        Err(error) => none(error.to_string()),
    }
}
