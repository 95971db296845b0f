//! The host's side of numbered messages: sends one command at a time, repeatedly until an answer arrives.

use core::fmt;

use crate::message::{Answer, Command, Numbered, Outcome};

/// Time without an answer after which a command is repeated, ms: the longest frame each way at 115,200 baud, and the
/// same time again for the controller.
const RETRY_MS: u32 = 100;

/// Maximum number of transmissions of a command. If 1 frame in 10 is lost each way, 1 command in 10⁷ gets no answer
/// to any of its transmissions.
const TRIES: u8 = 10;

/// Maximum time of a command until its final answer, ms, even while the controller works on it. The longest work is to
/// erase room for a show: an STM32F446 that erases 8 bits at a time takes up to 4 s for a sector of 128 kB (data sheet,
/// flash memory programming).
const LONGEST_MS: u32 = 60_000;

/// A sender that numbers the commands of a session. The caller supplies the time in ms, which may wrap to 0 after 2³².
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

/// The next action of the host.
#[derive(Debug, Clone, PartialEq)]
pub enum Next {
    /// There is nothing to do.
    Idle,
    /// The answer has not arrived yet.
    Wait,
    /// Send this command again.
    Send(Numbered<Command>),
    /// No answer arrived, or only [`Outcome::Working`] for a minute. Whether the command was executed is unknown:
    /// send a new greeting with a new nonce, and look at the telemetry.
    GaveUp(Numbered<Command>),
}

/// The error that the previous command has no answer yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SenderBusy;

impl fmt::Display for SenderBusy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the command before has no answer yet")
    }
}

impl core::error::Error for SenderBusy {}

impl Sender {
    /// Creates a sender for the session of a [`Welcome`](crate::message::Welcome).
    pub const fn new(session: u16) -> Self {
        Self { session, next_command: 0, next_stream: 0, waiting: None }
    }

    /// Numbers a command. The caller sends it at once.
    ///
    /// # Errors
    /// [`SenderBusy`] while another command has no answer. An e-stop and a stop replace that command.
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

    /// Numbers an item of the stream. The caller sends it at once, and only once.
    pub fn stream<T>(&mut self, item: T) -> Numbered<T> {
        let seq = next(&mut self.next_stream);
        self.number(seq, item)
    }

    /// Returns the action for this time. An e-stop is never given up.
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

    /// Accepts an answer. Returns the outcome if it is the final answer to the waiting command.
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

/// Increments a number, and returns its previous value.
fn next(seq: &mut u16) -> u16 {
    let now = *seq;
    *seq = seq.wrapping_add(1);
    now
}
