//! The sender's clock, as far as frames with jitter tell it.

/// How far the time of a frame may be off what is expected, us.
const PLAUSIBLE_US: i64 = 1_000_000;

/// The clocks of two machines differ by less than 1 part in 1024.
const DRIFT_BITS: u32 = 10;

/// Playing goes faster or slower by at most 1/8 to keep its delay.
const HURRY_BITS: u32 = 3;

/// When a pose of the sender is due here. All in us.
///
/// The frame that was least delayed says how the clocks stand to each other. That is a lower bound, which is left to
/// rise slowly, so that clocks may drift.
#[derive(Debug, Clone)]
pub(super) struct Timeline {
    /// Arrival less sending of the fastest frame, at `offset_at`.
    offset: i64,
    offset_at: i64,
    /// The sender's time of the newest frame.
    newest_sent: i64,
    /// When it came.
    newest_at: i64,
    /// The sender's time of the pose that is played now.
    play: i64,
    stepped_at: i64,
    delay: i64,
}

impl Timeline {
    /// Begins with a first frame.
    pub(super) fn new(sent_us: u32, now: i64, delay: i64) -> Self {
        let sent = i64::from(sent_us);
        Self {
            offset: now.saturating_sub(sent),
            offset_at: now,
            newest_sent: sent,
            newest_at: now,
            play: sent.saturating_sub(delay),
            stepped_at: now,
            delay,
        }
    }

    /// The sender's time of a frame without the jumps of its counter; none if it is not plausible.
    pub(super) fn sent(&self, sent_us: u32, now: i64) -> Option<i64> {
        let expected = now.saturating_sub(self.offset(now));
        let low = u32::try_from(expected & i64::from(u32::MAX)).unwrap_or(0);
        let off = i64::from(sent_us.wrapping_sub(low).cast_signed());
        (off.abs() <= PLAUSIBLE_US).then(|| expected.saturating_add(off))
    }

    /// Learns from a frame.
    pub(super) fn arrive(&mut self, sent: i64, now: i64) {
        let offset = now.saturating_sub(sent);
        if offset <= self.offset(now) {
            self.offset = offset;
            self.offset_at = now;
        }
        if sent > self.newest_sent {
            self.newest_sent = sent;
            self.newest_at = now;
        }
    }

    /// Goes on to now, and returns the sender's time of the pose to play.
    pub(super) fn step(&mut self, now: i64) -> i64 {
        let elapsed = now.saturating_sub(self.stepped_at).max(0);
        self.stepped_at = now;
        let due = now.saturating_sub(self.offset(now)).saturating_sub(self.delay);
        let steady = self.play.saturating_add(elapsed);
        let hurry = elapsed >> HURRY_BITS;
        let error = due.saturating_sub(steady).clamp(hurry.saturating_neg(), hurry);
        self.play = steady.saturating_add(error);
        self.play
    }

    /// The sender's time of the pose that is played now.
    pub(super) fn play(&self) -> i64 {
        self.play
    }

    /// How long ago the newest frame came.
    pub(super) fn age(&self, now: i64) -> i64 {
        now.saturating_sub(self.newest_at).max(0)
    }

    fn offset(&self, now: i64) -> i64 {
        let since = now.saturating_sub(self.offset_at).max(0);
        self.offset.saturating_add(since >> DRIFT_BITS)
    }
}
