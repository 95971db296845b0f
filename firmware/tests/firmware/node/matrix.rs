//! Every fault in every state again, for a whole node: in process, and as an image in QEMU. This is the second table of
//! the page `docs/fault-matrix.md`.
//!
//! These tests create a fault where an image can detect it: in the bytes of its bus and its host link, at its pins,
//! by its clock. The tests of the first table create it between bus and controller.

use std::collections::HashMap;
use std::thread;

use sinew_firmware::supervisor::{Clears, Fault, Reaction, State, TABLE};
use sinew_link::message::{
    Command, Feed, Kind as ItemKind, Operator, Outcome, TelemetryParts, TelemetrySetting, Value,
};
use sinew_servo_sim::fault::{Fault as Damage, FaultKind};

use super::cell::{Tried, measure, must_be, of_page, row, table};
use super::emulated::Emulated;
use super::host::next_of_upload;
use super::line::Trouble;
use super::stored::{item, rig, settings, show};
use super::test_rig::{Kind, NOTHING_A, is_off, most_current_a, setup};
use super::told::Lie;
use super::world::World;

const KIND: Kind = Kind::Current;
const ANN: Operator = Operator(1);
/// Register of an XL330's position.
const PRESENT_POSITION: u16 = 132;
/// Time for which a board is away after a panic: 0.2 s, in ticks.
const RESET_TICKS: u32 = 80;

/// Environment variable that makes QEMU test all cells. `cargo xtask node` sets it.
const ALL: &str = "SINEW_NODE_ALL";

/// Returns the reason why a fault is not shown in a state.
fn excuse(fault: Fault, state: State) -> Option<&'static str> {
    use Fault::{
        BrownOut, FollowingError, HostDeaf, LinkLost, NotFinite, ServoStopped, SettingsBad,
        ShowBad, ShowForeign, Swing, TorqueStuck, WatchdogReset,
    };
    match fault {
        NotFinite => Some("no byte says it"),
        ShowBad | ShowForeign => Some("refused before it plays"),
        WatchdogReset | BrownOut => Some("not in QEMU"),
        SettingsBad if state != State::Off => Some("at the start alone"),
        ServoStopped if !state.is_on() => Some("its watchdog rests"),
        TorqueStuck if state.is_on() => Some("torque is to be on"),
        FollowingError | Swing if !state.is_on() => Some("nothing is followed"),
        FollowingError | Swing if state == State::Lowering => Some("it sinks on purpose"),
        LinkLost | HostDeaf if state == State::Arming => Some("over after 1 s"),
        LinkLost if state == State::Playing => Some("link late holds it before"),
        _ => None,
    }
}

/// Returns the reason why a row differs from that of the first table.
fn why_it_differs(fault: Fault) -> Option<&'static str> {
    use Fault::{
        BrownOut, EStop, FollowingError, HostDeaf, HotMeasured, HotWinding, Jump, LinkLate,
        LinkLost, NotFinite, Overrun, Panic, Range, ServoError, ServoSilent, ServoStopped,
        SettingsBad, ShowBad, ShowForeign, SupplyHigh, SupplyLow, Swing, TorqueStuck,
        WatchdogReset,
    };
    Some(match fault {
        LinkLate | LinkLost => "the host's last beat was some ticks before",
        HostDeaf => "the wire from the board is dead: counted from there",
        ServoSilent => "in off it is counted from the start",
        ServoError => "an error reported in a tick counts in the next",
        HotMeasured | SupplyLow | SupplyHigh => "it is read once in six ticks",
        HotWinding => "a reading holds 32.8 A, not 147",
        FollowingError | Range => "it runs by whole steps",
        Jump => "it is off from one reading to the next",
        NotFinite => "integers are finite",
        Overrun => "in stopping the show had played for a shorter time",
        SettingsBad => "uploads count at a start",
        ShowBad | ShowForeign => "the background task checks it first",
        WatchdogReset | BrownOut => "the machine has none",
        Panic => "the program stops itself in each state",
        Swing => "it swings by whole steps, 25 times a second",
        ServoStopped | TorqueStuck => "its register is read in its turn",
        EStop => return None,
    })
}

impl Tried for World {
    fn tick(&mut self) {
        self.tick();
    }
    fn state(&self) -> State {
        self.state().unwrap_or(State::Off)
    }
    fn has(&self, fault: Fault) -> bool {
        self.has(fault)[0]
    }
    fn servos_on(&self) -> usize {
        self.servos_on()
    }
    fn most_current_a(&self) -> f64 {
        most_current_a(&self.bench)
    }
    fn sent_off(&self) -> bool {
        is_off(self.kind, &self.sent)
    }
    fn ticks_of(&self, seconds: f64) -> u32 {
        (seconds * f64::from(self.kind.rate_hz())).round() as u32
    }
}

/// Runs to the tick after which a command makes the node restart.
fn until_restart(world: &mut World, command: Command) {
    let (starts, now_us) = (world.starts, world.now_us());
    world.host.ask(command, now_us);
    for _ in 0..4_000 {
        world.tick();
        if world.starts > starts {
            return;
        }
    }
    panic!("it does not begin anew: {:?}", world.host.outcome);
}

/// Runs to the tick after which an upload's last command makes the node restart.
fn until_restart_by(world: &mut World, kind: ItemKind, content: &[u8], of_rig: u32) {
    let item = item(kind, content, of_rig);
    let mut outcome = None;
    loop {
        let command = next_of_upload(&item, content, outcome.as_ref());
        if command == Command::EndUpload {
            return until_restart(world, command);
        }
        outcome = Some(world.ask(command));
    }
}

/// Restarts the board with its current settings. Its servos continue.
fn begin_anew(world: &mut World) {
    if world.state().is_some_and(State::is_on) {
        world.ask(Command::EStop);
    }
    let stop_s = setup(KIND).settings.supervisor.stop_s;
    until_restart(world, Command::WriteSetting { key: 6, value: Value::Number(stop_s) });
}

/// Connects, loads the show, and runs until the rig is limp.
fn ready(world: &mut World) {
    world.connect();
    assert!(matches!(world.ask(Command::LoadShow { slot: 0 }), Outcome::Applied(_)));
    world.until(State::Limp, 2.0);
}

fn damage(world: &mut World, servo: usize, kind: FaultKind) {
    let (at_s, for_s) = (world.bench.time_s(), f64::INFINITY);
    world.bench.faults.push(Damage { servo, at_s, for_s, kind });
}

/// Brings a limp node into a state. For `Off`, a servo is silent.
pub(super) fn enter(world: &mut World, state: State, fault: Fault) {
    // While torque is off, the board sends telemetry only on request.
    let asks = |world: &mut World| {
        let telemetry = TelemetrySetting { rate_hz: 50.0, parts: TelemetryParts::SUMMARY };
        world.ask(Command::SetTelemetry(telemetry));
        world.run(0.1);
    };
    let is_deaf = fault == Fault::HostDeaf;
    if is_deaf && state != State::Off {
        asks(world);
    }
    bring(world, state, fault);
    // The request is for the new start.
    if is_deaf && state == State::Off {
        asks(world);
    }
}

fn bring(world: &mut World, state: State, fault: Fault) {
    match state {
        State::Off if fault == Fault::SettingsBad => {
            // The settings of one rig, and then another rig.
            let (settings, crc) = (settings(KIND).bytes(), rig(KIND).1);
            until_restart_by(world, ItemKind::Settings, &settings, crc);
            ready(world);
            return until_restart_by(world, ItemKind::Rig, &rig(Kind::Position).0, 0);
        }
        State::Off => {
            damage(world, 5, FaultKind::Silent);
            if fault == Fault::ServoSilent {
                // The servo is silent from the start.
                return begin_anew(world);
            }
            begin_anew(world);
            world.connect();
            // The board receives the host's messages.
            world.run(0.05);
        }
        State::Limp => {}
        State::Calibrating => drop(world.ask(Command::Calibrate)),
        State::Teaching => drop(world.ask(Command::Teach)),
        State::Faulted => drop(world.ask(Command::EStop)),
        _ => {
            world.arm();
            if state != State::Arming {
                world.until(State::Holding, 2.0);
            }
            match state {
                State::Playing => drop(world.ask(Command::Play(Feed::Show))),
                State::Maintenance => drop(world.ask(Command::Maintain(ANN))),
                State::Lowering => drop(world.ask(Command::Disarm)),
                State::Floating => drop(world.ask(Command::Float)),
                State::Stopping => {
                    // First the arm moves away from home.
                    world.ask(Command::Play(Feed::Show));
                    world.run(4.0);
                    if matches!(fault, Fault::LinkLost | Fault::HostDeaf) {
                        // The rig moves home in less time than the link's time-out, so the link is cut before the
                        // stop. Then heat stops the rig.
                        plant(world, fault);
                        world.run(1.1);
                        world.told.lie.celsius = Some(66);
                        world.until(State::Stopping, 0.1);
                    } else {
                        world.ask(Command::Stop);
                    }
                }
                _ => {}
            }
            if matches!(state, State::Arming | State::Stopping) {
                world.run(0.1);
            }
        }
    }
    assert_eq!(world.state(), Some(state), "for {fault}");
}

/// Creates a fault's condition.
fn plant(world: &mut World, fault: Fault) {
    let lie = match fault {
        Fault::ServoError => Lie { alert: true, ..Lie::default() },
        Fault::HotMeasured => Lie { celsius: Some(66), ..Lie::default() },
        Fault::HotWinding => Lie { milliamps: Some([i16::MAX; 2]), ..Lie::default() },
        Fault::SupplyLow => Lie { decivolts: Some(30), ..Lie::default() },
        Fault::SupplyHigh => Lie { decivolts: Some(80), ..Lie::default() },
        // An encoder that runs away by 30 deg, and stops there. While floating it runs farther, faster than any hand.
        Fault::FollowingError => {
            let is = world.bench.servos()[0].get(PRESENT_POSITION);
            let far = if world.state() == Some(State::Floating) { 1300 } else { 342 };
            let to = if is < 2048 { is + far } else { is - far };
            Lie { runs_to: Some(to), ..Lie::default() }
        }
        // The jump is 5 deg.
        Fault::Jump => Lie { off: 57, ..Lie::default() },
        Fault::Swing => {
            let is = world.bench.servos()[0].get(PRESENT_POSITION);
            let far = if world.state() == Some(State::Floating) { 30 } else { 8 };
            let positions = Some([is - far, is + far]);
            Lie { positions, milliamps: Some([300, -300]), ..Lie::default() }
        }
        // The position is beyond the nearer end.
        Fault::Range => {
            let is_low = world.bench.servos()[0].get(PRESENT_POSITION) < 2048;
            Lie { runs_to: Some(if is_low { 158 } else { 3938 }), ..Lie::default() }
        }
        _ => world.told.lie,
    };
    world.told.lie = lie;
    match fault {
        Fault::LinkLate | Fault::LinkLost => world.host.beats = false,
        Fault::HostDeaf => world.host.is_deaf = true,
        Fault::ServoSilent => damage(world, 0, FaultKind::Silent),
        Fault::TorqueStuck => damage(world, 0, FaultKind::TorqueStuck),
        Fault::Overrun => world.late_us = world.tick_us(),
        Fault::EStop => world.pins.is_stopped = true,
        // The board stops for 0.15 s.
        Fault::ServoStopped => (0..60).for_each(|_| world.pass_tick()),
        _ => {}
    }
}

/// Ends all conditions.
fn mend(world: &mut World) {
    let now_s = world.bench.time_s();
    for fault in &mut world.bench.faults {
        fault.for_s = fault.for_s.min(now_s - fault.at_s);
    }
    world.told.lie = Lie::default();
    world.late_us = 0;
    world.pins.is_stopped = false;
    world.host.beats = true;
    world.host.is_deaf = false;
}

/// Measures a cell, from limp to limp.
fn cell(world: &mut World, fault: Fault, state: State) -> String {
    enter(world, state, fault);
    let words = if fault == Fault::Panic {
        let mut stopped = None;
        let mut ticks = 0;
        world.panic(RESET_TICKS, |bench| {
            stopped = stopped.or((most_current_a(bench) < NOTHING_A).then_some(ticks));
            ticks += 1;
        });
        let stopped = stopped.unwrap_or_else(|| panic!("in {state} servos do not stop"));
        let words = measure(world, fault, state).words(fault, state);
        if state.is_on() { format!("stop {stopped}; {words}") } else { words }
    } else {
        plant(world, fault);
        measure(world, fault, state).words(fault, state)
    };
    let row = row(fault);
    let latches = row.latches() && row.reaction(state) > Reaction::Note;
    assert_eq!(world.has(fault)[1], latches, "{fault} in {state}");
    mend(world);
    if state == State::Off || fault == Fault::Panic {
        world.connect();
    }
    if fault == Fault::Panic {
        assert_eq!(world.host.faults.last().unwrap().fault, fault.number());
    }
    // A winding takes minutes to cool.
    if latches && row.clears == Clears::Command && fault != Fault::HotWinding {
        is_cleared(world, fault);
    }
    if fault == Fault::SettingsBad {
        until_restart_by(world, ItemKind::Rig, &rig(KIND).0, 0);
        world.connect();
    }
    begin_anew(world);
    ready(world);
    words
}

/// Checks that a command clears a fault as soon as filters have settled.
fn is_cleared(world: &mut World, fault: Fault) {
    // The rig first goes to its rest pose and is lowered.
    for _ in 0..120 {
        if world.state().is_some_and(|state| !state.is_on()) {
            world.ask(Command::ClearFaults);
            if !world.has(fault)[1] {
                return;
            }
        }
        world.run(0.25);
    }
    panic!("{fault} is not cleared: {:?}", world.state());
}

/// Measures all cells of these faults and states. For each fault it makes a new world, with a new board from
/// `emulated`.
fn cells(
    emulated: fn() -> Option<Emulated>,
    is_wanted: impl Fn(Fault, State) -> bool + Sync,
) -> HashMap<(u8, u8), String> {
    let of_fault = |fault: Fault| {
        let shown = |state: &State| excuse(fault, *state).is_none() && is_wanted(fault, *state);
        let mut cells: HashMap<_, _> = State::ALL
            .map(|state| ((fault.number(), state.number()), excuse(fault, state)))
            .into_iter()
            .filter_map(|(at, why)| Some((at, why?.to_owned())))
            .collect();
        if State::ALL.iter().any(shown) {
            let mut world = World::new(KIND, Trouble::default(), 29);
            world.emulated = emulated();
            world.store(&show(KIND, 20, true));
            world.until(State::Limp, 2.0);
            for state in State::ALL.into_iter().filter(shown) {
                let words = cell(&mut world, fault, state);
                cells.insert((fault.number(), state.number()), words);
            }
        }
        cells
    };
    // Two at a time, which most machines can run.
    thread::scope(|scope| {
        let workers: Vec<_> = (0..2)
            .map(|worker| {
                let faults = Fault::ALL.into_iter().skip(worker).step_by(2);
                scope.spawn(move || faults.flat_map(of_fault).collect::<Vec<_>>())
            })
            .collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap()).collect()
    })
}

/// Checks that the second table matches the measured cells.
fn is_the_page(emulated: fn() -> Option<Emulated>) {
    let cells = cells(emulated, |_, _| true);
    let cell = |fault: Fault, state: State| cells[&(fault.number(), state.number())].clone();
    let first = of_page(0);
    let ends = |fault: Fault, row: &[String]| {
        let place = TABLE.iter().position(|row| row.fault == fault).unwrap();
        let line = first[place + 2];
        // The cells are after number and name.
        let same = line.trim_matches('|').split('|').skip(2).map(str::trim).take(row.len()).eq(row);
        let why = if same { Some("the same") } else { why_it_differs(fault) };
        vec![why.unwrap_or("NOT EXPLAINED").to_owned()]
    };
    must_be(1, &table(&["against the first table"], cell, ends));
}

#[test]
fn the_second_table_is_what_happens_in_process() {
    is_the_page(|| None);
}

/// Returns a state for each fault that can be shown: the state that was chosen least often for the earlier faults.
fn share() -> Vec<(Fault, State)> {
    let mut times = [0; State::COUNT];
    let mut share = Vec::new();
    for fault in Fault::ALL {
        let shown = State::ALL.into_iter().filter(|state| excuse(fault, *state).is_none());
        if let Some(state) = shown.min_by_key(|state| times[usize::from(state.number())]) {
            times[usize::from(state.number())] += 1;
            share.push((fault, state));
        }
    }
    assert!(!times.contains(&0), "a state without a fault: {times:?}");
    share
}

/// Emulators are slow: each fault is tested in only one state unless [`ALL`] is set.
#[test]
#[ignore = "needs the image that `cargo xtask node` builds"]
fn the_second_table_is_what_happens_in_qemu() {
    let in_qemu = || Some(Emulated::in_qemu(KIND));
    if std::env::var_os(ALL).is_some() {
        return is_the_page(in_qemu);
    }
    let share = share();
    let is_shared = |fault, state| share.contains(&(fault, state));
    let [of_image, in_process] = [cells(in_qemu, is_shared), cells(|| None, is_shared)];
    for (fault, state) in &share {
        let at = (fault.number(), state.number());
        assert_eq!(of_image[&at], in_process[&at], "{fault} in {state}");
    }
}
