//! The controller's side of numbered messages: executes a command once, in order, and answers every copy of it.

use heapless::Deque;

use crate::message::{
    About, Answer, Command, Hello, Misfit, Numbered, Outcome, Refusal, Stream, Welcome,
};
use crate::window::{Order, Window, WindowCounts};

/// Number of answers that are kept for repeated commands.
const KEPT: usize = 8;

/// Session number of a welcome without a session.
const NO_SESSION: u16 = 0;

/// The session of one host with this controller. A new greeting starts a new session.
///
/// Commands are executed in the order of their numbers. A command that arrives after a higher number is refused: a
/// delayed `Play` must not undo the `Stop` that was sent after it. A host that still wants the command sends it with
/// a new number.
///
/// An `EStop` and a `Stop` are executed for any session and number: anyone who sees danger may end the motion. No
/// other command of a foreign session is executed, not even `Hold`: it would stiffen a rig that somebody guides by
/// hand.
#[derive(Debug, Clone)]
pub struct Session {
    id: u16,
    /// Minor version that both ends support.
    minor: u8,
    /// Number of the greeting; `None` before the first.
    nonce: Option<u32>,
    commands: Window,
    stream: Window,
    answers: Deque<(u16, Outcome), KEPT>,
}

/// The handling of a received command.
#[derive(Debug, Clone, PartialEq)]
pub enum Intake {
    /// Execute the command, then pass its outcome to [`Session::answer`].
    Execute,
    /// Do not execute the command; send this answer.
    Answer(Answer),
}

impl Session {
    /// Creates a session state without a host. Sessions are numbered from the number after `first`. `first` must
    /// differ after each start of the board (a count of starts, or a random number), so that a host from before the
    /// start is not accepted.
    pub const fn new(first: u16) -> Self {
        Self {
            id: first,
            minor: 0,
            nonce: None,
            commands: Window::new(),
            stream: Window::new(),
            answers: Deque::new(),
        }
    }

    /// Answers a greeting. A new greeting gets a new session, and ends the previous one. If `busy`, another host
    /// has the rig, and a new host is refused. The refused host does not learn the number of the current session.
    pub fn hello(&mut self, hello: Hello, about: About, busy: bool) -> Welcome {
        let again = self.nonce == Some(hello.nonce);
        let verdict = match about.protocol.fit(hello.protocol) {
            Ok(_) if busy && !again => Err(Misfit::Busy),
            verdict => verdict,
        };
        if let (Ok(minor), false) = (verdict, again) {
            let id = self.id.wrapping_add(1).max(NO_SESSION.saturating_add(1));
            *self = Self { nonce: Some(hello.nonce), minor, ..Self::new(id) };
        }
        let session = if verdict.is_ok() { self.id } else { NO_SESSION };
        Welcome { nonce: hello.nonce, session, about, verdict }
    }

    /// Decides whether to execute a command, or returns the answer.
    pub fn command(&mut self, command: &Numbered<Command>) -> Intake {
        let Numbered { session, seq, ref item } = *command;
        let refuse =
            |refusal| Intake::Answer(Answer { session, seq, item: Outcome::Refused(refusal) });
        let ends = matches!(item, Command::EStop | Command::Stop);
        if self.nonce.is_none() || session != self.id {
            return if ends { Intake::Execute } else { refuse(Refusal::Session) };
        }
        match self.commands.take(seq) {
            _ if *item == Command::EStop => Intake::Execute,
            order if matches!(order, Order::Fresh { .. }) || ends && order == Order::Late => {
                self.keep(seq, Outcome::Working);
                Intake::Execute
            }
            Order::Late => {
                self.keep(seq, Outcome::Refused(Refusal::Late));
                refuse(Refusal::Late)
            }
            _ => match self.kept(seq) {
                Some(outcome) => Intake::Answer(Answer { session, seq, item: outcome.clone() }),
                None if ends => Intake::Execute,
                None => refuse(Refusal::Forgotten),
            },
        }
    }

    /// Returns the answer with the outcome of a command. If the command is of this session, its answer is kept for
    /// repetitions of the command.
    pub fn answer(&mut self, session: u16, seq: u16, outcome: Outcome) -> Answer {
        if session == self.id && self.nonce.is_some() {
            self.keep(seq, outcome.clone());
        }
        Answer { session, seq, item: outcome }
    }

    /// Classifies an item of a stream by its number; `None` if it is of another session. Only [`Order::Fresh`] proves
    /// that the host is alive, and only it counts for hold-to-run. A [`LiveBuffer`] accepts late frames, too.
    ///
    /// [`LiveBuffer`]: crate::LiveBuffer
    pub fn stream(&mut self, message: &Numbered<Stream>) -> Option<Order> {
        let ours = self.nonce.is_some() && message.session == self.id;
        ours.then(|| self.stream.take(message.seq))
    }

    /// Returns `true` if both ends know the messages of a minor version.
    pub fn speaks(&self, minor: u8) -> bool {
        self.minor >= minor
    }

    /// Returns the number of the session; `None` before the first greeting.
    pub fn id(&self) -> Option<u16> {
        self.nonce.map(|_| self.id)
    }

    /// Returns the counts of received commands and of received stream items in this session.
    pub fn counts(&self) -> (WindowCounts, WindowCounts) {
        (self.commands.counts(), self.stream.counts())
    }

    fn kept(&self, seq: u16) -> Option<&Outcome> {
        self.answers.iter().find(|(kept, _)| *kept == seq).map(|(_, outcome)| outcome)
    }

    fn keep(&mut self, seq: u16, outcome: Outcome) {
        if let Some((_, kept)) = self.answers.iter_mut().find(|(kept, _)| *kept == seq) {
            *kept = outcome;
            return;
        }
        if self.answers.is_full() {
            self.answers.pop_front();
        }
        // There is room: the oldest answer was removed.
        let _ = self.answers.push_back((seq, outcome));
    }
}
