//! The node in QEMU as the peer of the controller in this process: it gets the same answers and commands in each tick,
//! and the outputs of both are compared.

use sinew_firmware::supervisor::{Command, Feed, State};
use sinew_link::message::{Command as Linked, Feed as LinkedFeed};
use sinew_performance::play::{Drive, PeerController, RigController, RigParts};
use sinew_qemu_node::message::{LoopMessage, Packets, ToHost, ToNode};
use sinew_qemu_node::node::{bits, commanded};
use sinew_servo_bus::Request;

use super::emulator::{Emulator, IMAGE};
use super::error::QemuError;
use super::node::Node;
use super::set_up;

/// The controller in the image, compared with the controller in this process.
pub struct QemuController {
    node: Node,
    tick_us: u64,
    ticks: u64,
    packets: u64,
    /// The first failure; after it nothing more is compared.
    failed: Option<QemuError>,
}

impl QemuController {
    /// Uploads rig, show and settings to a node, which restarts with them, just before the servos are powered on.
    ///
    /// # Errors
    /// [`QemuError`] names the part that the node refuses.
    pub fn new(emulator: Emulator, parts: &RigParts, show: &[u8]) -> Result<Self, QemuError> {
        if let Some(part) = parts.servos.iter().find(|part| part.drive == Drive::Pulses) {
            return Err(QemuError::Pulses(part.own.name.clone()));
        }
        let mut node = Node::new(emulator);
        set_up::power_on(&mut node, parts)?;
        set_up::upload(&mut node, parts, show)?;
        // The command is accepted before the first tick.
        node.send(Linked::LoadShow { slot: 0 })?;
        let tick_us = parts.tick_us().into();
        Ok(Self { node, tick_us, ticks: 0, packets: 0, failed: None })
    }

    /// Returns the numbers of ticks and packets that were equal.
    ///
    /// # Errors
    /// The first difference, or the reason why the image does not answer.
    pub fn compared(&self) -> Result<[u64; 2], QemuError> {
        self.failed.clone().map_or(Ok([self.ticks, self.packets]), Err)
    }

    /// Runs an action, unless something has failed before.
    fn attempt(&mut self, act: impl FnOnce(&mut Self) -> Result<(), QemuError>) {
        if self.failed.is_none() {
            self.failed = act(self).err();
        }
    }

    fn same<T: PartialEq>(&self, what: &'static str, image: &T, own: &T) -> Result<(), QemuError> {
        let tick = self.ticks;
        (image == own).then_some(()).ok_or(QemuError::Differs { tick, what, image: IMAGE })
    }

    fn now_us(&self) -> u64 {
        self.ticks * self.tick_us
    }

    /// Asks for packets of a line. `own` describes the packets of the controller in this process, whose bytes
    /// are in `out`. The packets of the image are written to `out`.
    fn packets(
        &mut self,
        question: &ToNode<'_>,
        own: Option<Request>,
        out: &mut [u8],
    ) -> Option<Request> {
        let mut planned = own;
        self.attempt(|image| {
            let to_send = own.map(|own| (own, out[..own.len].to_vec()));
            image.node.put(question)?;
            let ToHost::Planned(packets) = image.node.take()? else {
                return Err(QemuError::Version);
            };
            let read = packets.map(|Packets { bytes, reply_len, time_us }| {
                out[..bytes.len()].copy_from_slice(bytes);
                (Request { len: bytes.len(), reply_len, time_us }, bytes.to_vec())
            });
            planned = read.as_ref().map(|(request, _)| *request);
            image.packets += u64::from(planned.is_some());
            image.same("packets", &read, &to_send)
        });
        planned
    }
}

impl PeerController for QemuController {
    fn begin(&mut self, command: Option<Command>) {
        self.attempt(|image| {
            if let Some(command) = command {
                image.node.send(linked(command).ok_or(QemuError::Command(command))?)?;
            }
            image.node.beat()?;
            let now_us = image.now_us();
            image.node.put(&ToNode::Tick { now_us, is_stopped: false })?;
            match image.node.take()? {
                ToHost::Exchange => Ok(()),
                _ => Err(QemuError::NoLoop),
            }
        });
    }

    fn plan(&mut self, line: usize, own: Request, out: &mut [u8]) -> Request {
        self.packets(&ToNode::Plan { line }, Some(own), out).unwrap_or_default()
    }

    fn plan_more(
        &mut self,
        line: usize,
        left_us: u32,
        own: Option<Request>,
        out: &mut [u8],
    ) -> Option<Request> {
        self.packets(&ToNode::PlanMore { line, left_us }, own, out)
    }

    fn reply(&mut self, line: usize, bytes: &[u8], own: bool) -> bool {
        let mut is_complete = own;
        self.attempt(|image| {
            image.node.put(&ToNode::Said { line, bytes })?;
            let ToHost::IsComplete(answer) = image.node.take()? else {
                return Err(QemuError::Version);
            };
            is_complete = answer;
            image.same("what answers are awaited", &answer, &own)
        });
        is_complete
    }

    fn end(&mut self, took_us: u32, is_whole: bool, own: &RigController<'_>) {
        self.attempt(|image| {
            let now_us = image.now_us() + u64::from(took_us);
            image.node.put(&ToNode::Over { now_us })?;
            let ToHost::Ticked(Some(of_loop)) = image.node.take()? else {
                return Err(QemuError::Version);
            };
            let LoopMessage { is_fed, outputs, state, faults, commanded: numbers } = of_loop;
            let state = State::ALL.get(usize::from(state)).copied();
            let numbers = numbers.to_vec();
            let own_numbers: Vec<u8> = commanded(own).flat_map(f32::to_le_bytes).collect();
            let report = own.report();
            image.same("the state", &state, &Some(report.state))?;
            image.same("faults", &faults, &[report.present, report.latched].map(bits))?;
            image.same("whether torque is on", &outputs, &own.permission().torque)?;
            image.same("whether the tick is whole", &is_fed, &is_whole)?;
            image.same("poses, efforts and errors", &numbers, &own_numbers)?;
            image.ticks += 1;
            image.node.hear_answer()
        });
    }
}

/// Returns the host link's message for a command, if there is one.
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
