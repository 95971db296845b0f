//! A host: it repeats commands until they are answered, and handles uploads, heartbeats and telemetry.

use sinew_link::message::{
    Applied, Block, Command, FaultRecord, Hello, Item, Numbered, Outcome, SnapshotPart, Stream,
    Summary, ToController, ToHost, Version, Welcome,
};
use sinew_link::{Decoder, FRAME_MAX, Next, Sender, encode};

use super::line::{Line, Trouble};
use super::test_rig::{HASH_BEGIN, hash_of};

pub(crate) struct Host {
    pub(crate) sender: Sender,
    decoder: Decoder<ToHost>,
    nonce: u32,
    pub(crate) welcome: Option<Welcome>,
    hello_due_us: u64,
    beat_due_us: u64,
    /// Whether the host sends heartbeats.
    pub(crate) beats: bool,
    /// Whether the host reads the controller's messages.
    pub(crate) reads: bool,
    /// Whether the wire from the controller is dead.
    pub(crate) is_deaf: bool,
    /// Number of the newest telemetry frame.
    heard: Option<u16>,
    pub(crate) outcome: Option<Outcome>,
    pub(crate) summaries: Vec<Summary>,
    pub(crate) parts: [u32; 6],
    pub(crate) faults: Vec<FaultRecord>,
    /// Messages to another program.
    pub(crate) others: Vec<ToHost>,
    /// Bytes of a frame that is not complete yet.
    cut: Vec<u8>,
    /// The line to the controller, and the line from it.
    pub(crate) there: Line,
    pub(crate) back: Line,
    /// Hashes of all bytes that the controller has received and of all that it has sent, see [`hash_of`].
    pub(crate) hashes: [u64; 2],
}

impl Host {
    pub(crate) fn new(trouble: Trouble, seed: u64) -> Self {
        Self {
            sender: Sender::new(0),
            decoder: Decoder::new(),
            nonce: seed as u32,
            welcome: None,
            hello_due_us: 0,
            beat_due_us: 0,
            beats: true,
            reads: true,
            is_deaf: false,
            heard: None,
            outcome: None,
            summaries: Vec::new(),
            parts: [0; 6],
            faults: Vec::new(),
            others: Vec::new(),
            cut: Vec::new(),
            there: Line::new(trouble, seed),
            back: Line::new(trouble, seed ^ 1),
            hashes: [HASH_BEGIN; 2],
        }
    }

    /// Makes the host send a new hello in its next step.
    pub(crate) fn greet(&mut self) {
        self.nonce = self.nonce.wrapping_add(1);
        self.welcome = None;
        self.hello_due_us = 0;
    }

    pub(crate) fn send(&mut self, message: &ToController, now_us: u64) {
        let mut out = [0; FRAME_MAX];
        let frame = encode(message, &mut out).unwrap();
        self.there.send(frame, now_us);
    }

    pub(crate) fn stream(&mut self, stream: Stream, now_us: u64) {
        let numbered = self.sender.stream(stream);
        self.send(&ToController::Stream(numbered), now_us);
    }

    /// Sends a heartbeat, with the number of the newest telemetry frame.
    pub(crate) fn beat(&mut self, now_us: u64) {
        self.stream(self.heard.map_or(Stream::Heartbeat, Stream::Heard), now_us);
    }

    /// Sends a command; [`Self::outcome`] receives its answer.
    pub(crate) fn ask(&mut self, command: Command, now_us: u64) {
        self.outcome = None;
        let command = self.sender.send(command, now_us as u32 / 1000).unwrap();
        self.send(&ToController::Command(command), now_us);
    }

    /// Takes `count` bytes from the line to the controller, and adds them to their hash.
    pub(crate) fn give(&mut self, count: usize) -> Vec<u8> {
        let bytes: Vec<u8> = self.there.bytes.drain(..count).collect();
        hash_of(&mut self.hashes[0], &bytes);
        bytes
    }

    /// Adds the controller's bytes to their hash, and sends them as frames on the line to the host.
    pub(crate) fn take(&mut self, bytes: &[u8], now_us: u64) {
        hash_of(&mut self.hashes[1], bytes);
        if self.is_deaf {
            return self.cut.clear();
        }
        for byte in bytes {
            self.cut.push(*byte);
            if *byte == 0 && self.cut.len() > 1 {
                let frame = std::mem::take(&mut self.cut);
                self.back.send(&frame, now_us);
            }
        }
    }

    pub(crate) fn step(&mut self, now_us: u64) {
        self.there.arrive(now_us);
        self.back.arrive(now_us);
        let bytes: Vec<u8> = self.back.bytes.drain(..).collect();
        let mut messages = vec![];
        self.decoder.feed(&bytes, |message| messages.push(message));
        for message in messages {
            match message {
                ToHost::Welcome(welcome) if welcome.nonce == self.nonce => {
                    if self.welcome.is_none() {
                        self.sender = Sender::new(welcome.session);
                        self.heard = None;
                    }
                    self.welcome = Some(welcome);
                }
                ToHost::Answer(answer) => {
                    if let Some(outcome) = self.sender.take(&answer) {
                        self.outcome = Some(outcome);
                    } else {
                        self.others.push(ToHost::Answer(answer));
                    }
                }
                ToHost::Fault(fault) => self.faults.push(fault),
                ToHost::Telemetry(telemetry) => {
                    self.heard = Some(telemetry.seq);
                    let part = match telemetry.part {
                        SnapshotPart::Summary(summary) => {
                            self.summaries.push(summary);
                            0
                        }
                        SnapshotPart::Pose { .. } => 1,
                        SnapshotPart::Dofs { .. } => 2,
                        SnapshotPart::Servos { .. } => 3,
                        SnapshotPart::Targets { .. } => 4,
                        SnapshotPart::Supplies { .. } => 5,
                    };
                    self.parts[part] += 1;
                }
                ToHost::Welcome(_) => self.others.push(message),
            }
        }
        if self.welcome.is_none() {
            if now_us >= self.hello_due_us {
                self.hello_due_us = now_us + 50_000;
                let hello = Hello { protocol: Version::CURRENT, nonce: self.nonce };
                self.send(&ToController::Hello(hello), now_us);
            }
            return;
        }
        match self.sender.poll(now_us as u32 / 1000) {
            Next::Send(command) => self.send(&ToController::Command(command), now_us),
            Next::GaveUp(Numbered { item, .. }) => panic!("no answer to {item:?}"),
            Next::Idle | Next::Wait => {}
        }
        if self.beats && now_us >= self.beat_due_us {
            self.beat_due_us = now_us + 20_000;
            self.beat(now_us);
        }
    }
}

/// Returns the next command of an upload, by the answer to the previous one.
pub(crate) fn next_of_upload(item: &Item, content: &[u8], outcome: Option<&Outcome>) -> Command {
    match outcome {
        None => Command::BeginUpload(item.clone()),
        Some(Outcome::Applied(Applied::Upload { next })) if *next == item.length => {
            Command::EndUpload
        }
        Some(Outcome::Applied(Applied::Upload { next })) => {
            let from = *next as usize;
            let to = content.len().min(from + 256);
            let bytes = heapless::Vec::from_slice(&content[from..to]).unwrap();
            Command::UploadBlock(Block { offset: *next, bytes })
        }
        other => panic!("{other:?}"),
    }
}
