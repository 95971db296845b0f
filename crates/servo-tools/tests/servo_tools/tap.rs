//! Tests taps of simulated servos: the simulated values are found, or the result is refused with a reason.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use sinew_rig::description::ServoModel;
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo as SimServo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::supply::Supply;
use sinew_servo_sim::variation::{Change, Variation};
use sinew_servo_tools::tap::{Load, Settings, TapTest, Tapped};
use sinew_servo_tools::{Client, Exchange, Protocol, ServiceError, Settings as Patience};

use crate::common::SimLine;

/// A servo of a known kind, its load, and the parameters that differ from those of the kind.
#[derive(Clone, Copy)]
struct Case {
    kind: &'static str,
    /// Inertia of the load, relative to the rotor's inertia.
    load: f64,
    /// Torque of gravity at the held position, as a part of the stall torque. Torque is on if it is not 0.
    gravity: f64,
    changes: &'static [&'static str],
}

/// Addresses: Torque Enable and Operating Mode of a Dynamixel, Torque Enable of a Feetech.
const TORQUE: u16 = 64;
const MODE: u16 = 11;
const FEETECH_TORQUE: u16 = 40;
/// Address of Goal Position of a Dynamixel.
const GOAL: u16 = 116;
const BAUD: u32 = 1_000_000;
/// Steps of the gear in one step of the servo: numerical damping is then at most one or two per cent.
const GEAR_STEPS: u32 = 20;

impl Case {
    const fn new(kind: &'static str, load: f64, changes: &'static [&'static str]) -> Self {
        Self { kind, load, gravity: 0.0, changes }
    }

    /// Returns the kind with the changes that are simulated.
    fn simulated(&self) -> Parameters {
        let mut kind = Parameters::built_in(self.kind).unwrap();
        let changes: Vec<Change> = self.changes.iter().map(|word| word.parse().unwrap()).collect();
        Variation::of(&changes).unwrap().change_servo(&mut kind, 1e-3);
        kind
    }

    fn model(&self) -> ServoModel {
        ServoModel::built_in(self.kind).unwrap()
    }

    /// Creates the servo on a line, with these registers changed, as a person may have set them.
    fn line(&self, registers: &[(u16, i32)]) -> SimLine {
        let (kind, model) = (self.simulated(), self.model());
        let arm = Arm {
            inertia_kg_m2: self.load * model.rotor_inertia_kg_m2.value,
            gravity_nm: self.gravity * model.stall_torque_nm.value,
            level_rad: 0.5 * kind.range_rad,
            ..Arm::default()
        };
        let memory = Box::leak(Box::new([0; MEMORY_LEN]));
        let mut servo = SimServo::new(&kind, 1, memory).unwrap();
        servo.set_baud(BAUD).unwrap();
        servo.refine_gear(GEAR_STEPS);
        let torque = if self.protocol() == Protocol::Feetech { FEETECH_TORQUE } else { TORQUE };
        let is_on = i32::from(self.gravity > 0.0);
        for (register, value) in registers.iter().chain(&[(torque, is_on)]) {
            servo.set(*register, *value);
        }
        let mut line = SimLine::new(&[(self.kind, 1)]);
        line.bench = Bench::new(vec![servo], vec![arm], Supply::stiff(kind.voltage_v));
        line
    }

    fn protocol(&self) -> Protocol {
        if self.kind.starts_with('S') { Protocol::Feetech } else { Protocol::Dynamixel }
    }

    fn settings(&self, taps: u32) -> Settings {
        let model = self.model();
        let load = Load {
            inertia_kg_m2: self.load * model.rotor_inertia_kg_m2.value,
            gravity_nm: -self.gravity * model.stall_torque_nm.value,
        };
        Settings { taps, strength: 0.5, load }
    }

    fn tap_on(&self, line: impl Exchange, settings: &Settings) -> Result<Tapped, ServiceError> {
        let mut client = Client::new(line, self.protocol(), BAUD, Patience::default())?;
        let servo = client.open(1, None)?;
        let test = TapTest::new(&mut client, &servo, &self.model(), settings)?;
        let tapped = test.run(&mut client)?;
        assert!(tapped.farthest_rad < test.reach_rad(), "{tapped}");
        Ok(tapped)
    }

    /// Returns the relative errors of stiffness and damping against the simulated values.
    fn off(&self, tapped: &Tapped) -> [f64; 2] {
        let (found, simulated) = (tapped.fitted.joint, self.simulated());
        [
            found.stiffness_nm_rad / simulated.gear_stiffness_nm_rad - 1.0,
            found.damping_nm_s / simulated.gear_damping_nm_s - 1.0,
        ]
    }
}

/// Taps five servos of a kind with 150 taps each. Stiffness and damping must be within 20 %.
fn found(kind: &'static str) {
    let cases = [
        Case::new(kind, 1.0, &[]),
        Case::new(kind, 0.5, &["stiffness=2", "damping=0.33"]),
        Case::new(kind, 1.0, &["damping=0.33"]),
        Case::new(kind, 1.0, &["stiffness=2", "play=2"]),
        Case { gravity: 0.1, ..Case::new(kind, 1.0, &["stiffness=0.5", "play=2"]) },
    ];
    let mut worst: f64 = 0.0;
    for case in cases {
        let tapped = case.tap_on(case.line(&[]), &case.settings(150)).unwrap();
        let (joint, simulated) = (tapped.fitted.joint, case.simulated());
        let off = case.off(&tapped);
        println!(
            "{kind}, load {}, gravity {}, {:?}: {:.1} {:.4} put in, {:.1} {:.4} found ({:+.1} %, {:+.1} %)",
            case.load,
            case.gravity,
            case.changes,
            simulated.gear_stiffness_nm_rad,
            simulated.gear_damping_nm_s,
            joint.stiffness_nm_rad,
            joint.damping_nm_s,
            100.0 * off[0],
            100.0 * off[1]
        );
        worst = worst.max(off[0].abs()).max(off[1].abs());
    }
    assert!(worst < 0.2, "{worst}");
}

#[test]
fn the_gear_of_an_xl330_is_found() {
    found("XL330-M288-T");
}

#[test]
fn the_gear_of_an_xl430_is_found() {
    found("XL430-W250-T");
}

#[test]
fn the_gear_of_an_mx_28_is_found() {
    found("MX-28");
}

#[test]
fn the_gear_of_an_mx_64_is_found() {
    found("MX-64");
}

#[test]
fn the_gear_of_an_sts3215_is_found() {
    found("STS3215-7.4V");
}

/// The servo's own program limits its speed, so the maker's figures do not give its motor's friction.
#[test]
fn the_gear_of_an_sts3215_of_12_v_is_found() {
    found("STS3215-12V");
}

#[test]
fn a_servo_that_limits_its_current_is_tapped_as_others() {
    let case = Case::new("XL330-M288-T", 1.0, &[]);
    let tapped = case.tap_on(case.line(&[(MODE, 5)]), &case.settings(150)).unwrap();
    assert!(case.off(&tapped).iter().all(|off| off.abs() < 0.2), "{tapped}");
    // Now with a current limit that is lower than the tap needs.
    let line = case.line(&[(MODE, 5), (38, 700)]);
    let error = case.tap_on(line, &case.settings(150)).unwrap_err().to_string();
    assert!(
        error.contains("its Current Limit is 0.700 A, and this tap takes up to 1.0"),
        "{error}"
    );
}

/// The rotor is light, the gear stiff, and the motor brakes: the oscillation ends before an encoder can measure it.
#[test]
fn an_xm430_is_refused() {
    for (load, changes) in [(1.0, &[] as &[&str]), (4.0, &["damping=0.33"]), (10.0, &[])] {
        let case = Case::new("XM430-W350-T", load, changes);
        for mode in [3, 5] {
            let line = case.line(&[(MODE, mode)]);
            let error = case.tap_on(line, &case.settings(150)).unwrap_err().to_string();
            let is_said = ["not precise enough", "rings by", "does not ring", "too seldom"]
                .iter()
                .any(|words| error.contains(words));
            assert!(is_said, "{load}: {error}");
        }
    }
}

#[test]
fn what_makes_a_number_wrong_is_refused() {
    let case = Case::new("MX-64", 2.0, &[]);
    // The rig file has half of the real inertia.
    let mut settings = case.settings(150);
    settings.load.inertia_kg_m2 *= 0.5;
    let error = case.tap_on(case.line(&[]), &settings).unwrap_err().to_string();
    assert!(error.contains("it speeds up as if its motor had"), "{error}");
    // The servo has almost no load.
    settings.load.inertia_kg_m2 = 1e-3;
    let error = case.tap_on(case.line(&[]), &settings).unwrap_err().to_string();
    assert!(error.contains("Fix a weight to it"), "{error}");
    // Its position limits are too narrow: Min and Max Position Limit.
    let line = case.line(&[(52, 2000), (48, 2100)]);
    let error = case.tap_on(line, &case.settings(40)).unwrap_err().to_string();
    assert!(error.contains("deg of room"), "{error}");
    // It gives at most a quarter of its supply: PWM Limit.
    let error = case.tap_on(case.line(&[(36, 221)]), &case.settings(40)).unwrap_err().to_string();
    assert!(error.contains("its PWM Limit is 25.0 %"), "{error}");
    // With this Status Return Level the servo answers only reads.
    let error = case.tap_on(case.line(&[(68, 1)]), &case.settings(40)).unwrap_err().to_string();
    assert!(error.contains("it does not answer writes"), "{error}");
    // A current mode has no goal position to hold.
    let error = case.tap_on(case.line(&[(MODE, 0)]), &case.settings(40)).unwrap_err().to_string();
    assert!(error.contains("Set a mode of position first"), "{error}");
}

/// Returns all registers that a test may change, with their addresses.
fn registers(servo: &SimServo<'_>) -> [(u16, i32); 7] {
    // Torque, position gain, Goal PWM, Goal Current, profile, and mode, in this order.
    [TORQUE, 84, 100, 102, 108, 112, MODE].map(|address| (address, servo.get(address)))
}

/// A line on which a signal arrives after some packets.
struct Signalled {
    line: SimLine,
    left: u32,
    flag: Arc<AtomicBool>,
}

impl Exchange for Signalled {
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()> {
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            self.flag.store(true, Ordering::Relaxed);
        }
        self.line.exchange(bytes, wait, take)
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        self.line.set_baud(baud)
    }

    fn pause(&mut self, time: Duration) {
        self.line.pause(time);
    }

    fn now(&mut self) -> Duration {
        self.line.now()
    }
}

#[test]
fn a_test_that_is_ended_leaves_all_as_it_was() {
    let case = Case::new("XL330-M288-T", 1.0, &[]);
    for is_on in [false, true] {
        let mut line = case.line(&[(MODE, 5)]);
        let bench = &mut line.bench;
        for (address, value) in [(84, 444), (100, 600), (102, 900), (108, 30), (112, 200)] {
            bench.servos_mut()[0].set(address, value);
        }
        bench.servos_mut()[0].set(TORQUE, is_on.into());
        let before = registers(&bench.servos()[0]);
        let flag = Arc::new(AtomicBool::new(false));
        let line = Signalled { line, left: 3000, flag: Arc::clone(&flag) };
        let mut client = Client::new(line, Protocol::Dynamixel, BAUD, Patience::default()).unwrap();
        client.stop_at(flag);
        let servo = client.open(1, None).unwrap();
        let test = TapTest::new(&mut client, &servo, &case.model(), &case.settings(30)).unwrap();
        let error = test.run(&mut client).unwrap_err();
        assert!(matches!(error, ServiceError::Stopped), "{error}");
        client.line_mut().line.bench.run_us(1_000_000);
        let servo = &client.line_mut().line.bench.servos()[0];
        assert_eq!(registers(servo), before);
        // A servo with torque off rests where friction stopped it, after a tap of some 20 deg. A servo that holds is as
        // far from its goal as friction allows: 0.0128 N m / 0.55 N m/rad, plus its play.
        let off_rad = (servo.shaft().position_rad - std::f64::consts::PI).abs();
        assert!(off_rad < if is_on { 0.05 } else { 0.8 }, "{off_rad}");
    }
}

/// A line on which goals are lost after the tap has begun.
struct LosesGoals {
    line: SimLine,
    heard: u32,
}

impl Exchange for LosesGoals {
    fn exchange(
        &mut self,
        bytes: &[u8],
        wait: Duration,
        take: &mut dyn FnMut(&[u8]) -> bool,
    ) -> io::Result<()> {
        let [low, high] = GOAL.to_le_bytes();
        if bytes.get(7..10) == Some(&[3, low, high]) {
            self.heard += 1;
            // The goals of the start position and of the tap arrive; the goal of the way back is lost.
            if self.heard > 2 {
                self.line.pause(wait);
                return Ok(());
            }
        }
        self.line.exchange(bytes, wait, take)
    }

    fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        self.line.set_baud(baud)
    }

    fn pause(&mut self, time: Duration) {
        self.line.pause(time);
    }

    fn now(&mut self) -> Duration {
        self.line.now()
    }
}

#[test]
fn a_servo_that_takes_no_goal_is_limp_with_all_registers_as_before() {
    let case = Case::new("XL330-M288-T", 1.0, &[]);
    let mut line = case.line(&[]);
    line.bench.servos_mut()[0].set(TORQUE, 1);
    let before = registers(&line.bench.servos()[0]);
    let line = LosesGoals { line, heard: 0 };
    let mut client = Client::new(line, Protocol::Dynamixel, BAUD, Patience::default()).unwrap();
    let servo = client.open(1, None).unwrap();
    let test = TapTest::new(&mut client, &servo, &case.model(), &case.settings(30)).unwrap();
    let error = test.run(&mut client).unwrap_err().to_string();
    assert!(error.contains("Goal Position"), "{error}");
    let after = registers(&client.line_mut().line.bench.servos()[0]);
    assert_eq!(after[0], (TORQUE, 0));
    assert_eq!(after[1..], before[1..]);
}
