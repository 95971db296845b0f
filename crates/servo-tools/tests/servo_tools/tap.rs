//! Tap tests of simulated servos: what was put in is found.

use sinew_rig::description::ServoModel;
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo as SimServo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::supply::Supply;
use sinew_servo_sim::variation::{Change, Variation};
use sinew_servo_tools::tap::{Settings, Tapped, tap};
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
        let arm = Arm { inertia_kg_m2: load_kg_m2, gravity_nm, level_rad: middle, ..Arm::default() };
        let memory = Box::leak(Box::new([0; MEMORY_LEN]));
        let mut servo = SimServo::new(&kind, 1, memory).unwrap();
        servo.set_baud(1_000_000).unwrap();
        let mut line = SimLine::new(&[(self.kind, 1)]);
        line.bench = Bench::new(vec![servo], vec![arm], Supply::stiff(kind.voltage_v));
        line.bench.run_us(1_000_000);
        let protocol =
            if self.kind.starts_with('S') { Protocol::Feetech } else { Protocol::Dynamixel };
        let mut client = Client::new(line, protocol, 1_000_000, Patience::default()).unwrap();
        let servo = client.open(1, None).unwrap();
        let settings = Settings { taps, strength, load_kg_m2, gravity_nm: -gravity_nm };
        let position = servo.table.named("Present Position").unwrap();
        let before = client.read(&servo, &position).unwrap();
        let tapped = tap(&mut client, &servo, &model, &settings, &mut |_| true);
        let after = client.read(&servo, &position).unwrap();
        eprintln!("{before} {after}");
        tapped
    }
}

#[test]
fn stiffness_and_damping_are_found() {
    let cases = [
        Case { kind: "XL330-M288-T", load: 1.0, gravity: 0.0, changes: &[] },
        Case { kind: "XL330-M288-T", load: 2.5, gravity: 0.1, changes: &["stiffness=0.5", "play=2"] },
        Case { kind: "XL330-M288-T", load: 0.5, gravity: 0.0, changes: &["damping=0.33"] },
        Case { kind: "STS3215-7.4V", load: 1.0, gravity: 0.0, changes: &[] },
        Case { kind: "STS3215-7.4V", load: 2.0, gravity: 0.0, changes: &["stiffness=0.5", "play=2"] },
        Case { kind: "STS3215-7.4V", load: 0.4, gravity: 0.0, changes: &["damping=0.33"] },
        Case { kind: "MX-64", load: 1.0, gravity: 0.0, changes: &[] },
        Case { kind: "MX-64", load: 2.0, gravity: 0.1, changes: &["stiffness=0.5", "play=2"] },
        Case { kind: "MX-64", load: 0.5, gravity: 0.0, changes: &["damping=0.33"] },
    ];
    let mut worst: f64 = 0.0;
    for case in &cases {
        let truth = case.truth();
        let tapped = case.tap(0.35, 40);
        eprintln!(
            "{} x{} g{} {:?}: {:.1} {:.4}",
            case.kind, case.load, case.gravity, case.changes, truth.gear_stiffness_nm_rad, truth.gear_damping_nm_s
        );
        match tapped {
            Err(error) => eprintln!("  {error}"),
            Ok(tapped) => {
                let joint = tapped.fitted.joint;
                let off = [
                    joint.stiffness_nm_rad / truth.gear_stiffness_nm_rad - 1.0,
                    joint.damping_nm_s / truth.gear_damping_nm_s - 1.0,
                ];
                eprintln!("  {tapped}\n  off {:+.1} % {:+.1} %", 100.0 * off[0], 100.0 * off[1]);
                worst = worst.max(off[0].abs()).max(off[1].abs());
            }
        }
    }
    assert!(worst < 0.2, "{worst}");
}
