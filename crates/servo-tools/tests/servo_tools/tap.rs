//! Tap tests of simulated servos: what was put in is found.

use sinew_rig::description::ServoModel;
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo as SimServo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::supply::Supply;
use sinew_servo_sim::variation::{Change, Variation};
use sinew_servo_tools::tap::{Load, Settings, TapTest, Tapped};
use sinew_servo_tools::{Client, Protocol, ServiceError, Settings as Patience};

use crate::common::SimLine;

/// A servo, its load, and how it differs from its kind.
struct Case {
    kind: &'static str,
    /// In inertias of its rotor.
    load: f64,
    /// Part of its stall torque, at level.
    gravity: f64,
    changes: &'static [&'static str],
    mode: Option<i32>,
}

impl Case {
    /// Kind as it is.
    fn truth(&self) -> Parameters {
        let mut kind = Parameters::built_in(self.kind).unwrap();
        let changes: Vec<Change> = self.changes.iter().map(|word| word.parse().unwrap()).collect();
        Variation::of(&changes).unwrap().change_servo(&mut kind, 0.002);
        kind
    }

    fn tap(&self, strength: f64, taps: u32) -> Result<Tapped, ServiceError> {
        let kind = self.truth();
        let model = ServoModel::built_in(self.kind).unwrap();
        let load_kg_m2 = self.load * model.rotor_inertia_kg_m2.value;
        let gravity_nm = self.gravity * model.stall_torque_nm.value;
        let middle = 0.5 * kind.range_rad;
        let arm =
            Arm { inertia_kg_m2: load_kg_m2, gravity_nm, level_rad: middle, ..Arm::default() };
        let memory = Box::leak(Box::new([0; MEMORY_LEN]));
        let mut servo = SimServo::new(&kind, 1, memory).unwrap();
        servo.set_baud(1_000_000).unwrap();
        servo.refine_gear(20);
        let mut line = SimLine::new(&[(self.kind, 1)]);
        line.bench = Bench::new(vec![servo], vec![arm], Supply::stiff(kind.voltage_v));
        let protocol =
            if self.kind.starts_with('S') { Protocol::Feetech } else { Protocol::Dynamixel };
        let mut client = Client::new(line, protocol, 1_000_000, Patience::default()).unwrap();
        let servo = client.open(1, None).unwrap();
        let load = Load { inertia_kg_m2: load_kg_m2, gravity_nm: -gravity_nm };
        let settings = Settings { taps, strength, load };
        if let Some(mode) = self.mode {
            client.line_mut().bench.servos_mut()[0].set(11, mode);
        }
        if gravity_nm > 0.0 {
            // It holds what hangs on it.
            let torque = if self.kind.starts_with('S') { 40 } else { 64 };
            client.line_mut().bench.servos_mut()[0].set(torque, 1);
        }
        let test = TapTest::new(&mut client, &servo, &model, &settings)?;
        println!("reach {:.1} deg", test.reach_rad().to_degrees());
        test.run(&mut client, &mut |_| true)
    }
}

/// Nine cases, three of each kind; the table is printed.
fn found(kind: &'static str) {
    let case = |load, gravity, changes| Case { kind, load, gravity, changes, mode: None };
    let cases = [
        case(1.0, 0.0, &[] as &[&str]),
        case(2.0, 0.1, &["stiffness=0.5", "play=2"]),
        case(0.5, 0.0, &["damping=0.33"]),
        case(1.0, 0.0, &["stiffness=2"]),
        case(4.0, 0.05, &["stiffness=2", "damping=0.33", "play=2"]),
        case(2.0, 0.0, &["stiffness=0.5"]),
    ];
    let mut worst: f64 = 0.0;
    for case in &cases {
        let truth = case.truth();
        let name =
            format!("{} load {} gravity {} {:?}", case.kind, case.load, case.gravity, case.changes);
        let tapped = match case.tap(strength(), taps()) {
            Ok(tapped) => tapped,
            Err(error) => {
                println!("{name}: {error}");
                worst = f64::INFINITY;
                continue;
            }
        };
        let joint = tapped.fitted.joint;
        let [stiffness, damping] = [truth.gear_stiffness_nm_rad, truth.gear_damping_nm_s];
        let off = [joint.stiffness_nm_rad / stiffness - 1.0, joint.damping_nm_s / damping - 1.0];
        println!(
            "{name}: {stiffness:.1} {damping:.4}: off {:+.1} %, {:+.1} %\n{tapped}",
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
fn the_gear_of_an_mx_64_is_found() {
    found("MX-64");
}

#[test]
fn the_gear_of_an_sts3215_is_found() {
    found("STS3215-7.4V");
}

#[test]
fn the_gear_of_an_xm430_is_found() {
    found("XM430-W350-T");
}

#[test]
fn the_gear_of_an_mx_28_is_found() {
    found("MX-28");
}

#[test]
fn the_gear_of_an_xl430_is_found() {
    found("XL430-W250-T");
}

#[test]
#[ignore = "explore"]
fn explore() {
    for line in std::env::var("TAP_CASES").unwrap().split(';') {
        let words: Vec<&str> = line.split_whitespace().collect();
        let mode =
            words[3..].iter().find_map(|w| w.strip_prefix("mode")).map(|m| m.parse().unwrap());
        let changes: Vec<&'static str> = words[3..]
            .iter()
            .filter(|w| !w.starts_with("mode"))
            .map(|w| &*Box::leak(w.to_string().into_boxed_str()))
            .collect();
        let case = Case {
            kind: Box::leak(words[0].to_owned().into_boxed_str()),
            load: words[1].parse().unwrap(),
            gravity: words[2].parse().unwrap(),
            changes: Box::leak(changes.into_boxed_slice()),
            mode,
        };
        let truth = case.truth();
        match case.tap(strength(), taps()) {
            Ok(tapped) => {
                let joint = tapped.fitted.joint;
                println!(
                    "{line}: K {:+.1} % c {:+.1} % se {:.3?} torque {:.2}\n   {tapped}",
                    100.0 * (joint.stiffness_nm_rad / truth.gear_stiffness_nm_rad - 1.0),
                    100.0 * (joint.damping_nm_s / truth.gear_damping_nm_s - 1.0)
                );
            }
            Err(error) => println!("{line}: {error}"),
        }
    }
}

fn taps() -> u32 {
    std::env::var("TAP_N").map_or(100, |n| n.parse().unwrap())
}

fn strength() -> f64 {
    std::env::var("TAP_S").map_or(0.5, |n| n.parse().unwrap())
}
