//! Messages to pages: which page drives, events, and frames.

use std::time::Duration;

use sinew_board_client::Line;
use sinew_firmware::supervisor::Fault;
use sinew_link::message::{FaultRecord, Refusal, State};

use super::bound::Bound;
use super::idle::Idle;
use super::{Act, Hub, Page, Refused};
use crate::frame::{self, Frame};
use crate::message::{Level, ToPage};
use crate::server::{Outbox, PageId, binary, text};

/// Time in which the other parts of a snapshot arrive after its summary.
const PARTS: Duration = Duration::from_millis(6);
/// Interval of frames while the board does not answer.
const IDLE: Duration = Duration::from_millis(200);

/// The state that pages were last told.
#[derive(Debug)]
pub(super) struct Told {
    summaries: u32,
    /// Time at which the last summary arrived.
    heard: Duration,
    due: Option<Duration>,
    last: Duration,
    state: Option<State>,
    /// Number of summaries before the stop at the end of the program. Only newer ones show whether torque is off.
    pub(super) before: u32,
}

impl Told {
    pub(super) fn new(now: Duration) -> Self {
        Self { summaries: 0, heard: now, due: None, last: now, state: None, before: 0 }
    }
}

impl<L: Line> Hub<'_, L> {
    pub(super) fn join(&mut self, page: PageId, out: Outbox, may_drive: bool) {
        out.send(&text(self.scene.head(self.line_rate_hz)));
        out.send(&text(self.shows_json()));
        self.pages.insert(page, Page { out, may_drive });
        let now = self.now();
        if may_drive && self.wheel.is_free() {
            self.wheel.take(page, now);
            self.bound = Bound::default();
        }
        self.tell_roles();
        self.tell_page(page, &ToPage::Record { file: self.recorded() });
    }

    pub(super) fn tell_heads(&mut self) {
        let head = text(self.scene.head(self.line_rate_hz));
        self.pages.values().for_each(|page| page.out.send(&head));
        self.tell_shows();
    }

    pub(super) fn tell_shows(&mut self) {
        self.tell_all(&self.shows_json());
    }

    fn shows_json(&self) -> String {
        self.shows.json(self.idle.as_ref().map(Idle::state))
    }

    pub(super) fn tell_all(&self, json: &str) {
        let frame = text(json.to_owned());
        self.pages.values().for_each(|page| page.out.send(&frame));
    }

    /// Tells each page whether it drives.
    pub(super) fn tell_roles(&self) {
        for (id, page) in &self.pages {
            let driver = self.wheel.is_at(*id);
            let other = match (self.is_commanded(), driver, self.wheel.is_free()) {
                (true, ..) => Some("command"),
                (false, false, false) => Some("page"),
                _ => None,
            };
            let asked = driver && self.wheel.is_asked(self.now());
            page.out.send(&text(ToPage::Role { driver, other, asked }.json()));
        }
    }

    pub(super) fn tell_page(&self, page: PageId, message: &ToPage<'_>) {
        if let Some(page) = self.pages.get(&page) {
            page.out.send(&text(message.json()));
        }
    }

    pub(super) fn answer(&self, page: PageId, id: u64, answer: Result<String, Refused>) {
        let (ok, text) = match answer {
            Ok(text) => (true, text),
            Err(refused) => (false, format!("refused: {}", self.text(&refused))),
        };
        self.tell_page(page, &ToPage::Answer { id, ok, text: &text });
    }

    /// Returns the reason for a refusal in words, with the name of the joint, or the remedy of the fault.
    pub(super) fn text(&self, refused: &Refused) -> String {
        let refusal = match refused {
            Refused::Other(text) => return text.clone(),
            Refused::Board(refusal) => refusal,
        };
        let joint = match refusal {
            Refusal::Moving { dof, .. }
            | Refusal::Overload { dof, .. }
            | Refusal::Supply { dof, .. } => self
                .scene
                .dofs
                .get(usize::from(*dof))
                .map(|own| format!(" (joint {dof} is {})", own.name)),
            Refusal::RegisterDiffers { servo, .. } => {
                self.joint(*servo).map(|name| format!(" (servo {servo} moves {name})"))
            }
            Refusal::Fault(fault) | Refusal::StillThere(fault) | Refusal::NeedsUpload(fault) => {
                fault_of(*fault).map(|fault| format!(" ({fault}; to do: {})", fault.remedy()))
            }
            _ => None,
        };
        format!("{refusal}{}", joint.unwrap_or_default())
    }

    fn joint(&self, servo: u16) -> Option<&str> {
        self.scene.joints.get(usize::from(servo))?.as_deref()
    }

    pub(super) fn event(&self, level: Level, text: &str) {
        let t = self.now().as_secs_f64();
        self.tell_all(&ToPage::Event { t, level, text, fault: None, joint: None }.json());
    }

    fn tell_fault(&self, record: &FaultRecord) {
        let level = if record.is_warning() { Level::Warning } else { Level::Fault };
        let words = fault_of(record.fault).map_or_else(
            || format!("fault {}", record.fault),
            |fault| format!("{fault}: {}; to do: {}", fault.when(), fault.remedy()),
        );
        let joint = record.servo.and_then(|servo| self.joint(servo));
        let (t, fault) = (self.now().as_secs_f64(), Some(record.fault));
        self.tell_all(&ToPage::Event { t, level, text: &words, fault, joint }.json());
    }

    /// Reports new faults and states to pages, and sends them a frame for each snapshot.
    pub(super) fn tell(&mut self) {
        let faults = std::mem::take(&mut self.board.log.faults);
        for record in &faults {
            self.tell_fault(record);
        }
        self.watchers.tell(self.board, &faults);
        if let Some(record) = &mut self.record {
            record.hear(&faults);
        }
        if let Some(state) = self.board.state()
            && self.told.state.replace(state) != Some(state)
        {
            self.event(Level::Info, &state.to_string());
        }
        let now = self.now();
        if std::mem::replace(&mut self.told.summaries, self.board.log.summaries)
            != self.board.log.summaries
        {
            self.told.heard = now;
            self.told.due.get_or_insert(now + PARTS);
        }
        let is_idle = self.lost.is_some() && now.saturating_sub(self.told.last) >= IDLE;
        if self.told.due.is_some_and(|due| now >= due) || is_idle {
            (self.told.due, self.told.last) = (None, now);
            if !self.pages.is_empty() {
                self.tell_frame();
            }
        }
    }

    fn tell_frame(&self) {
        let log = &self.board.log;
        let Some(summary) = log.summary else { return };
        let playing = match &self.act {
            Some(Act::Show(playing)) => Some(playing),
            _ => None,
        };
        let mut flags = if self.lost.is_some() { frame::LOST } else { 0 };
        flags |= if matches!(self.act, Some(Act::Slider(_))) { frame::JOGS } else { 0 };
        flags |=
            if playing.is_some() && summary.state == State::Playing { frame::PLAYS } else { 0 };
        let frame = Frame {
            state: summary.state.number(),
            fault: summary.fault,
            flags,
            t_s: self.now().as_secs_f32(),
            place_s: playing.map(|playing| playing.place_s(log, [self.told.heard, self.now()])),
            supply_v: summary.supply_v,
            tick_us: summary.tick_us,
            counts: self.scene.counts(),
            measured: &log.q,
            wanted: &self.scene.commanded(log).unwrap_or_default(),
            ghost: self.ghost.as_deref(),
            dofs: &log.dofs,
            servos: &log.servos,
            supplies: &log.supplies,
        };
        let frame = binary(frame.bytes());
        self.pages.values().for_each(|page| page.out.send(&frame));
    }
}

fn fault_of(number: u8) -> Option<Fault> {
    Fault::ALL.into_iter().find(|fault| fault.number() == number)
}
