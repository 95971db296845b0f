//! A node as its host sees it: the messages of the lockstep, and the bytes of the host link inside these messages.

use sinew_link::message::{
    Applied, Block, Command, Hello, Item, Outcome, Stream, ToController, ToHost as Said, Version,
    Welcome,
};
use sinew_link::{Decoder, FRAME_MAX, Sender, encode};
use sinew_qemu_node::limits::LINE_AT_ONCE;
use sinew_qemu_node::message::{End, TakeError, ToHost, ToNode};

use super::emulator::Emulator;
use super::error::QemuError;

/// Steps of the background task per message. A step reads 64 bytes of the link.
const STEPS: u32 = 8;
/// Number of attempts after which the node counts as not answering.
const PATIENCE: usize = 1000;

/// A node, and its host link.
pub(super) struct Node {
    end: End<Emulator>,
    sender: Sender,
    decoder: Decoder<Said>,
    welcome: Option<Welcome>,
    outcome: Option<Outcome>,
    /// Bytes that the node has not read yet.
    line: Vec<u8>,
    /// Whether the node has restarted.
    has_restarted: bool,
    /// Whether a command has no answer yet.
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

    /// Runs steps of the background task: it reads the waiting bytes, and its output is decoded.
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

    /// Greets the node, after each start.
    pub(super) fn connect(&mut self) -> Result<Welcome, QemuError> {
        self.nonce += 1;
        (self.welcome, self.line) = (None, Vec::new());
        // This program receives no telemetry. The older version in the greeting tells the node that this program
        // acknowledges none.
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

    /// Sends a command, which the node accepts before the next tick.
    pub(super) fn send(&mut self, command: Command) -> Result<(), QemuError> {
        let busy = |_| QemuError::NoAnswer("the command before");
        // The link loses nothing, so nothing is sent again.
        let command = self.sender.send(command, 0).map_err(busy)?;
        self.say(&ToController::Command(command));
        (self.outcome, self.waits) = (None, true);
        Ok(())
    }

    /// Sends a heartbeat before a tick, and lets the node read all waiting bytes.
    pub(super) fn beat(&mut self) -> Result<(), QemuError> {
        let beat = self.sender.stream(Stream::Heartbeat);
        self.say(&ToController::Stream(beat));
        while !self.line.is_empty() {
            self.below()?;
        }
        Ok(())
    }

    /// Checks the answer to the last command after a tick.
    pub(super) fn hear_answer(&mut self) -> Result<(), QemuError> {
        if !self.waits {
            return Ok(());
        }
        self.below()?;
        match self.outcome.take() {
            // A refusal is no error here: if only one of the two controllers refuses the command, the comparison of
            // their states shows it.
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

    /// Uploads an item block by block. `what` is the item's name in messages.
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

    /// Waits for the restart after a new rig or new settings, and greets the node again.
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
