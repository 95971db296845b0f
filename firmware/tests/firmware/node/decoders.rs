//! Properties that must be true for any bytes: used by the replay of the corpus, and by the fuzz targets in
//! `tests/fuzz`.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use sinew_firmware::controller::Start;
use sinew_firmware::node::{ControlLoop, NodeSettings};
use sinew_firmware::supervisor::State;
use sinew_link::message::{Command, Feed, Operator, Outcome, ToController};
use sinew_servo_sim::fault::{Fault, FaultKind};

use super::flash::MockFlash;
use super::hardware::Chip;
use super::hostile::{Hostile, check_outputs};
use super::line::Trouble;
use super::stored::{settings as defaults, show};
use super::test_rig::{Kind, figure, setup};
use super::world::World;

const KIND: Kind = Kind::Current;

/// Decodes any bytes as settings. Settings that were read are accepted by a start, and are the same after they are
/// written and read again. Returns whether they were read.
pub(crate) fn settings(bytes: &[u8]) -> bool {
    let defaults = defaults(KIND);
    let Ok(read) = defaults.read(bytes) else { return false };
    let again = defaults.read(&read.bytes()).expect("it was read before");
    assert_eq!(again.bytes(), read.bytes());
    start(&read);
    true
}

/// Starts a node with these settings, as `world::boot` does.
fn start(settings: &NodeSettings) {
    let (rig, parts, start) = (&figure(KIND).board, setup(KIND), Start::default());
    let control =
        ControlLoop::<8, 8, 8, 8>::new(rig, settings, &parts.servos, &parts.schedule, start);
    control.expect("they were checked");
}

/// Runs a node in the state that the first byte selects, with a host whose messages follow from the other bytes:
/// outputs stay within their limits. Returns the kinds of messages by the state's number.
pub(crate) fn node(bytes: &[u8]) -> BTreeSet<(u8, String)> {
    let mut said = BTreeSet::new();
    let Some((first, bytes)) = bytes.split_first() else { return said };
    let mut world = world_in(State::ALL[usize::from(*first) % State::COUNT]);
    world.host.beats = false;
    let mut hostile = Hostile::of_bytes(bytes, 1000, 1000);
    while !hostile.is_over() {
        let session = world.host.welcome.map_or(0, |welcome| welcome.session);
        let state = world.state().expect("the rig is not replaced");
        let message = hostile.message(session, state);
        said.insert((state.number(), name(&message)));
        let now_us = world.now_us();
        world.host.send(&message, now_us);
        for _ in 0..=hostile.below(4) {
            world.tick();
            check_outputs(&world);
        }
    }
    said
}

/// Returns the kind of a message.
fn name(message: &ToController) -> String {
    let text = match message {
        ToController::Hello(_) => "Hello".to_owned(),
        ToController::Command(command) => format!("{:?}", command.item),
        ToController::Stream(stream) => format!("{:?}", stream.item),
    };
    text.chars().take_while(|c| c.is_alphanumeric()).collect()
}

/// Returns a node with its host, rig and show, in a state.
fn world_in(state: State) -> World {
    static FLASH: OnceLock<MockFlash> = OnceLock::new();
    let flash = FLASH.get_or_init(|| {
        let world = World::ready(KIND, Trouble::default(), 41, &show(KIND, 4, true));
        let flash = world.chip.flash.borrow();
        flash.clone()
    });
    let mut world = World::with(KIND, Chip::of(flash.clone()), Trouble::default(), 42);
    if state == State::Off {
        // A servo that is never read keeps the node in this state.
        let (at_s, for_s) = (0.0, f64::INFINITY);
        world.bench.faults.push(Fault { servo: 5, at_s, for_s, kind: FaultKind::Silent });
        world.connect();
        return world;
    }
    world.connect();
    assert!(matches!(world.ask(Command::LoadShow { slot: 0 }), Outcome::Applied(_)));
    world.until(State::Limp, 2.0);
    let ask = match state {
        State::Calibrating => &[Command::Calibrate][..],
        State::Teaching => &[Command::Teach],
        State::Faulted => &[Command::EStop],
        State::Limp | State::Off => &[],
        State::Arming => &[Command::Arm],
        State::Holding => &[Command::Arm, Command::Hold],
        State::Playing => &[Command::Arm, Command::Play(Feed::Show)],
        State::Maintenance => &[Command::Arm, Command::Maintain(Operator(1))],
        State::Stopping => &[Command::Arm, Command::Stop],
        State::Lowering => &[Command::Arm, Command::Disarm],
        State::Floating => &[Command::Arm, Command::Float],
    };
    for command in ask {
        if world.state() == Some(State::Arming) {
            world.until(State::Holding, 2.0);
        }
        let is_arm = *command == Command::Arm;
        let outcome = if is_arm { world.arm() } else { world.ask(command.clone()) };
        assert!(matches!(outcome, Outcome::Applied(_)), "{command:?}: {outcome:?}");
    }
    assert_eq!(world.state(), Some(state));
    world
}
