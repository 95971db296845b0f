//! Telemetry at the rate that the host has chosen.

use sinew_link::message::{Snapshot, TelemetryParts, TelemetrySetting, ToHost};

use super::mail::{Mail, Shared, Tick};
use super::outbox::Outbox;

/// Asks the loop for snapshots, and sends them frame by frame, as long as the line has room.
#[derive(Debug)]
pub(super) struct Telemeter<const DOFS: usize, const SERVOS: usize, const COORDS: usize> {
    setting: TelemetrySetting,
    due_us: u64,
    sending: Option<(Tick<DOFS, SERVOS, COORDS>, usize)>,
    seq: u16,
}

impl<const DOFS: usize, const SERVOS: usize, const COORDS: usize> Telemeter<DOFS, SERVOS, COORDS> {
    /// None is sent.
    pub(super) const fn new() -> Self {
        let setting = TelemetrySetting { rate_hz: 0.0, parts: TelemetryParts(0) };
        Self { setting, due_us: 0, sending: None, seq: 0 }
    }

    /// The next snapshot is due at once, however slow they were.
    pub(super) fn set(&mut self, setting: TelemetrySetting) {
        (self.setting, self.due_us) = (setting, 0);
    }

    /// `damaged`, `lost`: frames of the host.
    #[inline(never)]
    pub(super) fn step<'a>(
        &mut self,
        now_us: u64,
        mail: &impl Shared<Mail<'a, DOFS, SERVOS, COORDS>>,
        (damaged, lost): (u32, u32),
        outbox: &mut Outbox,
    ) {
        let TelemetrySetting { rate_hz, parts } = self.setting;
        if rate_hz > 0.0 && now_us >= self.due_us && self.sending.is_none() {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "it saturates"
            )]
            let period_us = (1e6 / rate_hz) as u64;
            // Without drift, but what was missed is not made up for.
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
