//! The controller's side of numbers: a command is executed once, in order, and answered as often as it comes.

use heapless::Deque;

use crate::message::{
    About, Answer, Command, Hello, Misfit, Numbered, Outcome, Refusal, Stream, Welcome,
};
use crate::window::{Order, Window, WindowCounts};

/// How many answers are kept to be given again.
const KEPT: usize = 8;

/// The number of a welcome without a session.
const NO_SESSION: u16 = 0;

/// What one host and this controller have said to each other. A new greeting begins anew.
///
/// Commands are executed in the order of their numbers. One that comes behind a higher one is refused: a `Play` that a
/// line delayed must not undo the `Stop` that was sent after it. Whoever still wants it sends it with a new number.
///
/// An `EStop` and a `Stop` are executed whatever their session and number: whoever sees danger may end the motion. No
/// other command of a stranger is executed. Not `Hold` either: it makes a rig stiff that somebody leads by hand.
#[derive(Debug, Clone)]
pub struct Session {
    id: u16,
    /// The minor version that both speak.
    minor: u8,
    /// The greeting's number; none before the first.
    nonce: Option<u32>,
    commands: Window,
    stream: Window,
    answers: Deque<(u16, Outcome), KEPT>,
}

/// What to do with a command.
#[derive(Debug, Clone, PartialEq)]
pub enum Intake {
    /// Execute it, then say what came of it to [`Session::answer`].
    Execute,
    /// Do not execute it; send this.
    Answer(Answer),
}

impl Session {
    /// No host yet. `first`: the number of the first session, another one after each start of the board (a count of
    /// starts, or a random number), so that a host of before is not taken for one of now.
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

    /// Answers a greeting. A new one gets a new session, and ends the one before. `busy`: another host has the rig now,
    /// and a new one is refused; it is not told the number of the session that is on.
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

    /// Whether to execute a command, or what to answer.
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

    /// What came of the command of this session and number: the answer to send, which is kept for when it comes again.
    pub fn answer(&mut self, session: u16, seq: u16, outcome: Outcome) -> Answer {
        if session == self.id && self.nonce.is_some() {
            self.keep(seq, outcome.clone());
        }
        Answer { session, seq, item: outcome }
    }

    /// How something of a stream stands to what came before; none if it is not of this session. Only
    /// [`Order::Fresh`] shows that the host is alive, and only it counts for hold-to-run. A [`LiveBuffer`] takes late
    /// frames, too.
    ///
    /// [`LiveBuffer`]: crate::LiveBuffer
    pub fn stream(&mut self, message: &Numbered<Stream>) -> Option<Order> {
        let ours = self.nonce.is_some() && message.session == self.id;
        ours.then(|| self.stream.take(message.seq))
    }

    /// Whether both know the messages of a minor version.
    pub fn speaks(&self, minor: u8) -> bool {
        self.minor >= minor
    }

    /// The number of the session; none before the first greeting.
    pub fn id(&self) -> Option<u16> {
        self.nonce.map(|_| self.id)
    }

    /// What came of commands and of the stream, in this session.
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
        // There is room: the oldest one went.
        let _ = self.answers.push_back((seq, outcome));
    }
}
