//! Estimates the sender's clock from frames with jitter.

/// Maximum deviation of a frame's time from the expected time, us.
const PLAUSIBLE_US: i64 = 1_000_000;

/// Bound of clock drift, as a shift: the speeds of two machines' clocks differ by less than 1 part in 1024.
const DRIFT_BITS: u32 = 10;

/// Maximum change of the playing speed that restores the delay, as a shift: 1/8.
const HURRY_BITS: u32 = 3;

/// Converts the sender's clock to the receiver's, to compute when a pose is due. All times are in us.
///
/// The offset between the clocks is the smallest difference of a frame's arrival and sending time. It rises slowly, to
/// allow for drift, until a frame has a smaller difference.
#[derive(Debug, Clone)]
pub(super) struct Timeline {
    /// Arrival minus sending time of the fastest frame, which arrived at `offset_at`.
    offset: i64,
    offset_at: i64,
    /// Sender's time of the newest frame.
    newest_sent: i64,
    /// Receiver's time at which the newest frame arrived.
    newest_at: i64,
    /// Sender's time of the pose that is being played.
    play: i64,
    stepped_at: i64,
    delay: i64,
}

impl Timeline {
    /// Starts with a first frame.
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

    /// Returns a frame's sending time without the wraps of its counter; `None` if it is implausible.
    pub(super) fn sent(&self, sent_us: u32, now: i64) -> Option<i64> {
        let expected = now.saturating_sub(self.offset(now));
        let low = u32::try_from(expected & i64::from(u32::MAX)).unwrap_or(0);
        let off = i64::from(sent_us.wrapping_sub(low).cast_signed());
        (off.abs() <= PLAUSIBLE_US).then(|| expected.saturating_add(off))
    }

    /// Updates the estimate from a frame.
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

    /// Advances to now, and returns the sender's time of the pose to play.
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

    /// Returns the sender's time of the pose that is being played.
    pub(super) fn play(&self) -> i64 {
        self.play
    }

    /// Returns the time since the newest frame arrived.
    pub(super) fn age(&self, now: i64) -> i64 {
        now.saturating_sub(self.newest_at).max(0)
    }

    fn offset(&self, now: i64) -> i64 {
        let since = now.saturating_sub(self.offset_at).max(0);
        self.offset.saturating_add(since >> DRIFT_BITS)
    }
}
