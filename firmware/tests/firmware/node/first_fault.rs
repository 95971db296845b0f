//! After an operator clears faults, flash keeps the next fault as the first, with its time. This holds for every
//! fault, even while earlier records still wait to be written. A warning does not count as the first fault.

use sinew_firmware::supervisor::{FaultRecord, State};
use sinew_link::message::{
    Applied, Command, FaultReport, Outcome, TelemetryParts, TelemetrySetting,
};

use super::line::Trouble;
use super::stored::show;
use super::test_rig::Kind;
use super::world::World;

const KIND: Kind = Kind::Current;

fn holding() -> World {
    let mut world = World::ready(KIND, Trouble::default(), 29, &show(KIND, 1, false));
    world.run(2.0);
    world.arm();
    world.until(State::Holding, 3.0);
    world
}

/// Returns the first fault and the last ones, newest first, as the board reads them at a start.
fn kept(world: &mut World) -> (FaultRecord, Vec<FaultRecord>) {
    assert!(world.restart());
    let log = *world.board.control.as_ref().unwrap().0.controller().supervisor().log();
    (log.first().unwrap(), log.last().collect())
}

#[test]
fn the_same_fault_after_a_clear_is_a_new_first() {
    let mut world = holding();
    // The state is the same each time: limp.
    world.ask(Command::EStop);
    assert!(matches!(world.ask(Command::ClearFaults), Outcome::Applied(_)));
    let times: Vec<u64> = (0..2)
        .map(|_| {
            world.run(0.5);
            world.ask(Command::EStop);
            let told = world.host.faults.last().unwrap();
            assert_eq!((told.fault, told.times), (16, 1), "the host is told, too");
            let time_us = told.time_us;
            assert!(matches!(world.ask(Command::ClearFaults), Outcome::Applied(_)));
            time_us
        })
        .collect();
    world.run(0.5);
    world.ask(Command::EStop);
    let last_us = world.host.faults.last().unwrap().time_us;
    assert!(last_us > times[1]);
    world.run(0.1);
    let (first, last) = kept(&mut world);
    assert_eq!((first.fault.number(), first.time_us), (16, last_us));
    // The earlier faults are among the last ones, each with its own time.
    let kept_us: Vec<u64> = last.iter().map(|record| record.time_us).collect();
    assert_eq!(kept_us[..3], [last_us, times[1], times[0]]);
}

#[test]
fn faults_cleared_while_the_rig_is_lowered_are_cleared_in_flash() {
    let mut world = holding();
    world.host.beats = false;
    world.until(State::Lowering, 3.0);
    world.host.beats = true;
    world.run(0.1);
    let cleared = world.ask(Command::ClearFaults);
    assert!(matches!(cleared, Outcome::Applied(Applied::State(_))), "{cleared:?}");
    assert_eq!(world.state(), Some(State::Lowering));
    world.ask(Command::EStop);
    world.run(0.1);
    let (first, last) = kept(&mut world);
    assert_eq!(first.fault.number(), 16);
    let numbers: Vec<u8> = last.iter().map(|record| record.fault.number()).collect();
    assert_eq!(numbers[..2], [16, 2]);
}

/// Two faults in a tick: the first is the one with the lower number, as in the supervisor.
#[test]
fn of_two_in_a_tick_flash_has_the_same_first_as_the_supervisor() {
    let mut world = holding();
    world.pins.is_stopped = true;
    // The emergency stop, and an error that a servo reports.
    let (_, bus) = world.board.control.as_mut().unwrap();
    bus.planted.alert = true;
    world.run(0.1);
    let log = *world.board.control.as_ref().unwrap().0.controller().supervisor().log();
    let before = log.first().unwrap();
    assert_eq!(before.fault.number(), 4);
    assert_eq!(log.last().take(2).map(|record| record.fault.number()).collect::<Vec<_>>(), [16, 4]);
    assert_eq!(kept(&mut world).0.fault, before.fault);
}

/// Reads the board's log as a host does.
fn read(world: &mut World, index: u16) -> (u16, Option<u8>) {
    match world.ask(Command::ReadFault { index }) {
        Outcome::Applied(Applied::Fault(FaultReport { count, record })) => {
            (count, record.map(|record| record.fault))
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_warning_stands_behind_the_faults_until_they_are_cleared() {
    let mut world = holding();
    let plant = |world: &mut World, swing_rad| {
        let (_, bus) = world.board.control.as_mut().unwrap();
        bus.planted.swing_rad = swing_rad;
    };
    let telemetry = TelemetrySetting { rate_hz: 20.0, parts: TelemetryParts::SUMMARY };
    world.ask(Command::SetTelemetry(telemetry));
    plant(&mut world, Some(0.01));
    world.run(1.0);
    plant(&mut world, None);
    let told = *world.host.faults.last().unwrap();
    assert!(told.is_warning() && told.fault == 64 && told.servo == Some(0), "{told:?}");
    // Telemetry reports the warning while it is present, and the rig continues.
    world.run(0.1);
    let summary = world.host.summaries.last().unwrap();
    assert_eq!((summary.state.to_string(), summary.fault), ("holding".to_owned(), Some(64)));
    assert_eq!(read(&mut world, 0), (1, Some(64)));
    world.ask(Command::EStop);
    world.run(0.1);
    // The fault appears twice: as the first, and as the last.
    let all: Vec<_> = (0..4).map(|index| read(&mut world, index)).collect();
    assert_eq!(all, [(3, Some(16)), (3, Some(16)), (3, Some(64)), (3, None)]);
    assert!(matches!(world.ask(Command::ClearFaults), Outcome::Applied(_)));
    world.run(0.1);
    assert_eq!(read(&mut world, 0).1, None);
    // A start of the board forgets the warning and keeps the fault.
    assert!(world.restart());
    let log = world.board.control.as_ref().unwrap().0.controller().supervisor().log();
    assert_eq!(log.last().next().unwrap().fault.number(), 16);
}
