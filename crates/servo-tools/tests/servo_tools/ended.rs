//! Tests tools that end early, by a signal, a fault or a kill: the traces that remain on the servo.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use sinew_rig::description::ServoModel;
use sinew_servo_bus::table::Access;
use sinew_servo_sim::device::Servo as SimServo;
use sinew_servo_sim::fault::{Fault, FaultKind};
use sinew_servo_tools::calibrate::Calibration;
use sinew_servo_tools::compare::apply;
use sinew_servo_tools::desired::{Mode, desired};
use sinew_servo_tools::rig_servo::RigServo;
use sinew_servo_tools::tap::{Load, Settings as TapSettings, TapTest};
use sinew_servo_tools::{
    Client, Exchange, Protocol, ServiceError, Servo, Settings, Table, address, identify, left,
};

use crate::common::{KINDS, SimLine};

const BAUD: u32 = 1_000_000;
/// Addresses: Bus Watchdog and Torque Enable of a Dynamixel; Torque Enable and Torque Limit of a Feetech.
const WATCHDOG: u16 = 98;
const TORQUE: u16 = 64;
const FEETECH_TORQUE: u16 = 40;
const FEETECH_LIMIT: u16 = 48;

/// The way in which a tool is ended after some packets.
#[derive(Clone)]
enum End {
    Never,
    Signal(Arc<AtomicBool>),
    /// The program is killed: no further packet is sent.
    Kill,
}

/// A line of one servo, on which a tool is ended.
struct Line {
    sim: SimLine,
    after: usize,
    end: End,
    heard: usize,
}

impl Exchange for Line {
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()> {
        self.heard += 1;
        if self.heard > self.after {
            match &self.end {
                End::Never => {}
                End::Signal(flag) => flag.store(true, Ordering::Relaxed),
                End::Kill => return Err(io::ErrorKind::BrokenPipe.into()),
            }
        }
        self.sim.exchange(bytes, wait, take)
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        self.sim.set_baud(baud)
    }

    fn pause(&mut self, time: Duration) {
        if !matches!(self.end, End::Kill) || self.heard <= self.after {
            self.sim.pause(time);
        }
    }

    fn now(&mut self) -> Duration {
        self.sim.now()
    }
}

/// The tools that change servos.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tool {
    Identify,
    Tap,
    Apply,
    Calibrate,
    SetId,
}

const TOOLS: [Tool; 5] = [Tool::Identify, Tool::Tap, Tool::Apply, Tool::Calibrate, Tool::SetId];

fn model(kind: &str) -> ServoModel {
    ServoModel::built_in(kind).unwrap()
}

fn rig_servo(kind: &str) -> RigServo {
    RigServo {
        name: "elbow".to_owned(),
        id: 1,
        model: model(kind),
        range_rad: Some([-1.0, 1.2]),
        homing_offset_rad: None,
        torque_nm: None,
        joint_friction_nm: 0.0,
        position_gain: None,
    }
}

impl Tool {
    fn run(self, client: &mut Client<Line>, servo: &Servo, kind: &str) -> Result<(), ServiceError> {
        match self {
            Self::Identify => identify::identify(client, servo).map(|_| ()),
            Self::Tap => {
                let inertia_kg_m2 = model(kind).rotor_inertia_kg_m2.value;
                let load = Load { inertia_kg_m2, gravity_nm: 0.0 };
                let settings = TapSettings { taps: 20, strength: 0.5, load };
                TapTest::new(client, servo, &model(kind), &settings)?.run(client).map(|_| ())
            }
            Self::Apply => {
                // The mode differs from the servo's, and a change of mode resets gains and goals.
                let mode = if servo.table.has_current() { Mode::Current } else { Mode::Pwm };
                let settings = desired(&rig_servo(kind), &servo.table, mode)?;
                apply(client, servo, &settings, true).map(|_| ())
            }
            Self::Calibrate => {
                let servos = [(rig_servo(kind), servo.clone())];
                let mut calibration = Calibration::begin(client, &servos)?;
                (0..40).try_for_each(|_| {
                    client.line_mut().pause(Duration::from_millis(50));
                    calibration.look(client)
                })
            }
            Self::SetId => address::set_id(client, servo, 7).map(|_| ()),
        }
    }
}

/// Creates a client of one servo at [`BAUD`], with no packets counted yet.
fn client(kind: &str, is_on: bool) -> Client<Line> {
    let mut sim = SimLine::new(&[(kind, 1)]);
    let protocol = if kind.starts_with('S') { Protocol::Feetech } else { Protocol::Dynamixel };
    let torque = if protocol == Protocol::Feetech { FEETECH_TORQUE } else { TORQUE };
    let servo = &mut sim.bench.servos_mut()[0];
    servo.set_baud(BAUD).unwrap();
    servo.set(torque, is_on.into());
    sim.bench.run_us(100_000);
    let line = Line { sim, after: usize::MAX, end: End::Never, heard: 0 };
    Client::new(line, protocol, BAUD, Settings::default()).unwrap()
}

/// Returns all registers that a controller can write, except the goal position: with torque off, it has no effect.
fn written(servo: &SimServo<'_>, table: &Table) -> Vec<(&'static str, i32)> {
    let is_one = |item: &sinew_servo_bus::table::Item| {
        item.access == Access::ReadWrite && item.name != "Goal Position"
    };
    table
        .items()
        .iter()
        .filter(|item| is_one(item))
        .map(|item| (item.name, servo.get(item.address)))
        .collect()
}

fn sim(client: &mut Client<Line>) -> &mut SimLine {
    &mut client.line_mut().sim
}

/// Lists the registers that differ, in words.
fn differ(before: &[(&str, i32)], after: &[(&str, i32)]) -> Vec<String> {
    let pairs = before.iter().zip(after).filter(|(before, after)| before != after);
    pairs.map(|((name, before), (_, after))| format!("{name}: {before} -> {after}")).collect()
}

/// Returns the number of packets of a whole run of a tool.
fn packets(tool: Tool, kind: &str, is_on: bool) -> usize {
    let mut client = client(kind, is_on);
    let servo = client.open(1, None).unwrap();
    client.line_mut().heard = 0;
    let _ = tool.run(&mut client, &servo, kind);
    client.line_mut().heard
}

#[test]
fn a_signal_leaves_nothing_whenever_it_comes() {
    for kind in KINDS {
        for (tool, is_on) in TOOLS.map(|tool| (tool, false)).into_iter().chain([
            (Tool::Identify, true),
            (Tool::Tap, true),
            (Tool::Apply, true),
        ]) {
            let all = packets(tool, kind, is_on);
            let mut ended = 0;
            // Ends the tool after many of the first packets, which change registers, and after some of the later
            // packets.
            let some = all.saturating_sub(80).div_ceil(12).max(1);
            for after in (0..all.min(80)).step_by(3).chain((80..all).step_by(some)) {
                let mut client = client(kind, is_on);
                let servo = client.open(1, None).unwrap();
                let flag = Arc::new(AtomicBool::new(false));
                client.stop_at(Arc::clone(&flag));
                let before = written(&sim(&mut client).bench.servos()[0], &servo.table);
                let line = client.line_mut();
                (line.heard, line.after, line.end) = (0, after, End::Signal(flag));
                let result = tool.run(&mut client, &servo, kind);
                let place = format!("{kind} {tool:?} {is_on} after {after} of {all}: {result:?}");
                let bench = &mut sim(&mut client).bench;
                let at_end = bench.servos()[0].shaft().position_rad;
                bench.run_us(1_000_000);
                let servos = bench.servos();
                let after = written(&servos[0], &servo.table);
                let mut differ = differ(&before, &after);
                if result.is_ok() {
                    // The tool has finished its work: a half-written id would be invalid.
                    let finished = |what: &String| what.starts_with("ID: 1 -> 7");
                    assert!(
                        tool != Tool::SetId || differ.iter().all(finished),
                        "{place} {differ:?}"
                    );
                    let leaves = matches!(tool, Tool::SetId | Tool::Apply);
                    assert!(leaves || differ.is_empty(), "{place} {differ:?}");
                    continue;
                }
                ended += 1;
                assert!(matches!(result, Err(ServiceError::Stopped)), "{place}");
                if is_on && tool == Tool::Apply {
                    // Torque was switched off, as requested.
                    differ.retain(|what| what != "Torque Enable: 1 -> 0");
                }
                assert!(differ.is_empty(), "{place} {differ:?}");
                if !is_on {
                    let moved = servos[0].shaft().position_rad - at_end;
                    assert!(moved.abs().to_degrees() < 12.0, "{place}: it went on by {moved} rad");
                }
            }
            assert!(ended > 0 || tool == Tool::SetId, "{kind} {tool:?}");
        }
    }
}

#[test]
fn a_fault_is_told_and_leaves_nothing() {
    let faults = [
        (FaultKind::Silent, "does not answer"),
        (FaultKind::WrongCheck, ""),
        (FaultKind::Short(4), ""),
        (FaultKind::WrongId(252), ""),
        (FaultKind::Stuck, "blocked"),
        (FaultKind::Hot(90.0), "too hot"),
        (FaultKind::BrownOut, ""),
        (FaultKind::Reboot, ""),
        (FaultKind::TorqueLost, "its torque went off by itself"),
        (FaultKind::EncoderJump(1.6), "jumps"),
        (FaultKind::EncoderJump(-0.3), "jumps"),
        (FaultKind::TorqueStuck, "Torque Enable"),
    ];
    for kind in KINDS {
        for tool in [Tool::Identify, Tool::Tap] {
            for ((fault, words), at_s) in
                faults.into_iter().flat_map(|fault| [(fault, 0.7), (fault, 1.6), (fault, 2.3)])
            {
                let mut client = client(kind, false);
                let servo = client.open(1, None).unwrap();
                let before = written(&sim(&mut client).bench.servos()[0], &servo.table);
                let bench = &mut sim(&mut client).bench;
                let at_s = bench.time_s() + at_s;
                let for_s = if fault == FaultKind::TorqueStuck { f64::INFINITY } else { 6.0 };
                bench.faults.push(Fault { servo: 0, at_s, for_s, kind: fault });
                let result = tool.run(&mut client, &servo, kind);
                let place = format!("{kind} {tool:?} {fault:?} at {at_s:.1} s: {result:?}");
                let bench = &mut sim(&mut client).bench;
                bench.run_us(8_000_000);
                let after = written(&bench.servos()[0], &servo.table);
                let said = result.map_or_else(|error| error.to_string(), |()| String::new());
                let taps = tool == Tool::Tap;
                assert!(!said.is_empty(), "{place}");
                if taps {
                    println!("{place}");
                }
                assert!(taps || said.contains(words), "{place}");
                let mut differ = differ(&before, &after);
                if fault == FaultKind::TorqueStuck {
                    assert!(said.contains("Torque Enable"), "{place}");
                    differ.retain(|what| what != "Torque Enable: 0 -> 1");
                }
                assert!(differ.is_empty(), "{place} {differ:?}");
            }
        }
    }
}

#[test]
fn a_kill_ends_the_move_and_is_found_by_the_next_tool() {
    println!("kind, tool: kills; torque left on; registers left; told by the next tool");
    for kind in KINDS {
        for tool in TOOLS {
            let all = packets(tool, kind, false);
            let mut counts = [0; 4];
            for after in (0..all.min(60)).step_by(2).chain((60..all).step_by(all.div_ceil(12))) {
                let mut client = client(kind, false);
                let servo = client.open(1, None).unwrap();
                let before = written(&sim(&mut client).bench.servos()[0], &servo.table);
                let line = client.line_mut();
                (line.heard, line.after, line.end) = (0, after, End::Kill);
                let result = tool.run(&mut client, &servo, kind);
                let place = format!("{kind} {tool:?} after {after} of {all}: {result:?}");
                let bench = &mut sim(&mut client).bench;
                // Waits for the time of the watchdog, and until the servo rests.
                bench.run_us(700_000);
                let stands = bench.servos()[0].shaft().position_rad;
                bench.run_us(2_000_000);
                let sim_servo = &bench.servos()[0];
                let moved = sim_servo.shaft().position_rad - stands;
                let is_feetech = kind.starts_with('S');
                // A Feetech has no watchdog: it moves weakly to its goal.
                let is_still = moved.abs().to_degrees() < 3.0;
                assert!(is_feetech || is_still, "{place}: it went on by {moved} rad");
                let torque = if is_feetech { FEETECH_TORQUE } else { TORQUE };
                let is_on = sim_servo.get(torque) != 0;
                if is_on && is_feetech {
                    assert!(sim_servo.get(FEETECH_LIMIT) <= 800, "{place}");
                } else if is_on {
                    assert_eq!(sim_servo.get(WATCHDOG), -1, "{place}");
                }
                let differ = differ(&before, &written(sim_servo, &servo.table));
                // Now the next tool runs.
                client.line_mut().end = End::Never;
                let id = if sim(&mut client).bench.servos()[0].get(if is_feetech { 5 } else { 7 })
                    == 7
                {
                    7
                } else {
                    1
                };
                let servo = client.open(id, None).unwrap();
                let left = left::look(&mut client, &servo).unwrap();
                let moves = matches!(tool, Tool::Identify | Tool::Tap);
                assert_eq!(
                    left.is_some() && moves,
                    !differ.is_empty() && moves,
                    "{place} {differ:?} {left:?}"
                );
                assert!(!is_on || left.is_some(), "{place} {differ:?}");
                let counted = [true, is_on, !differ.is_empty(), left.is_some()];
                for (count, counted) in counts.iter_mut().zip(counted) {
                    *count += u32::from(counted);
                }
                if is_on {
                    let refused = identify::identify(&mut client, &servo).unwrap_err().to_string();
                    assert!(refused.contains("sinew servo reboot 1"), "{refused}");
                }
                if moves && left.is_some() {
                    client.reboot(&servo).unwrap();
                    let after = written(&sim(&mut client).bench.servos()[0], &servo.table);
                    assert_eq!(before, after, "{place}");
                }
            }
            let [kills, on, registers, told] = counts;
            println!("{kind}, {tool:?}: {kills}; {on}; {registers}; {told}");
        }
    }
}
