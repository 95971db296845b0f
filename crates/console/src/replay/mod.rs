//! A recording instead of a board: pages show it, seek in it, and play it. They cannot command anything.

mod frames;

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

pub use frames::{Replay, ReplayError};

use crate::message::{Level, PageCommand, Slot, ToPage};
use crate::scene::Scene;
use crate::server::{Outbox, PageId, ToHub, binary, text};

/// Interval between two frames.
const EVERY: Duration = Duration::from_millis(33);
/// Maximum number of events that a page receives when it connects.
const EVENTS_MAX: usize = 200;

/// Player of a recording. All pages show the same moment.
pub(crate) struct Player<'a> {
    replay: &'a Replay,
    scene: &'a Scene,
    name: &'a str,
    pages: BTreeMap<PageId, Outbox>,
    begun: Instant,
    place_s: f64,
    /// Start of playing: time, and place in the recording, s. `None` while the recording is paused.
    runs: Option<(Instant, f64)>,
    repeats: bool,
}

impl<'a> Player<'a> {
    pub(crate) fn new(replay: &'a Replay, scene: &'a Scene, name: &'a str) -> Self {
        let (pages, begun) = (BTreeMap::new(), Instant::now());
        Self { replay, scene, name, pages, begun, place_s: 0.0, runs: None, repeats: false }
    }

    /// Serves pages until `stops` counts a signal.
    pub(crate) fn run(mut self, inbox: &Receiver<ToHub>, stops: &dyn Fn() -> u32) {
        let mut due = Instant::now();
        while stops() == 0 {
            match inbox.recv_timeout(due.saturating_duration_since(Instant::now())) {
                Ok(message) => self.take(message),
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => {}
            }
            if Instant::now() >= due {
                due = Instant::now() + EVERY;
                self.go_on();
                self.tell();
            }
        }
    }

    fn take(&mut self, message: ToHub) {
        match message {
            ToHub::Joined { page, out, .. } => self.join(page, out),
            ToHub::Left { page } => {
                self.pages.remove(&page);
            }
            ToHub::Said { page, message } => {
                let answer = match message.command {
                    PageCommand::Ping { t } => return self.say(page, &ToPage::Pong { t }),
                    command => self.obey(&command),
                };
                if let Some(id) = message.id {
                    let (ok, text) = (answer.is_ok(), answer.unwrap_or_else(|why| why));
                    self.say(page, &ToPage::Answer { id, ok, text });
                }
            }
            ToHub::Content { .. }
            | ToHub::Asked { .. }
            | ToHub::Watches { .. }
            | ToHub::Gone { .. } => {}
        }
    }

    fn join(&mut self, page: PageId, out: Outbox) {
        out.send(&text(self.scene.head(self.replay.rate_hz)));
        #[expect(clippy::cast_possible_truncation, reason = "a message has f32")]
        let duration_s = Some(self.replay.duration_s as f32);
        let slot = Slot {
            index: 0,
            name: self.name.to_owned(),
            hash: None,
            duration_s,
            cues: Vec::new(),
            sound: None,
        };
        out.send(&text(ToPage::Shows { slots: &[slot], loaded: Some(0), idle: None }.json()));
        out.send(&text(ToPage::Role { driver: false, other: None, asked: false }.json()));
        for (t, words) in self.replay.events.iter().take(EVENTS_MAX) {
            out.send(&text(event(*t, words)));
        }
        self.pages.insert(page, out);
    }

    fn say(&self, page: PageId, message: &ToPage<'_>) {
        if let Some(page) = self.pages.get(&page) {
            page.send(&text(message.json()));
        }
    }

    fn obey(&mut self, command: &PageCommand) -> Result<&'static str, &'static str> {
        match command {
            PageCommand::Hello { .. } => {}
            PageCommand::Hold => self.runs = None,
            PageCommand::Play { is_loop, .. } => {
                if self.place_s >= self.replay.duration_s {
                    self.place_s = 0.0;
                }
                self.repeats = *is_loop;
                self.runs = Some((Instant::now(), self.place_s));
            }
            PageCommand::Seek { t, .. } => {
                let t = t.filter(|t| t.is_finite()).unwrap_or(self.place_s);
                self.place_s = t.clamp(0.0, self.replay.duration_s);
                self.runs = self.runs.map(|_| (Instant::now(), self.place_s));
            }
            _ => return Err("refused: a recording has no commands"),
        }
        Ok("")
    }

    /// Moves the place in a recording that plays.
    fn go_on(&mut self) {
        let Some((since, from_s)) = self.runs else { return };
        self.place_s = from_s + since.elapsed().as_secs_f64();
        if self.place_s < self.replay.duration_s {
            return;
        }
        if self.repeats && self.replay.duration_s > 0.0 {
            self.place_s = 0.0;
            self.runs = Some((Instant::now(), 0.0));
        } else {
            self.place_s = self.replay.duration_s;
            self.runs = None;
        }
    }

    fn tell(&self) {
        if self.pages.is_empty() {
            return;
        }
        let t_s = self.begun.elapsed().as_secs_f32();
        let frame = self.replay.frame(self.scene, t_s, self.place_s, self.runs.is_some());
        let frame = binary(frame);
        self.pages.values().for_each(|page| page.send(&frame));
    }
}

/// Returns the message for a fault or for a change of the state in a recording.
fn event(t: f64, words: &str) -> String {
    let level = match words.split(' ').next() {
        Some("warning") => Level::Warning,
        Some("fault") => Level::Fault,
        _ => Level::Info,
    };
    ToPage::Event { t, level, text: words, fault: None, joint: None }.json()
}
