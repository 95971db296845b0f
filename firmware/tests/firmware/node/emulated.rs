//! The node of `sinew-qemu-node` in place of the board in process, with the same line, servos and clock. It runs in a
//! thread of the test, or as an image in QEMU.

use std::convert::Infallible;
use std::io::{BufReader, Read, Write, pipe};
use std::process::{Child, Command as Program, Stdio};
use std::{env, panic, thread};

use sinew_firmware::controller::Wire;
use sinew_firmware::supervisor::{Fault, FaultSet, State};
use sinew_link::message::{Command, Feed, Kind as ItemKind, TelemetryParts, TelemetrySetting};
use sinew_qemu_node::built_in::BuiltIn;
use sinew_qemu_node::limits::{FLASH_LEN, LINE_AT_ONCE};
use sinew_qemu_node::message::{Bytes, End, LoopMessage, Packets, ToHost, ToNode};
use sinew_qemu_node::node;

use super::hardware::Servos;
use super::line::BAD;
use super::stored::{item, rig, settings, show};
use super::test_rig::{HASH_BEGIN, Kind, SERVOS, hash_of};
use super::world::World;

/// Environment variable with the image's path.
const IMAGE: &str = "SINEW_NODE_IMAGE";

/// A node at the other end of two pipes.
pub(crate) struct Emulated {
    kind: Kind,
    node: End<Pipes<Box<dyn Read>, Box<dyn Write>>>,
    /// State of the node's loop.
    pub(crate) state: Option<State>,
    /// Present faults and latched faults, as bits.
    faults: [u32; 2],
    /// The QEMU process, if the node runs in QEMU.
    qemu: Option<Child>,
}

struct Pipes<R, W> {
    from: R,
    to: W,
}

impl<R: Read, W: Write> Bytes for Pipes<R, W> {
    type Error = Infallible;
    fn read(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.from.read_exact(bytes).map_err(|_| left())
    }
    fn write(&mut self, bytes: &[u8]) -> Result<(), Infallible> {
        self.to.write_all(bytes).map_err(|_| left())
    }
}

/// Ends the test or its node because the other end is gone. The other end has reported the reason.
fn left() -> ! {
    panic::resume_unwind(Box::new("the other end has left"))
}

impl Emulated {
    /// Starts a node in a thread.
    pub(crate) fn here(kind: Kind) -> Self {
        let [(from_node, to_host), (from_host, to_node)] = [pipe().unwrap(), pipe().unwrap()];
        let run = || {
            let host = Pipes { from: BufReader::new(from_host), to: to_host };
            let (mut flash, mut lent) = (vec![0; FLASH_LEN], vec![0; 1 << 20]);
            node::run(&mut End::new(host), FaultSet::EMPTY, &mut flash, &mut lent)
        };
        // The node has an image's capacities, all on the stack.
        thread::Builder::new().stack_size(64 << 20).spawn(run).unwrap();
        Self::new(kind, Box::new(from_node), Box::new(to_node), None)
    }

    /// Starts the image in QEMU.
    pub(crate) fn in_qemu(kind: Kind) -> Self {
        let image = env::var_os(IMAGE)
            .unwrap_or_else(|| panic!("{IMAGE} is not set: run this test with `cargo xtask node`"));
        let mut qemu = Program::new("qemu-system-arm")
            .args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none"])
            .args(["-serial", "none", "-semihosting-config", "enable=on,target=native"])
            .arg("-kernel")
            .arg(image)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("QEMU can be started");
        let (from, to) = (qemu.stdout.take().unwrap(), qemu.stdin.take().unwrap());
        Self::new(kind, Box::new(from), Box::new(to), Some(qemu))
    }

    fn new(kind: Kind, from: Box<dyn Read>, to: Box<dyn Write>, qemu: Option<Child>) -> Self {
        let from = Box::new(BufReader::new(from));
        let mut node = End::new(Pipes { from: from as Box<dyn Read>, to });
        node.put(&ToNode::PowerOn(BuiltIn::Arm(kind))).unwrap();
        Self { kind, node, state: None, faults: [0; 2], qemu }
    }

    /// Makes the node's program panic; then the node starts again.
    pub(crate) fn panic(&mut self) {
        self.put(&ToNode::Panic);
        self.put(&ToNode::PowerOn(BuiltIn::Arm(self.kind)));
        (self.state, self.faults) = (None, [0; 2]);
    }

    /// Returns whether a fault is present, and whether it is latched.
    pub(crate) fn has(&self, fault: Fault) -> [bool; 2] {
        self.faults.map(|faults| faults & node::bit(fault) != 0)
    }

    fn put(&mut self, message: &ToNode<'_>) {
        self.node.put(message).unwrap();
    }

    fn take(&mut self) -> ToHost<'_> {
        self.node.take().unwrap()
    }

    /// Runs a tick of a world, from `base_s` to `end_s` of its bench.
    pub(crate) fn tick(&mut self, world: &mut World, [base_s, end_s]: [f64; 2]) {
        let (now_us, is_stopped) = (world.pins.clock_us.get(), world.pins.is_stopped);
        self.put(&ToNode::Tick { now_us, is_stopped });
        match self.take() {
            ToHost::Exchange => self.exchange(world, [base_s, end_s]),
            ToHost::Ticked(None) => {}
            other => panic!("{other:?} in place of a tick"),
        }
        self.below(world);
    }

    /// Exchanges a tick's packets with the bus, and reads the result.
    fn exchange(&mut self, world: &mut World, [base_s, end_s]: [f64; 2]) {
        let start_us = world.pins.clock_us.get();
        let World { bench, hash, pins, commanded, told, sent, late_us, .. } = world;
        let (clock_us, late_us) = (pins.clock_us.clone(), *late_us);
        let mut wire =
            Servos { bench, base_s, end_s, clock_us, start_us, late_us, hash, told, sent };
        self.put(&ToNode::Plan { line: 0 });
        loop {
            let ToHost::Planned(planned) = self.take() else { panic!("nothing is planned") };
            let Some(Packets { bytes, time_us, .. }) = planned else { break };
            let bytes = bytes.to_vec();
            wire.exchange(&bytes, time_us, |bytes| {
                self.put(&ToNode::Said { line: 0, bytes });
                match self.take() {
                    ToHost::IsComplete(is_complete) => is_complete,
                    other => panic!("{other:?} in an exchange"),
                }
            });
            self.put(&ToNode::PlanMore { line: 0, left_us: wire.left_us() });
        }
        self.put(&ToNode::Over { now_us: pins.clock_us.get() });
        let of_loop = match self.take() {
            ToHost::Ticked(Some(of_loop)) => of_loop,
            other => panic!("{other:?} behind an exchange"),
        };
        let LoopMessage { is_fed, outputs, state, faults, commanded: numbers } = of_loop;
        assert!(is_fed, "a tick was not whole");
        pins.fed += 1;
        pins.outputs = outputs;
        hash_of(commanded, numbers);
        (self.state, self.faults) = (Some(State::ALL[usize::from(state)]), faults);
    }

    /// Runs the steps of the background task.
    fn below(&mut self, world: &mut World) {
        let now_us = world.now_us();
        let World { host, pins, starts, steps, .. } = world;
        assert!(host.reads, "the line takes all");
        let line: Vec<u8> = host.there.bytes.iter().copied().take(LINE_AT_ONCE).collect();
        self.put(&ToNode::Below { now_us, steps: *steps, line: &line });
        let ToHost::Stepped { taken, line, restarts } = self.take() else { panic!("no step") };
        host.give(taken);
        host.take(line, now_us);
        if restarts {
            *starts += 1;
            pins.outputs = false;
            self.state = None;
        }
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        if let Some(qemu) = &mut self.qemu {
            // The process may have ended by itself.
            let _ = qemu.kill();
            let _ = qemu.wait();
        }
    }
}

/// Record of everything that a node did, from its first tick to its last.
#[derive(Debug, PartialEq)]
struct Run {
    ticks: u64,
    fed: u64,
    starts: u16,
    /// Hash of all bytes on the bus, in their order.
    bus: String,
    /// Hashes of the bytes that the node received from its line, and of those that it sent there.
    line: [String; 2],
    /// Hash of everything that the loop has commanded.
    commanded: String,
}

/// Runs a node from a blank board to a performance, an emergency stop in the next one, and a restart with the data in
/// flash.
fn performance(mut world: World) -> Run {
    let kind = world.kind;
    world.connect();
    let (bytes, crc) = rig(kind);
    world.upload(&item(ItemKind::Rig, &bytes, 0), &bytes);
    world.connect();
    let settings = settings(kind).with(6, 8.0).unwrap().bytes();
    world.upload(&item(ItemKind::Settings, &settings, crc), &settings);
    world.connect();
    let show = show(kind, 4, false);
    world.upload(&item(ItemKind::Show, &show, crc), &show);
    world.ask(Command::LoadShow { slot: 0 });
    world
        .ask(Command::SetTelemetry(TelemetrySetting { rate_hz: 20.0, parts: TelemetryParts::ALL }));
    world.until(State::Limp, 2.0);
    for is_stopped in [false, true] {
        world.arm();
        world.until(State::Holding, 3.0);
        assert_eq!(world.servos_on(), SERVOS);
        world.ask(Command::Play(Feed::Show));
        world.until(State::Playing, 1.0);
        if is_stopped {
            world.run(1.0);
            world.pins.is_stopped = true;
            world.until(State::Faulted, 0.1);
        } else {
            world.until(State::Holding, 20.0);
            world.ask(Command::Stop);
            world.until(State::Limp, 40.0);
            // The rig comes to rest.
            world.run(3.0);
        }
    }
    world.run(1.0);
    assert_eq!((world.servos_on(), world.pins.outputs), (0, false));
    // Its one message may be lost on the line.
    assert!(world.has(Fault::EStop)[1], "{:?}", world.host.faults);
    let setting = sinew_link::message::Value::Number(7.0);
    world.ask(Command::WriteSetting { key: 7, value: setting });
    world.connect();
    world.run(0.5);

    let hex = |hash: u64| format!("{hash:016x}");
    let hashes = [world.hash, world.commanded, world.host.hashes[0], world.host.hashes[1]];
    assert!(!hashes.contains(&HASH_BEGIN), "nothing was said");
    Run {
        ticks: world.ticks,
        fed: world.pins.fed,
        starts: world.starts,
        bus: hex(world.hash),
        line: world.host.hashes.map(hex),
        commanded: hex(world.commanded),
    }
}

/// Compares nodes with the board in process, over a bad line: an arm in current mode, one in PWM mode, and one in
/// position mode.
fn all_say_the_same(emulated: impl Fn(Kind) -> Emulated) {
    for (kind, seed) in [(Kind::Current, 7), (Kind::Voltage, 5), (Kind::Position, 11)] {
        let in_process = performance(World::new(kind, BAD, seed));
        let mut world = World::new(kind, BAD, seed);
        world.emulated = Some(emulated(kind));
        let there = performance(world);
        println!("{kind:?}, in process and there: {there:#?}");
        assert_eq!(there, in_process, "{kind:?}");
    }
}

#[test]
fn a_node_over_messages_is_the_board_in_process() {
    all_say_the_same(Emulated::here);
}

#[test]
#[ignore = "needs the image that `cargo xtask node` builds"]
fn the_image_in_qemu_is_the_board_in_process() {
    all_say_the_same(Emulated::in_qemu);
}
