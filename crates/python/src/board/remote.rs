//! Orders on the board of a running console. The console moves the rig, by the rules that hold for its pages.

use std::time::Duration;

use anyhow::{Context as _, anyhow, bail, ensure};
use sinew_board_client::console::Report;
use sinew_board_client::item;
use sinew_console::{Driver, PageCommand};
use sinew_firmware::node::SHOW_SCHEMA;
use sinew_link::message::{FaultRecord, Kind, State};
use sinew_rig::Mechanism;
use sinew_show::Show;

use super::inbox::Inbox;
use super::open::{check_rig, text};
use super::order::{Order, Reply, RigState, Urgency};
use super::pose::followed;
use super::session::fault_row;

/// Longest wait for the console between two checks for orders.
const TURN: Duration = Duration::from_millis(4);
/// Longest wait for telemetry, and from a stop until torque is off.
const READY: Duration = Duration::from_secs(10);
const STOP_MOST: Duration = Duration::from_mins(1);

/// A connection to a console, and the rig of its board.
pub(super) struct Remote<'a> {
    driver: Driver,
    inbox: Inbox,
    mechanism: &'a Mechanism,
    rig_crc: u32,
    /// Number of the console's summaries at the end of the last order that may have changed the state.
    changed: u32,
    /// Whether this program has armed or moved the rig, which it then stops at its end.
    has_moved: bool,
}

impl<'a> Remote<'a> {
    pub(super) fn open(
        name: &str,
        (mechanism, rig_crc): (&'a Mechanism, u32),
        inbox: Inbox,
    ) -> anyhow::Result<Self> {
        let driver = Driver::open(name).with_context(|| format!("the console {name}"))?;
        let mut remote = Self { driver, inbox, mechanism, rig_crc, changed: 0, has_moved: false };
        check_rig(remote.report()?.rig, rig_crc)?;
        Ok(remote)
    }

    /// Executes orders until the board is closed, or Python has dropped it.
    pub(super) fn serve(mut self, opened: impl FnOnce()) -> anyhow::Result<()> {
        opened();
        loop {
            if let Some(asked) = self.inbox.next() {
                let is_close = matches!(asked.order, Order::Close);
                // Nobody waits if Python was interrupted.
                let _ = asked.reply.send(self.execute(asked.order).map_err(text));
                if is_close {
                    return Ok(());
                }
            } else if self.inbox.is_dropped() {
                return self.close();
            } else {
                self.driver.step(TURN)?;
            }
        }
    }

    fn execute(&mut self, order: Order) -> anyhow::Result<Reply> {
        let changes = !matches!(order, Order::Live { .. } | Order::State | Order::Faults);
        self.has_moved |= order.moves() && self.driver.drives();
        let reply = self.obey(order);
        if changes && let Ok(report) = self.report() {
            self.changed = report.summaries;
        }
        reply
    }

    fn obey(&mut self, order: Order) -> anyhow::Result<Reply> {
        match order {
            Order::Arm => self.arm()?,
            Order::Goto { q, least } => {
                let q = followed(self.mechanism, &q)?;
                // The console, too, must know that the rig holds.
                self.report_after(self.changed)?;
                self.move_by(PageCommand::Goto { q, seconds: least.as_secs_f64() })?;
            }
            Order::Live { q } => {
                let q = followed(self.mechanism, &q)?;
                self.ask(PageCommand::Live { q: q.clone() })?;
                return Ok(Reply::Sent(q));
            }
            Order::Play { bytes, rounds } => self.play(&bytes, rounds)?,
            Order::Upload { bytes } => self.upload(&bytes)?,
            Order::Hold => self.done(PageCommand::Hold)?,
            Order::Stop => self.stop()?,
            Order::EStop => self.done(PageCommand::EStop)?,
            Order::Clear => self.done(PageCommand::Clear)?,
            Order::Wheel { take } => self.done(PageCommand::Wheel { take })?,
            Order::Close => self.close()?,
            Order::State => {
                let report = self.report_after(self.changed)?;
                let state =
                    RigState::new(&report.summary, report.q, report.efforts, &report.servos);
                return Ok(Reply::State(Box::new(state)));
            }
            Order::Faults => {
                let records: Vec<FaultRecord> =
                    serde_json::from_str(&self.ask(PageCommand::Faults)?)?;
                return Ok(Reply::Faults(records.iter().map(fault_row).collect()));
            }
        }
        Ok(Reply::Done)
    }

    /// Sends a command that the console answers at once, and returns the answer. Fails if the console refuses.
    fn ask(&mut self, command: PageCommand) -> anyhow::Result<String> {
        let (id, end) = (self.driver.ask(command)?, self.driver.now() + READY);
        loop {
            if let Some(answer) = self.driver.answer(id) {
                return answer.map_err(|why| anyhow!(why));
            }
            ensure!(self.driver.now() < end, "the console does not answer");
            self.driver.step(TURN)?;
        }
    }

    /// Waits for an answer. Fails if the running order must end; the console's refusal is the inner error.
    fn answer(&mut self, id: u64) -> anyhow::Result<Result<String, String>> {
        loop {
            if let Some(answer) = self.driver.answer(id) {
                return Ok(answer);
            }
            self.wait()?;
        }
    }

    fn done(&mut self, command: PageCommand) -> anyhow::Result<()> {
        self.ask(command).map(|_| ())
    }

    /// Arms or moves the rig, and waits for the end. If the order must end before, the rig holds, unless it is told to
    /// stop. After a refusal it does not: then somebody else may move the rig.
    fn move_by(&mut self, command: PageCommand) -> anyhow::Result<()> {
        let id = self.driver.ask(command)?;
        let ended = self.answer(id);
        let more = self.inbox.more_urgent().map(Order::urgency);
        if ended.is_err() && more.is_none_or(|urgency| urgency <= Urgency::Holds) {
            // The rig may also have ended the motion by itself, and refuse to hold.
            let _ = self.driver.ask(PageCommand::Hold)?;
        }
        ended?.map(|_| ()).map_err(|why| anyhow!(why))
    }

    /// Returns the newest state.
    fn report(&mut self) -> anyhow::Result<Report> {
        Ok(serde_json::from_str(&self.ask(PageCommand::State)?)?)
    }

    /// Returns a state that is newer than a command, after which the console had `before` summaries.
    fn report_after(&mut self, before: u32) -> anyhow::Result<Report> {
        let end = self.driver.now() + READY;
        loop {
            let report = self.report()?;
            // A console that has found its board again counts from the beginning.
            let is_new = report.summaries >= before + 2 || report.summaries < before;
            if is_new && !report.q.is_empty() {
                return Ok(report);
            }
            ensure!(self.driver.now() < end, "the controller sends no telemetry");
            self.wait()?;
        }
    }

    /// Lets time pass. Fails if the running order must end.
    fn wait(&mut self) -> anyhow::Result<()> {
        self.driver.step(TURN)?;
        self.inbox.check()
    }

    fn arm(&mut self) -> anyhow::Result<()> {
        self.move_by(PageCommand::Arm)?;
        let before = self.report()?.summaries;
        loop {
            match self.report_after(before)?.summary.state {
                State::Arming => self.wait()?,
                State::Holding => return Ok(()),
                state => bail!("the rig is {state}"),
            }
        }
    }

    fn slot(&self, bytes: &[u8]) -> anyhow::Result<Option<u8>> {
        Show::open(bytes)?.check_rig(self.rig_crc)?;
        let item = item(Kind::Show, SHOW_SCHEMA, bytes, self.rig_crc, "sinew_motion")?;
        Ok(self.driver.slot_of(&item.hash))
    }

    fn upload(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        if self.slot(bytes)?.is_some() {
            return Ok(());
        }
        let name = "sinew_motion".to_owned();
        let id = self.driver.ask(PageCommand::Upload { name, slot: None, bytes: bytes.len() })?;
        self.driver.send_show(bytes)?;
        self.answer(id)?.map(|_| ()).map_err(|why| anyhow!(why))
    }

    fn play(&mut self, bytes: &[u8], rounds: u32) -> anyhow::Result<()> {
        let slot = self.slot(bytes)?.context(
            "the board does not have the show, and stores shows only while torque is off: `upload` the show before \
             `arm`",
        )?;
        self.move_by(PageCommand::Play { slot, is_loop: false, rounds })
    }

    /// Stops the rig, and waits until torque is off.
    fn stop(&mut self) -> anyhow::Result<()> {
        self.ask(PageCommand::Stop)?;
        let end = self.driver.now() + STOP_MOST;
        let before = self.report()?.summaries;
        loop {
            let state = self.report_after(before)?.summary.state;
            if matches!(state, State::Off | State::Limp | State::Faulted) {
                return Ok(());
            }
            ensure!(self.driver.now() < end, "torque is still on");
            self.wait()?;
        }
    }

    /// Stops the rig if this program drives it, and has armed or moved it. Otherwise its motion is somebody else's.
    fn close(&mut self) -> anyhow::Result<()> {
        if self.driver.drives() && self.has_moved { self.stop() } else { Ok(()) }
    }
}
