//! Motions that take several turns of the hub: a joint that follows a slider, a journey, a show, idle life; and arming.

use std::time::Duration;

use sinew_board_client::{Arrival, Journey, Line, TelemetryLog};
use sinew_link::message::{Command, Feed, LiveFrame, Refusal, State, Stream};

use super::slider::Slider;
use super::{Hub, Refused};
use crate::message::Level;
use crate::server::PageId;

/// Interval at which the board gets speeds or poses.
pub(super) const EVERY: Duration = Duration::from_millis(20);
/// Shortest interval, if the goal or the speed of a slider changes.
const SOON: Duration = Duration::from_millis(10);
/// Longest time until the board follows a feed.
const START: Duration = Duration::from_secs(1);
/// Longest wait until the rig can be armed, and the time between two attempts.
pub(super) const READY: Duration = Duration::from_secs(10);
pub(super) const AGAIN: Duration = Duration::from_millis(100);

/// Largest age of a summary that counts: a show does not go on while the board is silent.
const SUMMARY_AGE: Duration = Duration::from_millis(20);

/// Time after its expected start after which a show that has not started is late.
const START_LATE: Duration = Duration::from_millis(100);

/// A motion that goes on.
#[derive(Debug)]
pub(super) enum Act {
    Slider(Feeding<Slider>),
    Journey(Feeding<Journey>),
    /// Poses of a program; the newest, until it is sent.
    Live(Feeding<Option<Vec<f32>>>),
    Show(Playing),
    Idle(Feeding<()>),
}

/// A motion whose speeds or poses the hub sends to the board.
#[derive(Debug)]
pub(super) struct Feeding<M> {
    pub(super) motion: M,
    /// Number of summaries received when the board began to follow the feed; `None` before.
    follows: Option<u32>,
    begun: Duration,
    /// Time of the next speed or pose, and the earliest such time.
    due: Duration,
    soonest: Duration,
}

/// A show on the board.
#[derive(Debug)]
pub(super) struct Playing {
    /// Whether the show begins again when it is over.
    repeats: bool,
    /// Number of rounds of a loop that ends: after the last, the rig holds.
    rounds: Option<u32>,
    before: u32,
    show_ms: u32,
    /// Expected time of the show's start; `None` if it is not known.
    starts: Option<Duration>,
}

impl Playing {
    /// Returns the time in the show, s, from a log whose summary arrived at `heard`. Before the show starts it is
    /// negative, or 0 if the start is not known or is late.
    pub(super) fn place_s(&self, log: &TelemetryLog, [heard, now]: [Duration; 2]) -> f32 {
        let show_ms = log.summary.map_or(0, |summary| summary.show_ms);
        // The summary may be from before the command to play.
        if log.summaries >= self.before + 2 && show_ms > 0 {
            let since = now.saturating_sub(heard).min(SUMMARY_AGE);
            return (Duration::from_millis(show_ms.into()) + since).as_secs_f32();
        }
        let Some(starts) = self.starts else { return 0.0 };
        match now.checked_sub(starts) {
            None => -starts.saturating_sub(now).as_secs_f32(),
            // The board may have started since its last summary.
            Some(since) if since < START_LATE => since.as_secs_f32(),
            Some(_) => 0.0,
        }
    }
}

/// A request to arm, repeated until the board allows it.
#[derive(Debug)]
pub(super) struct Arming {
    pub(super) page: PageId,
    pub(super) id: Option<u64>,
    until: Duration,
    due: Duration,
}

impl Act {
    /// Returns whether the motion ends when its page is gone.
    pub(super) fn dies_with_its_page(&self) -> bool {
        !matches!(self, Self::Show(_) | Self::Idle(_))
    }
}

impl<M> Feeding<M> {
    pub(super) fn new(motion: M, now: Duration) -> Self {
        Self { motion, follows: None, begun: now, due: now, soonest: now }
    }

    /// Makes the next speed due soon, because the goal has changed, or the speed is changing.
    pub(super) fn hurry(&mut self) {
        self.due = self.due.min(self.soonest);
    }

    /// Returns whether a speed or a pose must be sent now. The next one is then due an interval later.
    fn is_due(&mut self, now: Duration) -> bool {
        let is_due = now >= self.due;
        if is_due {
            (self.due, self.soonest) = (now + EVERY, now + SOON);
        }
        is_due
    }
}

impl<L: Line> Hub<'_, L> {
    /// Ends the motion: the rig stands where it is. Succeeds also if torque is off.
    pub(super) fn hold(&mut self) -> Result<String, Refused> {
        self.act = None;
        match self.ask(Command::Hold) {
            Ok(_) => Ok("the rig stands".to_owned()),
            // Nothing moves: it stands already.
            Err(Refused::Board(Refusal::State(State::Off | State::Limp | State::Faulted))) => {
                Ok("torque is off".to_owned())
            }
            Err(refused) => Err(refused),
        }
    }

    /// Begins to play the loaded show.
    pub(super) fn begin_show(&mut self, repeats: bool, rounds: Option<u32>) -> Result<(), Refused> {
        let way = self.way_to_show();
        self.ask(Command::Play(Feed::Show))?;
        // The board answers in the tick in which it begins.
        let begun = self.now();
        let before = self.board.log.summaries;
        let starts = way.map(|way| begun + way);
        self.arrived = None;
        self.act = Some(Act::Show(Playing { repeats, rounds, before, show_ms: 0, starts }));
        Ok(())
    }

    fn end_show(&mut self) {
        const OVER: &str = "the show is over";
        self.event(Level::Info, OVER);
        self.arrived = Some(Ok(OVER.to_owned()));
    }

    /// Continues the motion.
    pub(super) fn go_on(&mut self) {
        let ended = match self.act.take() {
            None => return,
            Some(Act::Slider(feeding)) => self.go_on_slider(feeding),
            Some(Act::Journey(feeding)) => self.go_on_journey(feeding),
            Some(Act::Live(feeding)) => self.go_on_live(feeding),
            Some(Act::Show(playing)) => self.go_on_show(playing),
            Some(Act::Idle(feeding)) => self.go_on_idle(feeding),
        };
        if let Err(refused) = ended {
            // Idle life that the board refuses must not begin again and again.
            self.end_idle();
            let text = self.text(&refused);
            self.event(Level::Warning, &text);
        }
    }

    fn go_on_slider(&mut self, mut feeding: Feeding<Slider>) -> Result<(), Refused> {
        let now = self.now();
        if feeding.motion.is_silent(now) {
            return self.hold().map(|_| ());
        }
        if feeding.is_due(now) {
            let commanded = self.wanted(feeding.motion.coordinate);
            let velocity = feeding.motion.velocity(commanded, now);
            if let Some(mut pose) = feeding.motion.pose() {
                self.scene.follow(&mut pose);
                self.send_pose(pose, now)?;
            } else {
                let dof = u8::try_from(feeding.motion.dof).unwrap_or(u8::MAX);
                self.send(Stream::Jog { dof, velocity })?;
                if feeding.motion.changes() {
                    feeding.hurry();
                }
            }
        }
        let feed =
            if self.scene.leads(feeding.motion.dof).is_some() { Feed::Live } else { Feed::Jog };
        if self.follow(&mut feeding, feed)? {
            self.act.get_or_insert(Act::Slider(feeding));
        } else {
            self.barred = Some(now);
        }
        Ok(())
    }

    fn go_on_journey(&mut self, mut feeding: Feeding<Journey>) -> Result<(), Refused> {
        let now = self.now();
        let commanded = self.scene.commanded(&self.board.log);
        if feeding.motion.is_over(commanded.as_deref(), now) {
            self.hold()?;
            let arrival = feeding.motion.arrival(commanded.as_deref());
            let arrived = self.arrival_text(arrival);
            match &arrived {
                Ok(text) => self.event(Level::Info, text),
                Err(text) => self.event(Level::Warning, text),
            }
            self.arrived = Some(arrived);
            return Ok(());
        }
        if feeding.is_due(now) {
            self.send_pose(feeding.motion.at(now), now)?;
        }
        if self.follow(&mut feeding, Feed::Live)? {
            self.act.get_or_insert(Act::Journey(feeding));
        }
        Ok(())
    }

    /// Follows the poses of a program. The hub repeats none of them, so the board holds if the next one is late.
    fn go_on_live(&mut self, mut feeding: Feeding<Option<Vec<f32>>>) -> Result<(), Refused> {
        let now = self.now();
        let is_due = feeding.motion.is_some() && feeding.is_due(now);
        if is_due && let Some(pose) = feeding.motion.take() {
            self.send_pose(pose, now)?;
        }
        // The program learns the end with its next pose.
        match self.follow(&mut feeding, Feed::Live) {
            Ok(true) => {
                self.act.get_or_insert(Act::Live(feeding));
            }
            Ok(false) if self.state() == State::Holding => self.bound.end(
                "the rig holds: it got no pose in time; poses move it again from now on".to_owned(),
            ),
            Ok(false) => self.bound.end(format!("the rig is {}", self.state())),
            Err(refused) => self.bound.end(self.text(&refused)),
        }
        Ok(())
    }

    /// Takes a pose of a program, which the board gets soon, unless a newer one comes before.
    pub(super) fn live(&mut self, mut pose: Vec<f32>) -> Result<String, Refused> {
        self.check_pose(&pose)?;
        if !matches!(self.state(), State::Holding | State::Playing) {
            return Err(Refused::Other(format!("the rig is {}: arm it first", self.state())));
        }
        if !matches!(self.act, None | Some(Act::Live(_))) {
            return Err(Refused::because("the rig moves on its own: hold it first"));
        }
        self.bound.check_pose()?;
        self.scene.follow(&mut pose);
        if let Some(Act::Live(feeding)) = &mut self.act {
            feeding.motion = Some(pose);
            feeding.hurry();
        } else {
            self.act = Some(Act::Live(Feeding::new(Some(pose), self.now())));
        }
        Ok(String::new())
    }

    fn go_on_idle(&mut self, mut feeding: Feeding<()>) -> Result<(), Refused> {
        let now = self.now();
        if feeding.is_due(now)
            && let Some(pose) = self.idle_pose()
        {
            self.send_pose(pose, now)?;
        }
        if self.follow(&mut feeding, Feed::Live)? {
            self.act.get_or_insert(Act::Idle(feeding));
        }
        Ok(())
    }

    /// Tells in words whether a motion has ended at its goal.
    fn arrival_text(&self, arrival: Arrival) -> Result<String, String> {
        match arrival {
            Arrival::There => Ok("the rig is there".to_owned()),
            Arrival::Unknown => {
                Ok("the motion has ended; the board does not tell where it holds the rig"
                    .to_owned())
            }
            Arrival::Misses { coordinate, off } => {
                let mut dofs = self.scene.dofs.iter();
                let place = match dofs.find(|dof| dof.coordinate == Some(coordinate)) {
                    Some(dof) if dof.slides => format!("`{}` by {:.1} mm", dof.name, 1e3 * off),
                    Some(dof) => format!("`{}` by {:.1} deg", dof.name, off.to_degrees()),
                    None => "a ball joint".to_owned(),
                };
                Err(format!("the rig has not reached its goal in time: it misses {place}"))
            }
        }
    }

    /// Lets the board follow a feed, and returns whether the motion goes on. It ends when the board no longer plays.
    fn follow<M>(&mut self, feeding: &mut Feeding<M>, feed: Feed) -> Result<bool, Refused> {
        if let Some(before) = feeding.follows {
            // A summary that is newer than the command decides.
            let is_over = self.board.log.summaries >= before + 2 && self.state() != State::Playing;
            return Ok(!is_over);
        }
        match self.ask(Command::Play(feed)) {
            Ok(_) => feeding.follows = Some(self.board.log.summaries),
            // The first messages of the feed have not arrived yet.
            Err(Refused::Board(Refusal::FeedSilent(_)))
                if self.now().saturating_sub(feeding.begun) < START => {}
            Err(refused) => return Err(refused),
        }
        Ok(true)
    }

    fn go_on_show(&mut self, mut playing: Playing) -> Result<(), Refused> {
        let is_new = self.board.log.summaries >= playing.before + 2;
        let show_ms = self.board.log.summary.map_or(0, |summary| summary.show_ms);
        let is_round = is_new && show_ms < playing.show_ms;
        if is_new {
            playing.show_ms = show_ms;
        }
        if is_round && let Some(rounds @ 2..) = &mut playing.rounds {
            *rounds -= 1;
            self.act = Some(Act::Show(playing));
            return Ok(());
        }
        match self.state() {
            State::Playing if is_round && playing.rounds == Some(1) => {
                self.hold()?;
                self.end_show();
            }
            _ if !is_new => self.act = Some(Act::Show(playing)),
            State::Playing => self.act = Some(Act::Show(playing)),
            State::Holding if playing.repeats && self.closing.is_none() => {
                self.begin_show(playing.repeats, None)?;
            }
            State::Holding => self.end_show(),
            _ => {}
        }
        Ok(())
    }

    fn send_pose(&mut self, pose: Vec<f32>, now: Duration) -> Result<(), Refused> {
        let sent_us = u32::try_from(now.as_micros() & u128::from(u32::MAX)).unwrap_or(0);
        self.send(Stream::Live(LiveFrame { sent_us, q: pose.into_iter().collect() }))
    }

    fn send(&mut self, stream: Stream) -> Result<(), Refused> {
        self.board.stream(stream).map_err(|error| {
            let text = error.to_string();
            self.lose(error);
            Refused::Other(text)
        })
    }

    /// Begins to arm as soon as the board allows it.
    pub(super) fn begin_arming(&mut self, page: PageId, id: Option<u64>) {
        let now = self.now();
        self.arming = Some(Arming { page, id, until: now + READY, due: now });
        self.go_on_arming();
    }

    /// Ends a wait for arming, and answers its page with the reason.
    pub(super) fn end_arming(&mut self, why: &str) {
        if let Some(Arming { page, id: Some(id), .. }) = self.arming.take() {
            self.answer(page, id, Err(Refused::because(why)));
        }
    }

    /// Asks the board to arm, and answers the page, unless a later attempt may succeed. Only a page that drives arms.
    pub(super) fn go_on_arming(&mut self) {
        let now = self.now();
        if self.arming.as_ref().is_some_and(|arming| !self.wheel.is_at(arming.page)) {
            self.end_arming("this page does not drive any more");
        } else if self.wheel.is_silent(now) {
            self.end_arming("this page was silent");
        }
        let Some(arming) = self.arming.take_if(|arming| now >= arming.due) else { return };
        let answer = match self.ask(Command::Arm) {
            Err(refused) if passes(&refused) && now < arming.until => {
                self.arming = Some(Arming { due: now + AGAIN, ..arming });
                return;
            }
            Ok(_) => Ok("torque comes on".to_owned()),
            Err(refused) => Err(refused),
        };
        if let Err(refused) = &answer {
            let text = self.text(refused);
            self.event(Level::Error, &format!("not armed: {text}"));
        }
        if let Some(id) = arming.id {
            self.answer(arming.page, id, answer);
        }
    }
}

/// Returns whether the reason for refusing to arm may pass by itself.
pub(super) fn passes(refused: &Refused) -> bool {
    matches!(
        refused,
        Refused::Board(
            Refusal::Moving { .. }
                | Refusal::RegistersUnread
                | Refusal::NotMeasured
                | Refusal::StopUntested
                | Refusal::Busy
                | Refusal::State(State::Off),
        )
    )
}
