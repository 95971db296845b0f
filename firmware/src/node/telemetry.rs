//! Telemetry at the rate that the host has chosen.

use sinew_link::message::{Snapshot, TELEMETRY_LEAST_HZ, TelemetryParts, TelemetrySetting, ToHost};

use super::mail::{Mail, Shared, Tick};
use super::outbox::Outbox;

/// Requests snapshots from the loop, and sends them frame by frame as long as the line has room. Detects whether the
/// host acknowledges them.
#[derive(Debug)]
pub(super) struct Telemeter<const DOFS: usize, const SERVOS: usize, const COORDS: usize> {
    setting: TelemetrySetting,
    due_us: u64,
    sending: Option<(Tick<DOFS, SERVOS, COORDS>, usize)>,
    seq: u16,
    /// Sequence number after the newest frame that the host has acknowledged.
    heard: u16,
    /// Time of the last message that acknowledged a new frame, or that arrived when all frames were acknowledged or
    /// after a long silence, µs. `spoke_us` is the time of the host's last message. Only differences of these times are
    /// used.
    heard_us: u32,
    spoke_us: u32,
}

impl<const DOFS: usize, const SERVOS: usize, const COORDS: usize> Telemeter<DOFS, SERVOS, COORDS> {
    /// Creates a telemeter that sends nothing.
    pub(super) const fn new() -> Self {
        let setting = TelemetrySetting { rate_hz: 0.0, parts: TelemetryParts(0) };
        Self { setting, due_us: 0, sending: None, seq: 0, heard: 0, heard_us: 0, spoke_us: 0 }
    }

    /// Sets rate and parts. The next snapshot is due at once, even if the rate was low before.
    pub(super) fn set(&mut self, setting: TelemetrySetting) {
        (self.setting, self.due_us) = (setting, 0);
    }

    /// Handles a fresh message of the host, with the number of the newest frame that it has received. Returns whether
    /// the host is deaf: it keeps sending, but for `limit_us` it has acknowledged no new frame, although there were
    /// frames to acknowledge.
    pub(super) fn hear(&mut self, heard: Option<u16>, now_us: u64, limit_us: u32) -> bool {
        #[expect(clippy::cast_possible_truncation, reason = "differences count, of seconds")]
        let now_us = now_us as u32;
        let was_silent = now_us.wrapping_sub(self.spoke_us) >= limit_us;
        self.spoke_us = now_us;
        let behind = heard.map_or(self.heard, |number| number.wrapping_add(1));
        // A number that was not sent since the last accepted number is ignored.
        let is_new = self.seq.wrapping_sub(behind) < self.seq.wrapping_sub(self.heard);
        if is_new {
            self.heard = behind;
        }
        if is_new || was_silent || self.heard == self.seq {
            self.heard_us = now_us;
        }
        now_us.wrapping_sub(self.heard_us) >= limit_us
    }

    /// Advances telemetry by a step. `damaged` and `lost` count frames of the host; `acknowledges` is whether the
    /// host reports the frames that it has received.
    #[inline(never)]
    pub(super) fn step<'a>(
        &mut self,
        now_us: u64,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
        (damaged, lost): (u32, u32),
        acknowledges: bool,
        outbox: &mut Outbox,
    ) {
        let TelemetrySetting { mut rate_hz, mut parts } = self.setting;
        if acknowledges && rate_hz < TELEMETRY_LEAST_HZ && mail.with(|mail| mail.state.is_on()) {
            (rate_hz, parts) = (TELEMETRY_LEAST_HZ, parts.and(TelemetryParts::SUMMARY));
            // With a slower rate the next snapshot may be due later than this.
            self.due_us = self.due_us.min(now_us.saturating_add(200_000));
        }
        if rate_hz > 0.0 && now_us >= self.due_us && self.sending.is_none() {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "it saturates"
            )]
            let period_us = (1e6 / rate_hz) as u64;
            // The period does not drift, but missed snapshots are not repeated.
            self.due_us = self.due_us.saturating_add(period_us).max(now_us);
            mail.with(|mail| mail.wants_snapshot = true);
        }
        if self.sending.is_none() {
            self.sending = mail.with(|mail| mail.snapshot.take()).map(|tick| (tick, 0));
        }
        while outbox.has_room()
            && let Some((tick, index)) = &mut self.sending
        {
            tick.summary.link_damaged = damaged;
            tick.summary.link_lost = lost;
            let Tick { number, summary, q, dofs, servos } = &*tick;
            let snapshot = Snapshot { tick: *number, summary, q, dofs, servos };
            match snapshot.frame(parts, *index, self.seq) {
                Some(frame) => {
                    outbox.put(&ToHost::Telemetry(frame));
                    self.seq = self.seq.wrapping_add(1);
                    *index = index.saturating_add(1);
                }
                None => self.sending = None,
            }
        }
    }
}
