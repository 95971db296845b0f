//! A node as a host sees it: messages of the lock-step, and over them the link.

use sinew_link::message::{
    Applied, Block, Command, Hello, Item, Outcome, Stream, ToController, ToHost as Said, Version,
    Welcome,
};
use sinew_link::{Decoder, FRAME_MAX, Sender, encode};
use sinew_qemu_node::limits::LINE_AT_ONCE;
use sinew_qemu_node::message::{End, TakeError, ToHost, ToNode};

use super::emulator::Emulator;
use super::error::QemuError;

/// Steps below the loop at a time. A step takes 64 bytes of the line.
const STEPS: u32 = 8;
/// After so many times without an answer there is none.
const PATIENCE: usize = 1000;

/// A node, and its link.
pub(super) struct Node {
    end: End<Emulator>,
    sender: Sender,
    decoder: Decoder<Said>,
    welcome: Option<Welcome>,
    outcome: Option<Outcome>,
    /// Bytes that it has not taken yet.
    line: Vec<u8>,
    /// It has begun anew.
    has_restarted: bool,
    /// A command is without its answer.
    waits: bool,
    nonce: u32,
}

impl Node {
    pub(super) fn new(emulator: Emulator) -> Self {
        Self {
            end: End::new(emulator),
            sender: Sender::new(0),
            decoder: Decoder::new(),
            welcome: None,
            outcome: None,
            line: Vec::new(),
            has_restarted: false,
            waits: false,
            nonce: 0,
        }
    }

    pub(super) fn put(&mut self, message: &ToNode<'_>) -> Result<(), QemuError> {
        self.end.put(message)
    }

    pub(super) fn take(&mut self) -> Result<ToHost<'_>, QemuError> {
        self.end.take().map_err(|why| match why {
            TakeError::Bytes(why) => why,
            TakeError::Message => QemuError::Version,
        })
    }

    /// Steps below the loop: it takes what waits on the line, and what it says is heard.
    fn below(&mut self) -> Result<(), QemuError> {
        let line: Vec<u8> = self.line.iter().copied().take(LINE_AT_ONCE).collect();
        self.put(&ToNode::Below { now_us: 0, steps: STEPS, line: &line })?;
        let ToHost::Stepped { taken, line, restarts } = self.take()? else {
            return Err(QemuError::Version);
        };
        let said = line.to_vec();
        self.line.drain(..taken);
        self.has_restarted |= restarts;
        let Self { sender, decoder, welcome, outcome, waits, nonce, .. } = self;
        decoder.feed(&said, |message| match message {
            Said::Welcome(said) if said.nonce == *nonce => *welcome = Some(said),
            Said::Answer(answer) => {
                if let Some(answered) = sender.take(&answer) {
                    (*outcome, *waits) = (Some(answered), false);
                }
            }
            _ => {}
        });
        Ok(())
    }

    fn say(&mut self, message: &ToController) {
        let mut out = [0; FRAME_MAX];
        self.line.extend_from_slice(encode(message, &mut out).expect("a frame has room for each"));
    }

    /// Greets it, after each start.
    pub(super) fn connect(&mut self) -> Result<Welcome, QemuError> {
        self.nonce += 1;
        (self.welcome, self.line) = (None, Vec::new());
        // It takes no telemetry, and so it says that it does not acknowledge any.
        let protocol = Version { minor: 1, ..Version::CURRENT };
        let hello = Hello { protocol, nonce: self.nonce };
        self.say(&ToController::Hello(hello));
        for _ in 0..PATIENCE {
            self.below()?;
            if let Some(welcome) = self.welcome {
                self.sender = Sender::new(welcome.session);
                return welcome.verdict.map(|_| welcome).map_err(|_| QemuError::Version);
            }
        }
        Err(QemuError::NoAnswer("a greeting"))
    }

    /// Sends a command, which is taken before the next tick.
    pub(super) fn send(&mut self, command: Command) -> Result<(), QemuError> {
        let busy = |_| QemuError::NoAnswer("the command before");
        // The line loses nothing: nothing is sent again.
        let command = self.sender.send(command, 0).map_err(busy)?;
        self.say(&ToController::Command(command));
        (self.outcome, self.waits) = (None, true);
        Ok(())
    }

    /// Before a tick: it hears its host, and takes all that waits.
    pub(super) fn beat(&mut self) -> Result<(), QemuError> {
        let beat = self.sender.stream(Stream::Heartbeat);
        self.say(&ToController::Stream(beat));
        while !self.line.is_empty() {
            self.below()?;
        }
        Ok(())
    }

    /// Behind a tick: the answer to its command.
    pub(super) fn hear_answer(&mut self) -> Result<(), QemuError> {
        if !self.waits {
            return Ok(());
        }
        self.below()?;
        match self.outcome.take() {
            // What the controller in process refuses this one must refuse, too: their states tell.
            Some(Outcome::Refused(_) | Outcome::Applied(_) | Outcome::Limited(..)) => Ok(()),
            _ => Err(QemuError::NoAnswer("a command")),
        }
    }

    fn ask(&mut self, command: Command) -> Result<Outcome, QemuError> {
        self.send(command)?;
        for _ in 0..PATIENCE {
            self.below()?;
            if let Some(outcome) = self.outcome.take() {
                return Ok(outcome);
            }
        }
        Err(QemuError::NoAnswer("a command"))
    }

    /// An upload, block by block, to its end. `what`: as a message names it.
    pub(super) fn upload(
        &mut self,
        what: &'static str,
        item: &Item,
        content: &[u8],
    ) -> Result<(), QemuError> {
        let mut command = Command::BeginUpload(item.clone());
        loop {
            let next = match self.ask(command)? {
                Outcome::Applied(Applied::Upload { next }) => next,
                Outcome::Applied(Applied::Stored(_)) => return Ok(()),
                Outcome::Refused(refusal) => return Err(QemuError::Refused { what, refusal }),
                _ => return Err(QemuError::NoAnswer("an upload")),
            };
            command = match content.get(next as usize..) {
                None | Some([]) => Command::EndUpload,
                Some(rest) => {
                    let bytes = rest.chunks(sinew_link::message::BLOCK_MAX).next().unwrap_or(&[]);
                    let bytes = bytes.try_into().expect("it is a block");
                    Command::UploadBlock(Block { offset: next, bytes })
                }
            };
        }
    }

    /// Behind another rig or other settings it begins anew.
    pub(super) fn restart(&mut self) -> Result<Welcome, QemuError> {
        for _ in 0..PATIENCE {
            if std::mem::take(&mut self.has_restarted) {
                return self.connect();
            }
            self.below()?;
        }
        Err(QemuError::NoAnswer("an upload"))
    }
}
