//! Time code: the time on a production's clock.

use crate::position::Rate;

/// Time code as defined in SMPTE ST 12-1: the time on a production's clock at the start of a show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeCode {
    /// Hours, 0 to 23.
    pub hours: u8,
    /// Minutes, 0 to 59.
    pub minutes: u8,
    /// Seconds, 0 to 59.
    pub seconds: u8,
    /// Frame number, below `frames_per_second`.
    pub frames: u8,
    /// Number of frames per counted second: 24, 25, 30, 50 or 60.
    pub frames_per_second: u8,
    /// Speed of counting.
    pub kind: TimeCodeKind,
}

/// Speed at which a time code counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeCodeKind {
    /// Exactly `frames_per_second` frames per second.
    Whole,
    /// Slower by 1000/1001.
    Slow,
    /// Slower by 1000/1001, with some numbers skipped to stay with the clock (drop frame).
    Drop,
}

impl TimeCode {
    /// Reads the field of a show. Returns `None` if the show has no time code (0 frames per second), or an invalid one.
    pub(crate) fn read(raw: [u8; 6]) -> Option<Self> {
        let [hours, minutes, seconds, frames, frames_per_second, kind] = raw;
        let kind = match kind {
            0 => TimeCodeKind::Whole,
            1 => TimeCodeKind::Slow,
            2 => TimeCodeKind::Drop,
            _ => return None,
        };
        let code = Self { hours, minutes, seconds, frames, frames_per_second, kind };
        code.is_time().then_some(code)
    }

    #[cfg(feature = "std")]
    pub(crate) fn write(code: Option<Self>) -> [u8; 6] {
        code.map_or([0; 6], |c| {
            [c.hours, c.minutes, c.seconds, c.frames, c.frames_per_second, c.kind as u8]
        })
    }

    /// Returns `true` if a clock can show this time code.
    pub fn is_time(&self) -> bool {
        let counts = matches!(self.frames_per_second, 24 | 25 | 30 | 50 | 60);
        // Drop frame exists for 29.97 and 59.94 frames per second; it skips the first numbers of most minutes.
        let drops = self.kind == TimeCodeKind::Drop;
        let left_out = drops
            && !self.minutes.is_multiple_of(10)
            && self.seconds == 0
            && self.frames < self.frames_per_second / 15;
        counts
            && self.hours < 24
            && self.minutes < 60
            && self.seconds < 60
            && self.frames < self.frames_per_second
            && (!drops || matches!(self.frames_per_second, 30 | 60))
            && !left_out
    }

    /// Returns the time code a number of frames later; after 24 hours it wraps to 0. `self` must be a
    /// [time](Self::is_time). SMPTE ST 12-1, section 5: drop frame skips 2 numbers (for 60: 4) in each minute except
    /// every tenth.
    #[must_use]
    pub fn after(self, frames: u64) -> Self {
        let fps = u64::from(self.frames_per_second).max(1);
        let dropped = if self.kind == TimeCodeKind::Drop { fps / 15 } else { 0 };
        let minute = fps.wrapping_mul(60).wrapping_sub(dropped).max(1);
        let ten_minutes = minute.wrapping_mul(10).wrapping_add(dropped);
        let minutes = u64::from(self.hours).wrapping_mul(60).wrapping_add(self.minutes.into());
        // Frames since midnight: all numbers, without the skipped ones.
        let seconds = minutes.wrapping_mul(60).wrapping_add(self.seconds.into());
        let left_out = dropped.wrapping_mul(minutes.wrapping_sub(minutes / 10));
        let now = seconds.wrapping_mul(fps).wrapping_add(self.frames.into()).wrapping_sub(left_out);
        let day = ten_minutes.wrapping_mul(144);
        let then = now.wrapping_add(frames).checked_rem(day).unwrap_or(0);
        // The inverse: the first minute of ten has all its numbers.
        let (tens, rest) = (part(then, ten_minutes), then.checked_rem(ten_minutes).unwrap_or(0));
        let short_minutes = part(rest.saturating_sub(dropped), minute);
        let left_out = dropped.wrapping_mul(tens.wrapping_mul(9).wrapping_add(short_minutes));
        let number = then.wrapping_add(left_out);
        let seconds = part(number, fps);
        let below = |value: u64, most: u64| u8::try_from(value.checked_rem(most).unwrap_or(0));
        Self {
            hours: below(seconds / 3600, 24).unwrap_or(0),
            minutes: below(seconds / 60, 60).unwrap_or(0),
            seconds: below(seconds, 60).unwrap_or(0),
            frames: below(number, fps).unwrap_or(0),
            ..self
        }
    }

    /// Returns the number of whole frames in a number of samples.
    pub(crate) fn frames_in(self, samples: u32, rate: Rate) -> u64 {
        let (count, per) = match self.kind {
            TimeCodeKind::Whole => (1, 1),
            TimeCodeKind::Slow | TimeCodeKind::Drop => (1000, 1001),
        };
        // At most 2^31 samples of 4095 s, 60 frames, 1000: below 2^59.
        let frames = [rate.seconds.into(), u64::from(self.frames_per_second), count];
        let frames = frames.into_iter().fold(u64::from(samples), u64::wrapping_mul);
        part(frames, u64::from(rate.samples).wrapping_mul(per))
    }
}

/// Returns the whole part of a quotient; 0 for a divisor of 0.
fn part(number: u64, of: u64) -> u64 {
    number.checked_div(of).unwrap_or(0)
}

#[cfg(all(test, feature = "std"))]
mod tests {
    use super::*;

    fn code(text: [u8; 4], frames_per_second: u8, kind: TimeCodeKind) -> TimeCode {
        let [hours, minutes, seconds, frames] = text;
        TimeCode { hours, minutes, seconds, frames, frames_per_second, kind }
    }

    #[test]
    fn each_frame_shows_the_next_number_that_is_a_time() {
        let kinds = [(25, TimeCodeKind::Whole), (24, TimeCodeKind::Slow)];
        for (fps, kind) in kinds.into_iter().chain([30, 60].map(|fps| (fps, TimeCodeKind::Drop))) {
            let first = code([22, 59, 50, 0], fps, kind);
            let mut now = first;
            // Two hours, which include ten-minute marks and midnight.
            for frame in 1..u64::from(fps) * 7_200 {
                let next = now.after(1);
                assert!(next.is_time() && next == first.after(frame), "{now:?} {next:?}");
                let follows = next.frames == now.frames + 1 && next.seconds == now.seconds;
                let wraps = now.frames + 1 == fps && next.seconds == (now.seconds + 1) % 60;
                let is_dropped = kind == TimeCodeKind::Drop
                    && next.seconds == 0
                    && !next.minutes.is_multiple_of(10);
                let first_number = if is_dropped { fps / 15 } else { 0 };
                assert!(follows || (wraps && next.frames == first_number), "{now:?} {next:?}");
                now = next;
            }
        }
    }

    #[test]
    fn drop_frame_keeps_with_the_clock() {
        // An hour of 29.97 Hz has 107,892 frames and shows an hour; without drops, 3.6 s less.
        let midnight = code([0; 4], 30, TimeCodeKind::Drop);
        let rate = Rate { samples: 120, seconds: 1 };
        assert_eq!(midnight.frames_in(120 * 3_600, rate), 107_892);
        assert_eq!(midnight.after(107_892), code([1, 0, 0, 0], 30, TimeCodeKind::Drop));
        let slow = code([0; 4], 30, TimeCodeKind::Slow);
        assert_eq!(slow.after(107_892), code([0, 59, 56, 12], 30, TimeCodeKind::Slow));
    }
}
