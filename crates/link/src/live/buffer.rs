//! The live buffer: frames in any order in, one target for each tick out.

use heapless::Vec;

use super::coordinate::{Coordinate, LARGEST};
use super::timeline::Timeline;
use super::{LiveRefusal, LiveSettings, LiveSetupError};
use crate::message::LiveFrame;

/// Maximum delay and time-out, us.
const LONGEST_US: u32 = 2_000_000;

/// A buffer for live frames of a rig with at most `N` coordinates. It stores `FRAMES` frames: those within the delay,
/// and a few more. If a source sends more frames than that, a frame whose time is close to that of another frame is
/// dropped.
///
/// Targets begin at the pose of [`start`](Self::start), and never exceed the limits of speed, whatever arrives.
/// Between two frames they are interpolated. Nothing is extrapolated: if the next frame is missing, the last frame is
/// held.
#[derive(Debug, Clone)]
pub struct LiveBuffer<const N: usize, const FRAMES: usize> {
    coordinates: Vec<Coordinate, N>,
    /// Number of coordinates of a pose that are used.
    len: usize,
    settings: LiveSettings,
    frames: [Option<Stored<N>>; FRAMES],
    timeline: Option<Timeline>,
    stale: bool,
    target: [f32; N],
    counts: LiveCounts,
}

#[derive(Debug, Clone, Copy)]
struct Stored<const N: usize> {
    sent: i64,
    q: [f32; N],
}

/// Counts of live frames. They stop at their maximum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LiveCounts {
    /// Frames that were accepted.
    pub taken: u32,
    /// Frames that arrived too late.
    pub too_late: u32,
    /// Frames that were refused for another reason.
    pub refused: u32,
    /// Accepted frames that were dropped, because others are close.
    pub thinned: u32,
    /// Ticks in which a frame was missing, and the last frame was held.
    pub held: u32,
}

/// The source of a tick's target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Following {
    /// No frame is due yet: the target stays.
    Waiting,
    /// The target is interpolated between two frames.
    Interpolated,
    /// The next frame is missing: the last frame is held.
    Held,
    /// No new frame arrived within the time-out: the target stays, and the timing of frames must start again.
    Stale,
}

/// The target of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveTarget<'a> {
    /// Coordinates of the rig: rad, m, unit quaternions xyzw.
    pub q: &'a [f32],
    /// Source of the coordinates.
    pub following: Following,
    /// Time since the newest frame arrived, us; `None` without a frame.
    pub age_us: Option<u32>,
    /// Whether a limit of speed holds the target back.
    pub limited: bool,
}

impl<const N: usize, const FRAMES: usize> LiveBuffer<N, FRAMES> {
    /// Creates a buffer for these joints, in the order of the rig's coordinates.
    ///
    /// # Errors
    /// [`LiveSetupError`] if the joints do not fit, or a setting is invalid.
    pub fn new(joints: &[Coordinate], settings: LiveSettings) -> Result<Self, LiveSetupError> {
        const { assert!(FRAMES > 1, "a target lies between two frames") }
        let len = joints.iter().fold(0, |sum: usize, joint| sum.saturating_add(joint.len()));
        let coordinates = Vec::from_slice(joints);
        let (Ok(coordinates), true) = (coordinates, len <= N) else {
            return Err(LiveSetupError::Capacity { room: N, needs: len });
        };
        let slow = |joint: &Coordinate| !(joint.speed() > 0.0 && joint.speed() <= LARGEST);
        if let Some(joint) = joints.iter().position(slow) {
            return Err(LiveSetupError::Speed { joint });
        }
        let LiveSettings { delay_us, stale_us, tick_s } = settings;
        if !(tick_s > 0.0 && tick_s <= 1.0) {
            return Err(LiveSetupError::Tick);
        }
        if delay_us > LONGEST_US || stale_us > LONGEST_US || stale_us == 0 {
            return Err(LiveSetupError::Time);
        }
        let mut target = [0.0; N];
        let mut rest = target.as_mut_slice();
        for joint in joints {
            // Initializes a rotation to the identity.
            if let Some((numbers, behind)) = rest.split_at_mut_checked(joint.len()) {
                if let [_, _, _, w] = numbers {
                    *w = 1.0;
                }
                rest = behind;
            } else {
                rest = &mut [];
            }
        }
        Ok(Self {
            coordinates,
            len,
            settings,
            frames: [None; FRAMES],
            timeline: None,
            stale: false,
            target,
            counts: LiveCounts::default(),
        })
    }

    /// Forgets all frames and sets the target to this pose: the measured pose, or the last target of the previous
    /// source.
    ///
    /// # Errors
    /// [`LiveRefusal`] if the pose is invalid. Nothing changes then.
    pub fn start(&mut self, q: &[f32]) -> Result<(), LiveRefusal> {
        self.check(q)?;
        if let Some(target) = self.target.get_mut(..q.len()) {
            target.copy_from_slice(q);
        }
        self.forget();
        self.stale = false;
        Ok(())
    }

    /// Accepts a frame that arrived now. O(coordinates + `FRAMES`).
    ///
    /// # Errors
    /// [`LiveRefusal`] if the frame is not used. The refused frame is counted.
    pub fn push(&mut self, frame: &LiveFrame, now_us: u64) -> Result<(), LiveRefusal> {
        let result = self.take(frame, now_us);
        let count = match result {
            Ok(()) => &mut self.counts.taken,
            Err(LiveRefusal::TooLate) => &mut self.counts.too_late,
            Err(_) => &mut self.counts.refused,
        };
        *count = count.saturating_add(1);
        result
    }

    /// Computes the target of the current tick. O(coordinates + `FRAMES`).
    pub fn step(&mut self, now_us: u64) -> LiveTarget<'_> {
        let now = time(now_us);
        let age = self.timeline.as_ref().map(|timeline| timeline.age(now));
        if age.is_some_and(|age| age >= i64::from(self.settings.stale_us)) {
            self.forget();
            self.stale = true;
        }
        let (following, limited) = self.follow(now);
        LiveTarget {
            q: self.target.get(..self.len).unwrap_or_default(),
            following,
            age_us: age.map(|age| u32::try_from(age).unwrap_or(u32::MAX)),
            limited,
        }
    }

    /// Returns the counts of frames so far.
    pub fn counts(&self) -> LiveCounts {
        self.counts
    }

    fn check(&self, q: &[f32]) -> Result<(), LiveRefusal> {
        if q.len() != self.len {
            return Err(LiveRefusal::Count { rig: self.len, frame: q.len() });
        }
        let mut first = 0_usize;
        for joint in &self.coordinates {
            let end = first.saturating_add(joint.len());
            joint.check(q.get(first..end).unwrap_or_default(), first)?;
            first = end;
        }
        Ok(())
    }

    fn take(&mut self, frame: &LiveFrame, now_us: u64) -> Result<(), LiveRefusal> {
        self.check(&frame.q)?;
        let now = time(now_us);
        let delay = i64::from(self.settings.delay_us);
        let timeline =
            self.timeline.get_or_insert_with(|| Timeline::new(frame.sent_us, now, delay));
        let sent = timeline.sent(frame.sent_us, now).ok_or(LiveRefusal::Time)?;
        let play = timeline.play();
        let mut played = self.frames.iter().flatten().filter(|stored| stored.sent <= play);
        if played.any(|stored| stored.sent > sent) {
            return Err(LiveRefusal::TooLate);
        }
        if self.frames.iter().flatten().any(|stored| stored.sent == sent) {
            return Err(LiveRefusal::Twice);
        }
        timeline.arrive(sent, now);
        self.stale = false;
        // Three quarters of the places are for the delay; the others are for frames that are played later than that.
        let places = i64::try_from(FRAMES).unwrap_or(i64::MAX).saturating_mul(3) / 4;
        let apart = delay.checked_div(places).unwrap_or(0).unsigned_abs();
        if self.frames.iter().flatten().any(|stored| stored.sent.abs_diff(sent) < apart) {
            self.counts.thinned = self.counts.thinned.saturating_add(1);
            return Ok(());
        }
        let place = self.place();
        if let Some(place) = self.frames.get_mut(place) {
            if place.is_some() {
                self.counts.thinned = self.counts.thinned.saturating_add(1);
            }
            let mut q = [0.0; N];
            if let Some(q) = q.get_mut(..self.len) {
                q.copy_from_slice(&frame.q);
            }
            *place = Some(Stored { sent, q });
        }
        Ok(())
    }

    /// Returns an empty place. If there is none, returns the place of the frame whose neighbours are nearest to
    /// each other. The oldest frame, which is being played, and the newest are kept. O(`FRAMES`), and O(`FRAMES`²)
    /// without an empty place.
    fn place(&self) -> usize {
        if let Some(empty) = self.frames.iter().position(Option::is_none) {
            return empty;
        }
        let sent = || self.frames.iter().flatten().map(|stored| stored.sent);
        let between = |own: i64| {
            let before = sent().filter(|other| *other < own).max()?;
            let after = sent().filter(|other| *other > own).min()?;
            Some(after.saturating_sub(before))
        };
        let least = sent().enumerate().min_by_key(|(_, own)| between(*own).unwrap_or(i64::MAX));
        least.map_or(0, |(place, _)| place)
    }

    /// Moves the target towards the pose that is due, and returns its source, and whether a speed limit applied.
    fn follow(&mut self, now: i64) -> (Following, bool) {
        let nothing = if self.stale { Following::Stale } else { Following::Waiting };
        let Some(timeline) = &mut self.timeline else { return (nothing, false) };
        let play = timeline.step(now);
        let stored = || self.frames.iter().flatten();
        let before = stored().filter(|frame| frame.sent <= play).max_by_key(|frame| frame.sent);
        let after = stored().filter(|frame| frame.sent > play).min_by_key(|frame| frame.sent);
        let Some(a) = before else { return (nothing, false) };
        let (b, part, following) = match after {
            Some(b) => {
                let whole = b.sent.saturating_sub(a.sent);
                let gone = play.saturating_sub(a.sent);
                (b, gone as f32 / whole as f32, Following::Interpolated)
            }
            None => (a, 0.0, Following::Held),
        };
        if following == Following::Held {
            self.counts.held = self.counts.held.saturating_add(1);
        }
        let mut limited = false;
        let mut first = 0_usize;
        for joint in &self.coordinates {
            let end = first.saturating_add(joint.len());
            let range = first..end;
            first = end;
            let (Some(target), Some(a), Some(b)) =
                (self.target.get_mut(range.clone()), a.q.get(range.clone()), b.q.get(range))
            else {
                break;
            };
            limited |= joint.follow(target, (a, b), part, self.settings.tick_s);
        }
        // Frames before `a` are not played again.
        let over = a.sent;
        for place in &mut self.frames {
            if place.is_some_and(|stored| stored.sent < over) {
                *place = None;
            }
        }
        (following, limited)
    }

    fn forget(&mut self) {
        self.frames = [None; FRAMES];
        self.timeline = None;
    }
}

/// Converts microseconds of the board's clock, which starts with the board.
fn time(now_us: u64) -> i64 {
    i64::try_from(now_us).unwrap_or(i64::MAX)
}
