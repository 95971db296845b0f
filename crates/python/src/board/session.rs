//! Orders on a session: what a person does with the console's page.

use std::f32::consts::PI;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Context as _, bail, ensure};
use sinew_board_client::{Board, ClientError, Journey, Line, item, pose};
use sinew_firmware::node::SHOW_SCHEMA;
use sinew_firmware::supervisor::{Fault, SOFT_MOST_RAD_S};
use sinew_link::message::{
    Command, FaultRecord, Feed, Kind, LiveFrame, POSE_MAX, Refusal, State, Stream, TelemetryParts,
};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;
use sinew_show::Show;

use super::FaultRow;
use super::order::{Order, Reply, RigState};

/// Telemetry that is asked of the board, Hz.
const RATE_HZ: f32 = 30.0;
/// Interval of poses of a motion.
const EVERY: Duration = Duration::from_millis(20);
/// Longest time of a feed's start.
const START: Duration = Duration::from_secs(1);
/// Longest wait for a rig to become ready to be armed, and the time between two attempts.
const READY: Duration = Duration::from_secs(10);
const AGAIN: Duration = Duration::from_millis(100);
/// Maximum time from a stop until torque is off.
const STOP_MOST: Duration = Duration::from_mins(1);
/// Share of the maximum speed that a motion to a pose uses: the board's own limit is not to be felt.
const SHARE: f32 = 0.7;
/// Distance beyond a range that rounding may cause, rad or m.
const ROUNDING: f64 = 1e-5;

/// A session with its rig.
pub(super) struct Session<'a, L> {
    board: &'a mut Board<L>,
    mechanism: &'a Mechanism,
    /// First coordinate and number of coordinates of each joint.
    blocks: Vec<(usize, usize)>,
    is_cancelled: &'a AtomicBool,
    /// Number of summaries at the end of the last order that may have changed the state.
    changed: u32,
    /// Number of summaries before the board followed live poses; `None` while it does not.
    live: Option<u32>,
    /// Time of the first live pose that the board does not follow yet.
    live_begun: Option<Duration>,
}

impl<'a, L: Line> Session<'a, L> {
    pub(super) fn new(
        board: &'a mut Board<L>,
        mechanism: &'a Mechanism,
        is_cancelled: &'a AtomicBool,
    ) -> Result<Self, ClientError> {
        board.telemetry(RATE_HZ, TelemetryParts::ALL.and(TelemetryParts::TARGETS))?;
        let blocks = mechanism.coordinate_ranges();
        let blocks = blocks.into_iter().map(|range| (range.start, range.len())).collect();
        let (changed, live, live_begun) = (board.log.summaries, None, None);
        Ok(Self { board, mechanism, blocks, is_cancelled, changed, live, live_begun })
    }

    /// Receives from the board, and sends it heartbeats.
    pub(super) fn turn(&mut self, wait: Duration) -> anyhow::Result<()> {
        Ok(self.board.step(wait)?)
    }

    pub(super) fn execute(&mut self, order: Order) -> anyhow::Result<Reply> {
        let changes = !matches!(order, Order::Live { .. } | Order::State | Order::Faults);
        if changes {
            (self.live, self.live_begun) = (None, None);
        }
        let reply = self.obey(order);
        if changes {
            self.changed = self.board.log.summaries;
        }
        reply
    }

    fn obey(&mut self, order: Order) -> anyhow::Result<Reply> {
        match order {
            Order::Arm => self.arm()?,
            Order::Goto { q, least } => self.goto(&q, least)?,
            Order::Live { q } => self.follow(&q)?,
            Order::Play { bytes, rounds } => self.play(&bytes, rounds)?,
            Order::Hold => self.ask(Command::Hold)?,
            Order::Stop | Order::Close => self.stop()?,
            Order::EStop => self.ask(Command::EStop)?,
            Order::Clear => self.ask(Command::ClearFaults)?,
            Order::State => return Ok(Reply::State(Box::new(self.state()?))),
            Order::Faults => {
                let records = self.board.fault_log()?;
                return Ok(Reply::Faults(records.iter().map(fault_row).collect()));
            }
        }
        Ok(Reply::Done)
    }

    /// Returns the pose that the board commands, or `None` while torque is off.
    fn commanded(&self) -> Option<Vec<f32>> {
        let dofs = self.mechanism.dof_names().len();
        pose::commanded(&self.blocks, dofs, &self.board.log)
    }

    fn ask(&mut self, command: Command) -> anyhow::Result<()> {
        self.board.ask(command)?;
        Ok(())
    }

    /// Lets time pass; an error if Python was interrupted.
    fn wait(&mut self, time: Duration) -> anyhow::Result<()> {
        ensure!(!self.is_cancelled.load(Ordering::Relaxed), "interrupted");
        self.turn(time)
    }

    /// Waits until the newest summary is newer than the last command, and returns its state.
    fn fresh_state(&mut self) -> anyhow::Result<State> {
        let (before, end) = (self.board.log.summaries, self.board.now() + READY);
        while self.board.log.summaries < before + 2 {
            ensure!(self.board.now() < end, "the controller sends no telemetry");
            self.wait(EVERY)?;
        }
        Ok(self.board.state().unwrap_or(State::Off))
    }

    fn arm(&mut self) -> anyhow::Result<()> {
        let end = self.board.now() + READY;
        loop {
            match self.board.ask(Command::Arm) {
                Ok(_) => break,
                Err(ClientError::Refused(refusal)) if passes(refusal) && self.board.now() < end => {
                    let again = self.board.now() + AGAIN;
                    while self.board.now() < again {
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
            state = self.board.state().unwrap_or(state);
        }
        self.expect_holding(state)
    }

    fn expect_holding(&self, state: State) -> anyhow::Result<()> {
        let summary = self.board.log.summary;
        match (state, summary.and_then(|summary| summary.fault).and_then(known)) {
            (State::Holding, _) => Ok(()),
            (state, Some(fault)) => {
                bail!("the rig is {state}: {fault}; {}; to do: {}", fault.when(), fault.remedy())
            }
            (state, None) => bail!("the rig is {state}"),
        }
    }

    /// Refuses a pose outside the ranges of the joints.
    fn check(&self, q: &[f32]) -> anyhow::Result<()> {
        let ranges = self.mechanism.coordinate_ranges();
        for (link, range) in self.mechanism.bodies.iter().zip(ranges) {
            if matches!(link.joint, JointModel::Spherical | JointModel::Free) {
                continue;
            }
            for (number, [least, most]) in q[range].iter().zip(&link.ranges) {
                let number = f64::from(*number);
                ensure!(
                    (least - ROUNDING..=most + ROUNDING).contains(&number),
                    "`{}`: expected {least:.4} to {most:.4}, found {number:.4}",
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
        let sent_us = u32::try_from(self.board.now().as_micros() & u128::from(u32::MAX));
        let frame = LiveFrame { sent_us: sent_us.unwrap_or(0), q: q.iter().copied().collect() };
        Ok(self.board.stream(Stream::Live(frame))?)
    }

    fn goto(&mut self, q: &[f32], least: Duration) -> anyhow::Result<()> {
        self.check(q)?;
        let state = self.fresh_state()?;
        ensure!(state == State::Holding, "the rig is {state}: `arm` makes it hold");
        let from = self.commanded();
        let from = from.unwrap_or_else(|| self.board.log.q.clone());
        ensure!(from.len() == q.len(), "the pose of the rig is not known yet");
        let (speed, now) = (SHARE * SOFT_MOST_RAD_S, self.board.now());
        let journey = Journey::new(&from, q, &self.blocks, speed, now).lasting(least);
        let (begun, mut due) = (now, now);
        let mut follows = None;
        loop {
            let now = self.board.now();
            let commanded = self.commanded();
            if journey.is_over(commanded.as_deref(), now) {
                return self.ask(Command::Hold);
            }
            if now >= due {
                due = now + EVERY;
                self.send(&journey.at(now))?;
            }
            match follows {
                None if self.is_followed(begun)? => follows = Some(self.board.log.summaries),
                Some(before) if self.board.log.summaries >= before + 2 => {
                    let state = self.board.state().unwrap_or(State::Off);
                    if state != State::Playing {
                        return self
                            .expect_holding(state)
                            .and(Err(anyhow::anyhow!("the motion was ended: the rig is {state}")));
                    }
                }
                _ => {}
            }
            if let Err(error) = self.wait(Duration::from_millis(4)) {
                // The rig stands where it is.
                self.ask(Command::Hold)?;
                return Err(error);
            }
        }
    }

    /// Asks the board to follow live poses; `false` while the first ones have not arrived.
    fn is_followed(&mut self, begun: Duration) -> anyhow::Result<bool> {
        match self.board.ask(Command::Play(Feed::Live)) {
            Ok(_) => Ok(true),
            Err(ClientError::Refused(Refusal::FeedSilent(_)))
                if self.board.now().saturating_sub(begun) < START =>
            {
                Ok(false)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Sends a live pose.
    fn follow(&mut self, q: &[f32]) -> anyhow::Result<()> {
        self.check(q)?;
        self.send(q)?;
        if let Some(before) = self.live {
            let state = self.board.state().unwrap_or(State::Off);
            if self.board.log.summaries >= before + 2 && state != State::Playing {
                (self.live, self.live_begun) = (None, None);
                self.expect_holding(state)?;
                bail!(
                    "the rig holds: it got no live pose in time; `live` follows again from now on"
                );
            }
            return Ok(());
        }
        let begun = *self.live_begun.get_or_insert(self.board.now());
        if self.is_followed(begun)? {
            self.live = Some(self.board.log.summaries);
        }
        Ok(())
    }

    fn play(&mut self, bytes: &[u8], rounds: u32) -> anyhow::Result<()> {
        let show = Show::open(bytes)?;
        show.check_rig(self.board.about().rig)?;
        let item = item(Kind::Show, SHOW_SCHEMA, bytes, self.board.about().rig, "sinew_motion")?;
        let slot = if let Some(slot) = self.board.slot_of(&item)? {
            slot
        } else {
            self.board.upload(&item, bytes, &mut |_| ())?;
            self.board.slot_of(&item)?.context("the board does not have the show")?
        };
        self.ask(Command::LoadShow { slot })?;
        self.ask(Command::Play(Feed::Show))?;
        let (before, begun) = (self.board.log.summaries, self.board.now());
        let most = Duration::from_secs_f32(show.duration_s() * rounds as f32);
        loop {
            if let Err(error) = self.wait(EVERY) {
                self.ask(Command::Hold)?;
                return Err(error);
            }
            if show.is_loop() && self.board.now().saturating_sub(begun) >= most {
                return self.ask(Command::Hold);
            }
            if self.board.log.summaries < before + 2 {
                continue;
            }
            match self.board.state().unwrap_or(State::Off) {
                State::Playing => {}
                state => return self.expect_holding(state),
            }
        }
    }

    /// Stops the rig, and waits until torque is off.
    pub(super) fn stop(&mut self) -> anyhow::Result<()> {
        let off = |state| matches!(state, State::Off | State::Limp | State::Faulted);
        let end = self.board.now() + STOP_MOST;
        if self.board.state().is_some_and(off) && off(self.fresh_state()?) {
            return Ok(());
        }
        self.ask(Command::Stop)?;
        let mut state = self.fresh_state()?;
        while !off(state) {
            ensure!(
                self.board.now() < end,
                "torque is still on: the board lowers the rig 2 s after the session ends"
            );
            self.wait(EVERY)?;
            state = self.board.state().unwrap_or(state);
        }
        Ok(())
    }

    fn state(&mut self) -> anyhow::Result<RigState> {
        let end = self.board.now() + READY;
        while self.board.log.summaries < self.changed + 2 || self.board.log.q.is_empty() {
            ensure!(self.board.now() < end, "the controller sends no telemetry");
            self.wait(EVERY)?;
        }
        let summary = self.board.log.summary.context("the controller sends no telemetry")?;
        let log = &self.board.log;
        let error = summary.errors.map_or(f32::NAN, |errors| errors.largest_deg * PI / 180.0);
        Ok(RigState {
            name: summary.state.to_string(),
            q: log.q.clone(),
            effort: log.dofs.iter().map(|dof| dof.effort).collect(),
            supply_v: summary.supply_v,
            show_ms: summary.show_ms,
            error_rad: error,
            servos: log.servos.iter().map(|of| (of.temperature_c, of.heat_percent)).collect(),
        })
    }
}

/// Returns whether a refusal to arm may pass by itself.
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

fn fault_row(record: &FaultRecord) -> FaultRow {
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
