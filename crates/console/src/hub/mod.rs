//! The hub: one thread that alone owns the session with the board, and answers all pages.
//!
//! - `wheel`: the page that drives. `commands`: requests of pages. `act`: activities that last: arming, a slider, a
//!   journey, a show.
//! - `bound`: holds and stops of others, which bind a program. `slider`: motions, to which the caller gives the time.
//! - `shows`: slots and ghosts. `upload`: a show on its way to the board.
//! - `idle`: idle life between shows.
//! - `tell`: messages to pages. `local`: requests of other terminals of this user. `watchers`: terminals that watch.
//! - `hosted`: a command without pages that is the hub of its board. `session_record`: a recording of the session.

mod act;
mod bound;
mod commands;
mod hosted;
mod idle;
mod local;
mod session_record;
mod shows;
mod slider;
mod tell;
mod upload;
mod watchers;
mod wheel;

use std::collections::BTreeMap;
use std::sync::mpsc::Receiver;
use std::time::Duration;

use sinew_board_client::{Board, ClientError, Line};
use sinew_firmware::node::SETTING_NAMES;
use sinew_firmware::supervisor::SOFT_MOST_RAD_S;
use sinew_link::message::{Applied, Command, Refusal, State, TelemetryParts};

use crate::message::{Level, PageCommand};
use crate::scene::Scene;
use crate::server::{Outbox, PageId, ToHub};
use act::{Act, Arming};
use bound::Bound;
use idle::Idle;
use local::{Asked, Waiting};
use session_record::SessionRecord;
use shows::Shows;
use tell::Told;
use upload::Upload;
use watchers::Watchers;
use wheel::Wheel;

pub use hosted::Hosted;
pub use idle::idle_life;
pub use local::Owner;
pub use session_record::{BeginRecord, NewRecord, RECORD_HZ, Records};
pub use shows::{OwnShow, OwnShows};

/// Snapshots per second that the hub requests from the board.
pub(crate) const RATE_HZ: f32 = 30.0;
/// Longest wait for the board in a turn of the hub; a page's message may wait as long.
const TURN: Duration = Duration::from_millis(4);
/// Maximum number of messages of pages in a turn, so that the board does not wait longer for them.
const MESSAGES: usize = 32;
/// Interval of attempts to reach a board that does not answer, and the duration of an attempt.
const AGAIN: Duration = Duration::from_millis(500);
const PATIENCE: Duration = Duration::from_millis(200);
/// Maximum time from the stop at the end of the program until torque is off. After it, the hub ends.
const STOP_MOST: Duration = Duration::from_mins(1);

/// The way in which a hub ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// Torque is off.
    Stopped,
    /// Torque may be on: the hub ended by a second signal, because the board does not answer, or after a minute. The
    /// board lowers the rig on its own.
    AtOnce,
}

/// A page that has shown the token.
#[derive(Debug)]
struct Page {
    out: Outbox,
    may_drive: bool,
}

#[derive(Debug)]
pub(crate) struct Hub<'a, L> {
    board: &'a mut Board<L>,
    scene: &'a Scene,
    owner: Owner,
    inbox: Receiver<ToHub>,
    is_unattended: bool,
    pages: BTreeMap<PageId, Page>,
    wheel: Wheel,
    act: Option<Act>,
    arming: Option<Arming>,
    shows: Shows,
    /// Idle life between shows; `None` if the console has none.
    idle: Option<Idle>,
    upload: Option<Upload>,
    ghost: Option<Vec<f32>>,
    /// Maximum speed of a slider, rad/s or m/s.
    soft_rad_s: f32,
    line_rate_hz: f32,
    /// Time of the next attempt to reach the board; `None` while the board answers.
    lost: Option<Duration>,
    /// An error after which the port can no longer be used.
    failed: Option<ClientError>,
    told: Told,
    /// Time at which the rig is lowered, because no page drives or the driver is silent.
    lower_at: Option<Duration>,
    /// Time of the last message of a slider that is still held although the rig was told to hold. The slider must be
    /// released before it moves the joint again.
    barred: Option<Duration>,
    bound: Bound,
    /// Command of another terminal whose motion goes on.
    waiting: Option<Waiting>,
    watchers: Watchers,
    record: Option<SessionRecord>,
    /// Recordings that may begin later.
    records: Records<'a>,
    asked: Asked,
    /// Where the last journey has ended; `None` if it was ended before.
    arrived: Option<Result<String, String>>,
    /// Time at which the rig was told to stop because the program ends.
    closing: Option<Duration>,
}

impl<'a, L: Line> Hub<'a, L> {
    pub(crate) fn new(
        board: &'a mut Board<L>,
        scene: &'a Scene,
        (owner, is_unattended): (Owner, bool),
        inbox: Receiver<ToHub>,
    ) -> Self {
        Self {
            told: Told::new(board.now()),
            board,
            scene,
            owner,
            inbox,
            is_unattended,
            pages: BTreeMap::new(),
            wheel: Wheel::default(),
            act: None,
            arming: None,
            shows: Shows::default(),
            idle: None,
            upload: None,
            ghost: None,
            soft_rad_s: SOFT_MOST_RAD_S,
            line_rate_hz: RATE_HZ,
            lost: None,
            failed: None,
            lower_at: None,
            barred: None,
            bound: Bound::default(),
            waiting: None,
            watchers: Watchers::default(),
            record: None,
            records: Records::default(),
            asked: Asked::default(),
            arrived: None,
            closing: None,
        }
    }

    /// Runs until the rig is stopped after a signal, or a second signal ends it.
    pub(crate) fn run(
        mut self,
        (own, records): (OwnShows, Records<'a>),
        stops: &dyn Fn() -> u32,
    ) -> Result<Ended, ClientError> {
        self.records = records;
        self.record = self.records.first.take().map(SessionRecord::new);
        self.begin()?;
        if let Some(idle) = &own.idle {
            let idle = Idle::new(idle, self.scene);
            self.idle = Some(idle.map_err(ClientError::Impatient)?);
        }
        for show in own.shows {
            self.put_own(show)?;
        }
        loop {
            let turned = self.turn();
            let ended = turned.map(|()| self.close(stops())).transpose();
            if let Some(ended) = ended {
                let _ = self.end_record(None);
                return ended;
            }
        }
    }

    /// Prepares a session: requests telemetry, reads the speed of sliders, and reads the slots.
    fn begin(&mut self) -> Result<(), ClientError> {
        let parts = TelemetryParts::ALL.and(TelemetryParts::TARGETS).and(TelemetryParts::SUPPLIES);
        let setting = self.board.telemetry(RATE_HZ, parts)?;
        self.line_rate_hz = setting.rate_hz;
        let key = SETTING_NAMES.iter().position(|name| *name == "soft_rad_s");
        let key = key.and_then(|place| u16::try_from(place + 1).ok()).unwrap_or_default();
        self.soft_rad_s = self.board.setting(key).unwrap_or(SOFT_MOST_RAD_S);
        self.read_slots()
    }

    /// Handles the waiting messages of pages and other commands.
    fn take_messages(&mut self) {
        for _ in 0..MESSAGES {
            let Ok(message) = self.inbox.try_recv() else { break };
            self.take(message);
        }
    }

    /// Handles waiting messages, receives from the board, and continues the present activity.
    ///
    /// # Errors
    /// The port has failed for good.
    fn turn(&mut self) -> Result<(), ClientError> {
        self.take_messages();
        if let Some(due) = self.lost {
            if self.board.now() >= due {
                self.find_again();
            } else {
                std::thread::sleep(TURN);
            }
        } else {
            if let Err(error) = self.board.step(TURN) {
                self.lose(error);
            }
            self.watch_driver();
            self.go_on();
            self.go_on_idle_life();
            self.go_on_arming();
            self.go_on_upload();
        }
        self.go_on_waiting();
        self.tell();
        self.go_on_record();
        self.failed.take().map_or(Ok(()), Err)
    }

    fn now(&self) -> Duration {
        self.board.now()
    }

    fn state(&self) -> State {
        self.board.state().unwrap_or(State::Off)
    }

    fn take(&mut self, message: ToHub) {
        match message {
            ToHub::Joined { page, out, may_drive } => self.join(page, out, may_drive),
            ToHub::Said { page, message } => {
                let now = self.now();
                self.wheel.hear(page, now);
                let answer = self.obey(page, message.id, message.command);
                if let (Some(id), Some(answer)) = (message.id, answer) {
                    self.answer(page, id, answer);
                }
            }
            ToHub::Content { page, bytes } => self.take_content(page, bytes.into()),
            ToHub::Left { page } => self.leave(page),
            ToHub::Asked { command, request, answer } => {
                self.take_request(command, &request, answer);
            }
            ToHub::Watches { views } => self.watchers.add(views),
            ToHub::Gone { command } => self.forget_waiting(command),
        }
    }

    fn leave(&mut self, page: PageId) {
        self.pages.remove(&page);
        self.forget_upload(page);
        self.wheel.forget(page);
        if self.wheel.is_at(page) {
            let now = self.now();
            self.wheel.pass(now);
            self.bound = Bound::default();
            // A show goes on for 2 s: the page may only be reloading.
            if self.act.as_ref().is_some_and(Act::dies_with_its_page) {
                let _ = self.hold();
            }
            self.arming = None;
            self.tell_roles();
        }
    }

    /// Holds the rig if no page drives or the driver is silent, and lowers it 3 s later; does nothing for an unattended
    /// console, or while a command of another terminal moves the rig.
    fn watch_driver(&mut self) {
        let now = self.now();
        if !self.wheel.is_silent(now) || self.is_unattended || self.is_commanded() {
            self.lower_at = None;
            return;
        }
        if self.act.is_some() && self.lower_at.is_none() && self.closing.is_none() {
            self.event(
                Level::Warning,
                "nobody is at the wheel: the rig holds, and is lowered in 3 s",
            );
            self.end_idle();
            self.bound.hold();
            let _ = self.hold();
            self.lower_at = Some(now + wheel::LOWER_AFTER);
        }
        if self.lower_at.is_some_and(|at| now >= at) {
            self.lower_at = None;
            let _ = self.ask(Command::Disarm);
        }
    }

    /// Returns whether a command of another terminal moves the rig.
    fn is_commanded(&self) -> bool {
        self.waiting.as_ref().is_some_and(Waiting::is_command)
    }

    /// Sends a command to the board and waits for its answer. A board that does not answer counts as lost.
    fn ask(&mut self, command: Command) -> Result<Applied, Refused> {
        match self.board.ask(command) {
            Ok(applied) => Ok(applied),
            Err(ClientError::Refused(refusal)) => Err(Refused::Board(refusal)),
            Err(error) => {
                let text = error.to_string();
                self.lose(error);
                Err(Refused::Other(text))
            }
        }
    }

    /// Handles a board that does not answer: ends motion, arming and upload, and reports the error to pages.
    fn lose(&mut self, error: ClientError) {
        self.act = None;
        self.bound.hold();
        self.give_up(&error.to_string());
        if self.lost.is_none() {
            self.event(Level::Error, &error.to_string());
        }
        self.lost = Some(self.now());
        if matches!(error, ClientError::Line(_)) {
            self.failed = Some(error);
        }
    }

    fn find_again(&mut self) {
        match self.board.reconnect(PATIENCE).and_then(|()| self.begin()) {
            Ok(()) => {
                self.lost = None;
                self.told = Told::new(self.now());
                self.event(Level::Info, "the board answers again");
                self.tell_heads();
            }
            Err(ClientError::Line(error)) => self.failed = Some(ClientError::Line(error)),
            Err(_) => self.lost = Some(self.now() + AGAIN),
        }
    }

    /// Stops the rig at the first signal. Returns how the hub ends when it ends, otherwise `None`.
    fn close(&mut self, stops: u32) -> Option<Ended> {
        if stops == 0 {
            return None;
        }
        let now = self.now();
        let since = *self.closing.get_or_insert(now);
        if since == now {
            self.event(
                Level::Warning,
                "the program ends: the rig goes to its rest pose, then torque is off",
            );
            self.act = None;
            self.end_arming("the program ends");
            let _ = self.ask(Command::Stop);
            self.told.before = self.board.log.summaries;
        }
        let is_new = self.board.log.summaries >= self.told.before + 2;
        let is_off = matches!(self.state(), State::Off | State::Limp | State::Faulted);
        if is_new && is_off {
            return Some(Ended::Stopped);
        }
        (stops > 1 || self.lost.is_some() || now.saturating_sub(since) > STOP_MOST)
            .then_some(Ended::AtOnce)
    }
}

/// A reason why a command is not executed.
#[derive(Debug, Clone, PartialEq)]
enum Refused {
    Board(Refusal),
    Other(String),
}

impl Refused {
    fn because(text: &str) -> Self {
        Self::Other(text.to_owned())
    }
}
