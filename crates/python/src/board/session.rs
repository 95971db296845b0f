//! Orders on a session: what a person does with the console's page. Other terminals can stop the rig meanwhile.

use std::time::Duration;

use anyhow::{Context as _, bail, ensure};
use sinew_board_client::{Board, ClientError, Journey, Line, TelemetryLog, item, pose};
use sinew_console::Hosted;
use sinew_firmware::node::{SETTING_NAMES, SHOW_SCHEMA};
use sinew_firmware::supervisor::{Fault, SOFT_MOST_RAD_S};
use sinew_link::message::{
    Command, FaultRecord, Feed, Kind, LiveFrame, POSE_MAX, Refusal, State, Stream, TelemetryParts,
};
use sinew_rig::Mechanism;
use sinew_show::Show;

use super::FaultRow;
use super::inbox::Inbox;
use super::order::{Order, Reply, RigState, Urgency};
use super::pose::followed;

/// Requested telemetry rate, Hz.
const RATE_HZ: f32 = 30.0;
/// Interval between two poses of a motion.
const EVERY: Duration = Duration::from_millis(20);
/// Longest wait until the board accepts the first live poses.
const START: Duration = Duration::from_secs(1);
/// Longest wait for a rig to become ready to be armed, and interval between two attempts.
const READY: Duration = Duration::from_secs(10);
const AGAIN: Duration = Duration::from_millis(100);
/// Longest wait from a stop until torque is off.
const STOP_MOST: Duration = Duration::from_mins(1);
/// Share of the maximum speed that a motion to a pose uses, so that the board's own limit does not act.
const SHARE: f32 = 0.7;
/// Largest distance of each coordinate from its goal at which a pose counts as reached, rad or m.
const THERE: f32 = 3e-3;
/// Reason why nothing moves after a stop by another terminal.
const STOPPED: &str = "another terminal has stopped the rig: `clear` lets it move again";

/// A session with a board, and its rig.
pub(super) struct Session<'a, L> {
    hosted: Hosted<'a, L>,
    pub(super) inbox: Inbox,
    mechanism: &'a Mechanism,
    /// First coordinate and number of coordinates of each joint.
    blocks: Vec<(usize, usize)>,
    /// Maximum speed of a joint that is moved by hand, rad/s: a setting of the board.
    soft_rad_s: f32,
    /// Whether another terminal has stopped the rig.
    is_stopped: bool,
    /// Whether the running order needs torque.
    moves: bool,
    /// Number of summaries at the end of the last order that may have changed the state.
    changed: u32,
    /// Number of summaries that were received when the board began to follow live poses; `None` while it follows none.
    live: Option<u32>,
    /// Time of the first live pose, until the board follows live poses; otherwise `None`.
    live_begun: Option<Duration>,
}

impl<'a, L: Line> Session<'a, L> {
    pub(super) fn new(
        mut hosted: Hosted<'a, L>,
        mechanism: &'a Mechanism,
        inbox: Inbox,
    ) -> Result<Self, ClientError> {
        let board = hosted.board_mut();
        board.telemetry(RATE_HZ, TelemetryParts::ALL.and(TelemetryParts::TARGETS))?;
        let blocks = mechanism.coordinate_ranges();
        let blocks = blocks.into_iter().map(|range| (range.start, range.len())).collect();
        let key = SETTING_NAMES.iter().position(|name| *name == "soft_rad_s");
        let key = key.and_then(|place| u16::try_from(place + 1).ok()).unwrap_or_default();
        let soft_rad_s = board.setting(key).unwrap_or(SOFT_MOST_RAD_S);
        Ok(Self {
            changed: board.log.summaries,
            hosted,
            inbox,
            mechanism,
            blocks,
            soft_rad_s,
            is_stopped: false,
            moves: false,
            live: None,
            live_begun: None,
        })
    }

    fn board(&mut self) -> &mut Board<L> {
        self.hosted.board_mut()
    }

    fn log(&self) -> &TelemetryLog {
        &self.hosted.board().log
    }

    fn now(&self) -> Duration {
        self.hosted.board().now()
    }

    /// Receives from the board, sends it heartbeats, and lets other terminals stop the rig.
    pub(super) fn turn(&mut self, wait: Duration) -> anyhow::Result<()> {
        self.hosted.step(wait)?;
        self.is_stopped |= self.hosted.take_stop();
        Ok(())
    }

    pub(super) fn execute(&mut self, order: Order) -> anyhow::Result<Reply> {
        let changes = !matches!(order, Order::Live { .. } | Order::State | Order::Faults);
        if changes {
            (self.live, self.live_begun) = (None, None);
        }
        self.moves = order.moves();
        let reply = self.check_stop().and_then(|()| self.obey(order));
        if changes {
            self.changed = self.log().summaries;
        }
        reply
    }

    fn obey(&mut self, order: Order) -> anyhow::Result<Reply> {
        match order {
            Order::Arm => self.arm()?,
            Order::Goto { q, least } => self.goto(&q, least)?,
            Order::Live { q } => return Ok(Reply::Sent(self.follow(&q)?)),
            Order::Play { bytes, rounds } => self.play(&bytes, rounds)?,
            Order::Upload { bytes } => {
                self.put_show(&bytes)?;
            }
            Order::Hold => self.ask(Command::Hold)?,
            Order::Stop | Order::Close => self.stop()?,
            Order::EStop => self.ask(Command::EStop)?,
            Order::Clear => self.clear()?,
            // Without a console, the program has the board alone.
            Order::Wheel { .. } => {}
            Order::State => return Ok(Reply::State(Box::new(self.state()?))),
            Order::Faults => {
                let records = self.board().fault_log()?;
                return Ok(Reply::Faults(records.iter().map(fault_row).collect()));
            }
        }
        Ok(Reply::Done)
    }

    /// Returns the pose that the board commands; `None` while torque is off.
    fn commanded(&self) -> Option<Vec<f32>> {
        let dofs = self.mechanism.dof_names().len();
        pose::commanded(&self.blocks, dofs, self.log())
    }

    fn ask(&mut self, command: Command) -> anyhow::Result<()> {
        self.board().ask(command)?;
        Ok(())
    }

    /// Lets time pass. Fails if the running order must end: after Ctrl-C, after a more urgent order, and, if it needs
    /// torque, after a stop by another terminal.
    fn wait(&mut self, time: Duration) -> anyhow::Result<()> {
        self.turn(time)?;
        self.check_stop()?;
        self.inbox.check()
    }

    fn check_stop(&self) -> anyhow::Result<()> {
        ensure!(!(self.is_stopped && self.moves), STOPPED);
        Ok(())
    }

    /// Ends a motion with an error: the rig stands where it is, unless it is told to stop.
    fn end_motion(&mut self, error: anyhow::Error) -> anyhow::Error {
        let stops = self.inbox.more_urgent().is_some_and(|order| order.urgency() > Urgency::Holds);
        if self.is_stopped || stops {
            return error;
        }
        self.ask(Command::Hold).err().unwrap_or(error)
    }

    /// Clears faults, and lets the rig move again after a stop by another terminal.
    fn clear(&mut self) -> anyhow::Result<()> {
        let was_stopped = std::mem::take(&mut self.is_stopped);
        match self.board().ask(Command::ClearFaults) {
            Err(ClientError::Refused(Refusal::NoFault)) if was_stopped => Ok(()),
            cleared => Ok(cleared.map(|_| ())?),
        }
    }

    /// Returns the state of a summary that is newer than the last command; waits for it.
    fn fresh_state(&mut self) -> anyhow::Result<State> {
        let (before, end) = (self.log().summaries, self.now() + READY);
        while self.log().summaries < before + 2 {
            ensure!(self.now() < end, "the controller sends no telemetry");
            self.wait(EVERY)?;
        }
        Ok(self.hosted.board().state().unwrap_or(State::Off))
    }

    fn arm(&mut self) -> anyhow::Result<()> {
        let end = self.now() + READY;
        loop {
            match self.board().ask(Command::Arm) {
                Ok(_) => break,
                Err(ClientError::Refused(refusal)) if passes(refusal) && self.now() < end => {
                    let again = self.now() + AGAIN;
                    while self.now() < again {
                        self.wait(EVERY)?;
                    }
                }
                Err(ClientError::Refused(why)) => bail!("the controller refused to arm: {why}"),
                Err(error) => return Err(error.into()),
            }
        }
        let mut state = self.fresh_state()?;
        while state == State::Arming {
            self.wait(EVERY)?;
            state = self.hosted.board().state().unwrap_or(state);
        }
        self.expect_holding(state)
    }

    fn expect_holding(&self, state: State) -> anyhow::Result<()> {
        let summary = self.log().summary;
        match (state, summary.and_then(|summary| summary.fault).and_then(known)) {
            (State::Holding, _) => Ok(()),
            (state, Some(fault)) => {
                bail!("the rig is {state}: {fault}; {}; to do: {}", fault.when(), fault.remedy())
            }
            (state, None) => bail!("the rig is {state}"),
        }
    }

    /// Fails if the pose that the board commands is not the goal of a motion.
    fn check_reached(&self, commanded: Option<&[f32]>, goal: &[f32]) -> anyhow::Result<()> {
        let commanded = commanded.context(
            "it is not known whether the pose was reached: the board does not tell the pose that it commands",
        )?;
        for (link, (first, count)) in self.mechanism.bodies.iter().zip(&self.blocks) {
            let (at, to) = (&commanded[*first..first + count], &goal[*first..first + count]);
            let far = |sign: f32| at.iter().zip(to).any(|(a, b)| (a - sign * b).abs() > THERE);
            // Both signs of a ball joint's quaternion are the same rotation.
            if far(1.0) && (*count != 4 || far(-1.0)) {
                bail!(
                    "the pose was not reached, and the rig holds: `{}` is at {at:.4?}, the goal is {to:.4?}",
                    link.joint_name
                );
            }
        }
        Ok(())
    }

    fn send(&mut self, q: &[f32]) -> anyhow::Result<()> {
        ensure!(
            q.len() <= POSE_MAX,
            "the pose has {} numbers; the link carries {POSE_MAX}",
            q.len()
        );
        let sent_us = u32::try_from(self.now().as_micros() & u128::from(u32::MAX));
        let frame = LiveFrame { sent_us: sent_us.unwrap_or(0), q: q.iter().copied().collect() };
        Ok(self.board().stream(Stream::Live(frame))?)
    }

    fn goto(&mut self, q: &[f32], least: Duration) -> anyhow::Result<()> {
        let q = &followed(self.mechanism, q)?[..];
        let state = self.fresh_state()?;
        ensure!(state == State::Holding, "the rig is {state}: `arm` makes it hold");
        let from = self.commanded();
        let from = from.unwrap_or_else(|| self.log().q.clone());
        ensure!(from.len() == q.len(), "the pose of the rig is not known yet");
        let (speed, now) = (SHARE * self.soft_rad_s, self.now());
        let journey = Journey::new(&from, q, &self.blocks, speed, now).lasting(least);
        let (begun, mut due) = (now, now);
        let mut follows = None;
        loop {
            let now = self.now();
            let commanded = self.commanded();
            if journey.is_over(commanded.as_deref(), now) {
                self.ask(Command::Hold)?;
                return self.check_reached(commanded.as_deref(), q);
            }
            if now >= due {
                due = now + EVERY;
                self.send(&journey.at(now))?;
            }
            match follows {
                None if self.is_followed(begun)? => follows = Some(self.log().summaries),
                Some(before) if self.log().summaries >= before + 2 => {
                    let state = self.hosted.board().state().unwrap_or(State::Off);
                    if state != State::Playing {
                        return self
                            .expect_holding(state)
                            .and(Err(anyhow::anyhow!("the motion was ended: the rig is {state}")));
                    }
                }
                _ => {}
            }
            if let Err(error) = self.wait(Duration::from_millis(4)) {
                return Err(self.end_motion(error));
            }
        }
    }

    /// Asks the board to follow live poses. Returns `false` as long as the first poses may still be on their way.
    fn is_followed(&mut self, begun: Duration) -> anyhow::Result<bool> {
        match self.board().ask(Command::Play(Feed::Live)) {
            Ok(_) => Ok(true),
            Err(ClientError::Refused(Refusal::FeedSilent(_)))
                if self.now().saturating_sub(begun) < START =>
            {
                Ok(false)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Sends a live pose, and returns it. Fails if the board no longer follows live poses.
    fn follow(&mut self, q: &[f32]) -> anyhow::Result<Vec<f32>> {
        let q = followed(self.mechanism, q)?;
        self.send(&q)?;
        if let Some(before) = self.live {
            let state = self.hosted.board().state().unwrap_or(State::Off);
            if self.log().summaries >= before + 2 && state != State::Playing {
                (self.live, self.live_begun) = (None, None);
                self.expect_holding(state)?;
                bail!(
                    "the rig holds: it got no live pose in time; `live` follows again from now on"
                );
            }
            return Ok(q);
        }
        let begun = *self.live_begun.get_or_insert(self.now());
        let followed = self.is_followed(begun);
        if followed.is_err() {
            // The next pose begins again.
            self.live_begun = None;
        }
        if followed? {
            self.live = Some(self.log().summaries);
        }
        Ok(q)
    }

    fn play(&mut self, bytes: &[u8], rounds: u32) -> anyhow::Result<()> {
        let show = Show::open(bytes)?;
        let slot = self.put_show(bytes)?;
        self.wait(Duration::ZERO)?;
        self.ask(Command::LoadShow { slot })?;
        self.wait(Duration::ZERO)?;
        self.ask(Command::Play(Feed::Show))?;
        let before = self.log().summaries;
        let most = Duration::from_secs_f32(show.duration_s() * rounds as f32);
        // Time at which the show's clock began, after the way to the first pose.
        let mut begun: Option<Duration> = None;
        loop {
            if let Err(error) = self.wait(EVERY) {
                return Err(self.end_motion(error));
            }
            let now = self.now();
            if show.is_loop() && begun.is_some_and(|begun| now.saturating_sub(begun) >= most) {
                return self.ask(Command::Hold);
            }
            if self.log().summaries < before + 2 {
                continue;
            }
            match self.hosted.board().state().unwrap_or(State::Off) {
                State::Playing => {
                    let show_ms = self.log().summary.map_or(0, |summary| summary.show_ms);
                    if begun.is_none() && show_ms > 0 {
                        begun = Some(now.saturating_sub(Duration::from_millis(show_ms.into())));
                    }
                }
                state => return self.expect_holding(state),
            }
        }
    }

    /// Uploads a show if the board does not have it. Returns its slot.
    fn put_show(&mut self, bytes: &[u8]) -> anyhow::Result<u8> {
        let rig = self.board().about().rig;
        Show::open(bytes)?.check_rig(rig)?;
        let item = item(Kind::Show, SHOW_SCHEMA, bytes, rig, "sinew_motion")?;
        if let Some(slot) = self.board().slot_of(&item)? {
            return Ok(slot);
        }
        let mut next = Some(Command::BeginUpload(item.clone()));
        while let Some(command) = next {
            next = match self.board().upload_step(command, item.kind, bytes, &mut |_| ()) {
                Err(ClientError::Refused(Refusal::State(state))) => bail!(
                    "the board does not have the show, and stores shows only while torque is off; the rig is {state}: \
                     `upload` the show before `arm`"
                ),
                next => next?,
            };
            self.wait(Duration::ZERO)?;
        }
        self.board().slot_of(&item)?.context("the board does not have the show")
    }

    /// Stops the rig, and waits until torque is off.
    pub(super) fn stop(&mut self) -> anyhow::Result<()> {
        let off = |state| matches!(state, State::Off | State::Limp | State::Faulted);
        let end = self.now() + STOP_MOST;
        if self.hosted.board().state().is_some_and(off) && off(self.fresh_state()?) {
            return Ok(());
        }
        self.ask(Command::Stop)?;
        let mut state = self.fresh_state()?;
        while !off(state) {
            ensure!(
                self.now() < end,
                "torque is still on: the board lowers the rig 2 s after the session ends"
            );
            self.wait(EVERY)?;
            state = self.hosted.board().state().unwrap_or(state);
        }
        Ok(())
    }

    fn state(&mut self) -> anyhow::Result<RigState> {
        let end = self.now() + READY;
        while self.log().summaries < self.changed + 2 || self.log().q.is_empty() {
            ensure!(self.now() < end, "the controller sends no telemetry");
            self.wait(EVERY)?;
        }
        let summary = self.log().summary.context("the controller sends no telemetry")?;
        let log = self.log();
        let efforts = log.dofs.iter().map(|dof| dof.effort).collect();
        Ok(RigState::new(&summary, log.q.clone(), efforts, &log.servos))
    }
}

/// Returns whether the reason for a refusal to arm may disappear by itself.
fn passes(refusal: Refusal) -> bool {
    matches!(
        refusal,
        Refusal::Moving { .. }
            | Refusal::RegistersUnread
            | Refusal::NotMeasured
            | Refusal::StopUntested
            | Refusal::Busy
            | Refusal::State(State::Off)
    )
}

fn known(number: u8) -> Option<Fault> {
    Fault::ALL.into_iter().find(|fault| fault.number() == number)
}

pub(super) fn fault_row(record: &FaultRecord) -> FaultRow {
    let fault = known(record.fault);
    let (when, remedy) = fault.map_or(("", ""), |fault| (fault.when(), fault.remedy()));
    (
        fault.map_or_else(|| format!("fault {}", record.fault), |fault| fault.name().to_owned()),
        record.state.to_string(),
        record.servo,
        record.time_us as f64 * 1e-6,
        record.times,
        record.is_warning(),
        when,
        remedy,
    )
}
