//! Executes commands from the Unix socket; or, without a console, a single command.

use std::fmt;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::time::Duration;

use sinew_board_client::{ClientError, Line};
use sinew_link::message::{Command, State};

use super::act::{AGAIN, Act, READY, passes};
use super::{Hub, Refused};
use crate::local::{CUTS, Reply, Request, Role, STOPS};
use crate::server::PageId;

/// Command number of the request that the program itself executes, without a socket.
const OWN: u64 = 0;
/// Units of a jog in SI units: 1 deg in rad, and 1 mm in m.
const UNITS: [f64; 2] = [std::f64::consts::PI / 180.0, 1e-3];

/// Kind of program that owns a hub. It decides which requests of other commands the hub accepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// A console. Its pages drive; other commands may move the rig while nothing else moves it.
    Console,
    /// A command of this name, which drives the rig. Other commands may stop the rig and watch it.
    Drives(&'static str),
    /// A program in Python, which drives the rig. Other commands may stop the rig and watch it.
    Python,
    /// A command that only watches. It closes its port if another command asks for it.
    Watches,
}

impl fmt::Display for Owner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Console => f.write_str("`sinew console`"),
            Self::Drives(name) => write!(f, "`sinew {name}`"),
            Self::Python => f.write_str("a program of Python"),
            Self::Watches => f.write_str("`sinew board monitor`"),
        }
    }
}

/// Requests of other commands to which the owner of a hub must react.
#[derive(Debug, Default)]
pub(super) struct Asked {
    /// Whether another command has stopped the rig.
    pub(super) stopped: bool,
    /// Whether another command needs the port.
    pub(super) yields: bool,
}

/// A program that waits for the end of its motion.
#[derive(Debug)]
pub(super) enum Waiting {
    /// A command in another terminal.
    Command { command: u64, answer: SyncSender<Reply> },
    /// A program that drives. It must keep the wheel, as a page does.
    Driver { page: PageId, id: Option<u64> },
}

impl Waiting {
    pub(super) fn is_command(&self) -> bool {
        matches!(self, Self::Command { .. })
    }
}

impl<L: Line> Hub<'_, L> {
    /// Executes a command of another program. If it moves the rig, the answer follows at the end of the motion.
    pub(super) fn take_request(
        &mut self,
        command: u64,
        request: &Request,
        answer: SyncSender<Reply>,
    ) {
        let done = match request {
            Request::Stop => {
                self.end_all();
                self.bound.stop();
                self.asked.stopped = true;
                self.ask(Command::Stop).map(|_| STOPS.to_owned())
            }
            Request::EStop => {
                self.end_all();
                self.bound.stop();
                self.asked.stopped = true;
                self.ask(Command::EStop).map(|_| CUTS.to_owned())
            }
            Request::Drive if self.owner == Owner::Console => Ok(String::new()),
            Request::Yield => self.give_up_port(),
            Request::Who => {
                let watches = self.owner == Owner::Watches;
                let role = if watches { Role::Watches } else { Role::Drives };
                Ok(role.name().to_owned())
            }
            Request::Drive | Request::Home | Request::Jog { .. }
                if command != OWN && self.owner != Owner::Console =>
            {
                Err(Refused::Other(format!("{} has the board", self.owner)))
            }
            // The thread of the socket answers `Watch`.
            Request::Drive | Request::Watch => Err(Refused::because("it is no command")),
            Request::Home | Request::Jog { .. } => match self.move_for(request) {
                Ok(()) => {
                    self.waiting = Some(Waiting::Command { command, answer });
                    self.tell_roles();
                    return;
                }
                Err(refused) => Err(refused),
            },
        };
        self.reply(&answer, done);
    }

    fn give_up_port(&mut self) -> Result<String, Refused> {
        self.asked.yields = self.owner == Owner::Watches;
        if self.asked.yields {
            return Ok("the port is closed".to_owned());
        }
        Err(Refused::Other(format!(
            "{} has the board; `sinew board monitor` watches it, `sinew stop` stops the rig",
            self.owner
        )))
    }

    fn reply(&self, answer: &SyncSender<Reply>, done: Result<String, Refused>) {
        let (ok, text) = match done {
            Ok(text) => (true, text),
            Err(refused) => (false, format!("refused: {}", self.text(&refused))),
        };
        // Nobody waits if the command has ended.
        let _: Result<(), TrySendError<Reply>> = answer.try_send(Reply { ok, text });
    }

    /// Begins a motion of another program. Fails if the rig moves already.
    fn move_for(&mut self, request: &Request) -> Result<(), Refused> {
        if self.lost.is_some() || self.closing.is_some() {
            return Err(Refused::because("the board does not answer, or the console ends"));
        }
        if self.act.is_some() || self.state() == State::Playing {
            return Err(Refused::because("the rig moves: hold it first"));
        }
        let mut to = self.scene.home.clone();
        if let Request::Jog { joint, by } = request {
            let dof = self.scene.dofs.iter().find(|dof| dof.name == *joint).ok_or_else(|| {
                let names: Vec<&str> = self.scene.dofs.iter().map(|dof| &*dof.name).collect();
                Refused::Other(format!(
                    "there is no joint `{joint}`; there are {}",
                    names.join(", ")
                ))
            })?;
            let coordinate =
                dof.coordinate.ok_or_else(|| Refused::because("it is a ball joint"))?;
            if let Some(why) = self.scene.follows(dof) {
                return Err(Refused::Other(why));
            }
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a board has f32, and the range limits it"
            )]
            let by = (by * UNITS[usize::from(dof.slides)]) as f32;
            let [least, most] = dof.range;
            for (k, own) in to.iter_mut().enumerate() {
                let now = self.wanted(k).or_else(|| self.board.log.q.get(k).copied());
                *own = now.ok_or_else(|| Refused::because("the pose is not known yet"))?;
            }
            let goal = to[coordinate] + by;
            if !(least..=most).contains(&goal) && dof.limited || !goal.is_finite() {
                return Err(Refused::because("this is beyond the range of the joint"));
            }
            to[coordinate] = goal;
            self.scene.follow(&mut to);
        }
        self.travel(&to, Duration::ZERO).map(|_| ())
    }

    /// Lets the answer to a driver follow at the end of its motion, if the motion has begun.
    pub(super) fn answer_at_end(
        &mut self,
        page: PageId,
        id: Option<u64>,
        begun: Result<String, Refused>,
    ) -> Option<Result<String, Refused>> {
        if begun.is_err() {
            return Some(begun);
        }
        self.waiting = Some(Waiting::Driver { page, id });
        None
    }

    /// Answers a waiting program when its motion is over.
    pub(super) fn go_on_waiting(&mut self) {
        if matches!(self.act, Some(Act::Journey(_) | Act::Show(_))) {
            return;
        }
        let Some(waiting) = self.waiting.take() else { return };
        let ended = || {
            Err(match self.lost {
                None => format!("the motion was ended: the rig is {}", self.state()),
                Some(_) => "the motion was ended: the board does not answer".to_owned(),
            })
        };
        let done = self.arrived.clone().unwrap_or_else(ended).map_err(Refused::Other);
        match waiting {
            Waiting::Command { answer, .. } => self.reply(&answer, done),
            Waiting::Driver { page, id: Some(id) } => self.answer(page, id, done),
            Waiting::Driver { id: None, .. } => {}
        }
        self.tell_roles();
    }

    /// Holds the rig if this command was waiting: the program that gave it has ended.
    pub(super) fn forget_waiting(&mut self, gone: u64) {
        let is_it = |waiting: &mut Waiting| matches!(waiting, Waiting::Command { command, .. } if *command == gone);
        if self.waiting.take_if(is_it).is_some() {
            let _ = self.hold();
            self.tell_roles();
        }
    }

    /// Executes a single command on a board without a console. For a motion, arms the rig first and stops it
    /// afterwards.
    pub(crate) fn execute(
        mut self,
        request: &Request,
        stops: &dyn Fn() -> u32,
    ) -> Result<Reply, ClientError> {
        self.begin()?;
        let (answer, answers) = sync_channel(1);
        let mut reply = None;
        if matches!(request, Request::Home | Request::Jog { .. })
            && let Err(refused) = self.arm_now(stops)
        {
            let text = format!("refused: {}", self.text(&refused));
            reply = Some(Reply { ok: false, text });
        } else {
            self.take_request(OWN, request, answer);
        }
        while reply.is_none() && stops() == 0 {
            self.turn()?;
            reply = answers.try_recv().ok();
        }
        // After an e-stop there is nothing to wait for.
        while *request != Request::EStop && self.close(stops().max(1)).is_none() {
            self.turn()?;
        }
        Ok(reply.unwrap_or_else(|| Reply { ok: false, text: "stopped by a signal".to_owned() }))
    }

    /// Arms the rig as soon as the board allows it, and waits until it holds.
    fn arm_now(&mut self, stops: &dyn Fn() -> u32) -> Result<(), Refused> {
        let end = self.now() + READY;
        while let Err(refused) = self.ask(Command::Arm) {
            if !passes(&refused) || self.now() >= end {
                return Err(refused);
            }
            self.wait(AGAIN)?;
            self.check_stops(stops)?;
        }
        let before = self.board.log.summaries;
        while self.board.log.summaries < before + 2 || self.state() == State::Arming {
            self.wait(Duration::ZERO)?;
            self.check_stops(stops)?;
        }
        match self.state() {
            State::Holding => Ok(()),
            state => Err(Refused::Other(format!("the rig is {state}"))),
        }
    }

    /// Fails if another terminal has stopped the rig, or a signal has asked this program to end.
    fn check_stops(&self, stops: &dyn Fn() -> u32) -> Result<(), Refused> {
        if self.asked.stopped {
            return Err(Refused::because("another terminal has stopped the rig"));
        }
        if stops() > 0 { Err(Refused::because("stopped by a signal")) } else { Ok(()) }
    }

    /// Serves the board for a time.
    fn wait(&mut self, time: Duration) -> Result<(), Refused> {
        let end = self.now() + time;
        loop {
            self.turn().map_err(|error| Refused::Other(error.to_string()))?;
            if self.now() >= end {
                return Ok(());
            }
        }
    }
}
