//! The host's side of numbers: one command at a time, again and again until there is an answer.

use core::fmt;

use crate::message::{Answer, Command, Numbered, Outcome};

/// How long to wait for an answer before a command is sent again, ms: the longest frame each way at 115,200 baud, and
/// as much for the controller.
const RETRY_MS: u32 = 100;

/// How often a command is sent. With one frame in ten lost each way, all are lost once in 10⁷ commands.
const TRIES: u8 = 10;

/// How long a command may be under way in all, ms, also if it is being done. The longest work is to erase room for a
/// show: an STM32F446 takes up to 4 s for a sector of 128 kB (data sheet, flash memory programming).
const LONGEST_MS: u32 = 60_000;

/// Numbers the commands of a session. Time is the caller's, in ms; it may begin at 0 again after 2³².
#[derive(Debug, Clone)]
pub struct Sender {
    session: u16,
    next_command: u16,
    next_stream: u16,
    waiting: Option<Waiting>,
}

#[derive(Debug, Clone)]
struct Waiting {
    command: Numbered<Command>,
    first_ms: u32,
    sent_ms: u32,
    tries: u8,
}

/// What to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Next {
    /// There is nothing to do.
    Idle,
    /// The answer is not there yet.
    Wait,
    /// Send this again.
    Send(Numbered<Command>),
    /// No answer came, or none but [`Outcome::Working`] for a minute. Whether the command was executed is not known:
    /// say hello with a new nonce, and look at the telemetry.
    GaveUp(Numbered<Command>),
}

/// A command is still without its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SenderBusy;

impl fmt::Display for SenderBusy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the command before has no answer yet")
    }
}

impl core::error::Error for SenderBusy {}

impl Sender {
    /// The session of a [`Welcome`](crate::message::Welcome).
    pub const fn new(session: u16) -> Self {
        Self { session, next_command: 0, next_stream: 0, waiting: None }
    }

    /// Numbers a command, to be sent now.
    ///
    /// # Errors
    /// [`SenderBusy`] while another one has no answer. An e-stop and a stop take its place.
    pub fn send(&mut self, command: Command, now_ms: u32) -> Result<Numbered<Command>, SenderBusy> {
        if self.waiting.is_some() && !matches!(command, Command::EStop | Command::Stop) {
            return Err(SenderBusy);
        }
        let seq = next(&mut self.next_command);
        let command = self.number(seq, command);
        let waiting = command.clone();
        self.waiting =
            Some(Waiting { command: waiting, first_ms: now_ms, sent_ms: now_ms, tries: 1 });
        Ok(command)
    }

    /// Numbers something of the stream, to be sent now, once.
    pub fn stream<T>(&mut self, item: T) -> Numbered<T> {
        let seq = next(&mut self.next_stream);
        self.number(seq, item)
    }

    /// What to do at this time. An e-stop is never given up.
    pub fn poll(&mut self, now_ms: u32) -> Next {
        let Some(waiting) = &mut self.waiting else { return Next::Idle };
        if now_ms.wrapping_sub(waiting.sent_ms) < RETRY_MS {
            return Next::Wait;
        }
        let stop = waiting.command.item == Command::EStop;
        let over = now_ms.wrapping_sub(waiting.first_ms) >= LONGEST_MS;
        if (waiting.tries >= TRIES || over) && !stop {
            return match self.waiting.take() {
                Some(waiting) => Next::GaveUp(waiting.command),
                None => Next::Idle,
            };
        }
        waiting.sent_ms = now_ms;
        waiting.tries = waiting.tries.saturating_add(1);
        Next::Send(waiting.command.clone())
    }

    /// Takes an answer: what came of the command that waits for it, if it is its answer and it is final.
    pub fn take(&mut self, answer: &Answer) -> Option<Outcome> {
        let waiting = self.waiting.as_mut()?;
        if answer.session != waiting.command.session || answer.seq != waiting.command.seq {
            return None;
        }
        if answer.item == Outcome::Working {
            waiting.tries = 1;
            return None;
        }
        self.waiting = None;
        Some(answer.item.clone())
    }

    fn number<T>(&self, seq: u16, item: T) -> Numbered<T> {
        Numbered { session: self.session, seq, item }
    }
}

/// Counts on, and returns the number before.
fn next(seq: &mut u16) -> u16 {
    let now = *seq;
    *seq = seq.wrapping_add(1);
    now
}
