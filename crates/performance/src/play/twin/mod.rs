//! The controller's twin: the node that boards run, as an image in QEMU, on the same servos.
//!
//! ```text
//! Node: rig, settings, show, commands, over the link ──> image ──> packets of each line ──> simulated servos
//!                                                          ║ the same?                         │ answers, to both
//!                                   controller in process ─╨─ Tally, Recorder  <───────────────┘
//! ```
//! What goes over the wires is the image's. The controller in process hears the same answers and gets the same commands
//! in the same ticks, and all that the two say is compared: each packet, and in each tick state, commanded pose,
//! efforts and errors, bit for bit. So tables and recordings, which are made of the one in process, are of both.

mod built_in;
mod emulator;
mod error;
mod node;
#[cfg(test)]
mod tests;
mod twinned;

pub use emulator::Emulator;
pub use error::TwinError;
pub(super) use twinned::Twinned;

use sinew_firmware::supervisor::{Command, Feed, State};
use sinew_link::message::{Command as Linked, Feed as LinkedFeed};
use sinew_qemu_node::message::{LoopMessage, Packets, ToHost, ToNode};
use sinew_qemu_node::node::{bits, commanded};
use sinew_servo_bus::Request;

use super::{Drive, Loop, Parts};
use emulator::IMAGE;
use node::Node;

/// The image, and how far it is the same.
pub struct Twin {
    node: Node,
    tick_us: u64,
    ticks: u64,
    packets: u64,
    /// What went wrong first: it stays.
    failed: Option<TwinError>,
}

impl Twin {
    /// Gives a node rig, show and settings, with which it begins anew, just before the servos' power comes on.
    ///
    /// # Errors
    /// [`TwinError`] says what the node refuses.
    pub fn new(emulator: Emulator, parts: &Parts, show: &[u8]) -> Result<Self, TwinError> {
        if let Some(part) = parts.servos.iter().find(|part| part.drive == Drive::Pulses) {
            return Err(TwinError::Pulses(part.own.name.clone()));
        }
        let mut node = Node::new(emulator);
        built_in::tell(&mut node, parts)?;
        built_in::upload(&mut node, parts, show)?;
        // The first tick lets it in.
        node.send(Linked::LoadShow { slot: 0 })?;
        let tick_us = parts.tick_us().into();
        Ok(Self { node, tick_us, ticks: 0, packets: 0, failed: None })
    }

    /// Ticks and packets that were compared.
    pub fn compared(&self) -> [u64; 2] {
        [self.ticks, self.packets]
    }

    /// Whether both have said the same until now.
    ///
    /// # Errors
    /// What was different first, or why there is no twin any more.
    pub fn check(&self) -> Result<(), TwinError> {
        self.failed.clone().map_or(Ok(()), Err)
    }

    /// What is left of it works no more once something has failed.
    fn attempt(&mut self, act: impl FnOnce(&mut Self) -> Result<(), TwinError>) {
        if self.failed.is_none() {
            self.failed = act(self).err();
        }
    }

    fn same<T: PartialEq>(&self, what: &'static str, twin: &T, own: &T) -> Result<(), TwinError> {
        let tick = self.ticks;
        (twin == own).then_some(()).ok_or(TwinError::Differs { tick, what, image: IMAGE })
    }

    /// A tick begins; the host is heard, as in process.
    pub(super) fn begin(&mut self, command: Option<Command>) {
        self.attempt(|twin| {
            if let Some(command) = command {
                twin.node.send(linked(command).ok_or(TwinError::Command(command))?)?;
            }
            twin.node.beat()?;
            let now_us = twin.now_us();
            twin.node.put(&ToNode::Tick { now_us, is_stopped: false })?;
            match twin.node.take()? {
                ToHost::Exchange => Ok(()),
                _ => Err(TwinError::NoLoop),
            }
        });
    }

    fn now_us(&self) -> u64 {
        self.ticks * self.tick_us
    }

    /// What goes over a line next. `own`: what goes in process, its bytes in `out`, where the twin's come to lie.
    fn planned(
        &mut self,
        question: &ToNode<'_>,
        own: Option<Request>,
        out: &mut [u8],
    ) -> Option<Request> {
        let mut planned = own;
        self.attempt(|twin| {
            let to_send = own.map(|own| (own, out[..own.len].to_vec()));
            twin.node.put(question)?;
            let ToHost::Planned(packets) = twin.node.take()? else {
                return Err(TwinError::Version);
            };
            let read = packets.map(|Packets { bytes, reply_len, time_us }| {
                out[..bytes.len()].copy_from_slice(bytes);
                (Request { len: bytes.len(), reply_len, time_us }, bytes.to_vec())
            });
            planned = read.as_ref().map(|(request, _)| *request);
            twin.packets += u64::from(planned.is_some());
            twin.same("packets", &read, &to_send)
        });
        planned
    }

    /// Servos of a line have said something. `own`: whether that is all, for the one in process.
    fn said(&mut self, line: usize, bytes: &[u8], own: bool) -> bool {
        let mut is_complete = own;
        self.attempt(|twin| {
            twin.node.put(&ToNode::Said { line, bytes })?;
            let ToHost::IsComplete(answer) = twin.node.take()? else {
                return Err(TwinError::Version);
            };
            is_complete = answer;
            twin.same("what answers are awaited", &answer, &own)
        });
        is_complete
    }

    /// The tick is over, after `took_us`. `is_whole`: so it was in process.
    pub(super) fn end(&mut self, took_us: u32, is_whole: bool, controller: &Loop<'_>) {
        self.attempt(|twin| {
            let now_us = twin.now_us() + u64::from(took_us);
            twin.node.put(&ToNode::Over { now_us })?;
            let ToHost::Ticked(Some(of_loop)) = twin.node.take()? else {
                return Err(TwinError::Version);
            };
            let LoopMessage { is_fed, outputs, state, faults, commanded: numbers } = of_loop;
            let state = State::ALL.get(usize::from(state)).copied();
            let numbers = numbers.to_vec();
            let own: Vec<u8> = commanded(controller).flat_map(f32::to_le_bytes).collect();
            let report = controller.report();
            twin.same("the state", &state, &Some(report.state))?;
            twin.same("faults", &faults, &[report.present, report.latched].map(bits))?;
            twin.same("whether torque is on", &outputs, &controller.permission().torque)?;
            twin.same("whether the tick is whole", &is_fed, &is_whole)?;
            twin.same("poses, efforts and errors", &numbers, &own)?;
            twin.ticks += 1;
            twin.node.hear_answer()
        });
    }
}

/// The link's word for a command.
fn linked(command: Command) -> Option<Linked> {
    let feed = |feed| match feed {
        Feed::Show => LinkedFeed::Show,
        Feed::Live => LinkedFeed::Live,
        Feed::Jog => LinkedFeed::Jog,
    };
    Some(match command {
        Command::EStop => Linked::EStop,
        Command::Arm => Linked::Arm,
        Command::Disarm => Linked::Disarm,
        Command::Play(from) => Linked::Play(feed(from)),
        Command::Hold => Linked::Hold,
        Command::Stop => Linked::Stop,
        Command::ClearFaults => Linked::ClearFaults,
        _ => return None,
    })
}
