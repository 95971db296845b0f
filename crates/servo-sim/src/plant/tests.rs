#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts of steps and of encoders, and numbers of a core that computes in f32"
)]

use glam::{DMat3, DQuat, DVec3};
use serde::Deserialize;
use sinew_rig::description::{Drive, DriveKind};
use sinew_rig::mechanism::{InverseDynamics, Link};
use sinew_rig::new::arm;
use sinew_rig::servo::Address;

use crate::model::Parameters;
use sinew_servo_bus::dynamixel::Instruction;

use super::*;
use crate::bench::Bench;
use crate::device::{MEMORY_LEN, Servo};
use crate::rig::servos;
use crate::supply::Supply;

const STEP_S: f64 = RigPlant::STEP_S;

#[derive(Deserialize)]
struct File {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    gravity: [f64; 3],
    bodies: Vec<GoldenBody>,
    states: Vec<State>,
}

#[derive(Deserialize)]
struct GoldenBody {
    parent: i64,
    joint: String,
    axes: Vec<[f64; 3]>,
    offset: [f64; 3],
    rot: [f64; 4],
    mass: f64,
    com: [f64; 3],
    inertia: [f64; 6],
    rotor: f64,
}

#[derive(Deserialize)]
struct State {
    q: Vec<f64>,
    qd: Vec<f64>,
    efforts: Vec<f64>,
    acc: Vec<f64>,
    #[serde(rename = "H_lower")]
    mass_matrix_lower: Vec<f64>,
}

impl GoldenBody {
    fn link(&self) -> Link {
        let axis = |index: usize| DVec3::from(self.axes[index]);
        let joint = match self.joint.as_str() {
            "revolute" => JointModel::Revolute(axis(0)),
            "prismatic" => JointModel::Prismatic(axis(0)),
            "universal" => JointModel::Universal([axis(0), axis(1)]),
            "spherical" => JointModel::Spherical,
            "fixed" => JointModel::Fixed,
            other => panic!("a joint of unknown kind: {other}"),
        };
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        Link {
            rotation: DQuat::from_array(self.rot),
            mass_kg: self.mass,
            center_of_mass_m: self.com.into(),
            inertia_kg_m2: DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]),
            rotor_inertia: self.rotor,
            ..Link::on(usize::try_from(self.parent).ok(), joint, self.offset.into())
        }
    }
}

/// Compares with MuJoCo: accelerations for efforts, and mass matrices, for rigs with all kinds of joints.
#[test]
fn accelerations_and_mass_matrices_are_the_golden_ones() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/rotors.json");
    let file: File = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    assert_eq!(file.cases.len(), 6);
    for case in &file.cases {
        let bodies = case.bodies.iter().map(GoldenBody::link).collect();
        let mechanism = Mechanism { bodies, linked: Vec::new() };
        let mut mechanics = Mechanics::new(&mechanism, case.gravity.into());
        let size = mechanics.dofs();
        for state in &case.states {
            mechanics.set(&state.q, &state.qd);
            let mut matrix = Symmetric::zeros(size);
            let mut x: Vec<f64> =
                state.efforts.iter().enumerate().map(|(at, x)| x - mechanics.bias(at)).collect();
            for body in 0..mechanism.bodies.len() {
                for row in mechanics.dofs_of(body) {
                    for column in 0..=row {
                        let rotor = f64::from(u8::from(row == column))
                            * mechanism.bodies[body].rotor_inertia;
                        let element = mechanics.mass(row, column) + rotor;
                        let golden = state.mass_matrix_lower[row * (row + 1) / 2 + column];
                        // Both values are f64, and the file has all digits; the largest values are some 100 kg m².
                        assert!((element - golden).abs() < 1e-10, "{}: {element}", case.name);
                        matrix.add(row, column, element);
                    }
                }
            }
            matrix.factor(0.0);
            matrix.solve(&mut x);
            let largest = state.acc.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            for (x, golden) in x.iter().zip(&state.acc) {
                // Tolerance: condition number of the matrix, up to 1e5, times rounding of some 1e-16 · 30 bodies.
                assert!((x - golden).abs() < 1e-9 * largest, "{}: {x} {golden}", case.name);
            }
        }
    }
}

/// Without servos and friction, the total energy is constant. The error of semi-implicit Euler varies with the motion,
/// and halves with the step.
#[test]
fn a_rig_that_swings_freely_keeps_its_energy() {
    let mut description = arm(4).unwrap();
    (description.drives, description.servos) = (Vec::new(), Vec::new());
    for joint in &mut description.joints {
        joint.range_rad.clear();
        (joint.friction, joint.damping) = (0.0, 0.0);
    }
    let mechanism = description.mechanism().unwrap();
    // Returns the maximum error of the total energy, and the maximum kinetic energy.
    let run = |dt_s: f64| {
        let mut plant = RigPlant::new(&description, &mechanism, &[]).unwrap();
        // Only the bodies have inertia, and the rig must fall from its start pose.
        plant.extra.fill(0.0);
        plant.q.iter_mut().for_each(|q| *q += 0.7);
        let begin_j = plant.energy_j();
        let rest = vec![0.0; plant.qd.len()];
        let (mut off_j, mut motion_j) = (0.0_f64, 0.0_f64);
        for step in 0..(4.0 / dt_s) as u32 {
            plant.step(dt_s, &[], &mut []);
            if step % 16 == 0 {
                let now_j = plant.energy_j();
                off_j = off_j.max((now_j - begin_j).abs());
                plant.mechanics.set(&plant.q, &rest);
                motion_j = motion_j.max(now_j - plant.mechanics.energy_j());
            }
        }
        (off_j, motion_j)
    };
    let (coarse_j, motion_j) = run(STEP_S);
    let (fine_j, _) = run(0.25 * STEP_S);
    println!("{coarse_j:e} J, {fine_j:e} J of {motion_j} J");
    assert!(coarse_j < 0.05 * motion_j, "{coarse_j} J of {motion_j} J");
    // First order: the error is proportional to the step. The extrapolated error for a step of zero (Richardson) is
    // nearly zero; the rest is second order, and the two runs have their maxima at different times.
    let left_j = (4.0 * fine_j - coarse_j) / 3.0;
    assert!(left_j.abs() < 0.1 * coarse_j, "{left_j} J of {coarse_j} J");
}

struct Run {
    shafts: Vec<Vec<f64>>,
}

fn write<P: Plant>(bench: &mut Bench<'_, P>, id: u8, address: u16, data: &[u8]) {
    let mut packet = [0; 32];
    let len = Instruction::Write { address, data }.encode(id, &mut packet).unwrap();
    let mut answered = 0;
    bench.exchange(&packet[..len], 10_000, |said| {
        answered += said.len();
        answered >= 11
    });
}

/// Runs a bench with the last servos of a rig. Servos with `on` hold their home, the others have torque off; servo
/// `goal.0` moves by `goal.1` counts.
fn run<P: Plant>(
    description: &Description,
    plant: impl FnOnce(&[&str]) -> P,
    on: &[bool],
    goal: (usize, i32),
    steps: u32,
) -> Run {
    let mechanism = description.mechanism().unwrap();
    let all = servos(description, &mechanism).unwrap();
    let own = &all[all.len() - on.len()..];
    let names: Vec<&str> = own.iter().map(|servo| servo.name.as_str()).collect();
    let mut memory = vec![[0; MEMORY_LEN]; own.len()];
    let mut simulated = Vec::new();
    for ((servo, memory), on) in own.iter().zip(&mut memory).zip(on) {
        let mut device = Servo::new(&servo.kind, servo.id().unwrap(), memory).unwrap();
        device.place(servo.home_rad);
        if !on {
            // Current mode with a goal of zero: the servo does not drive its shaft.
            device.set(11, 0);
        }
        simulated.push(device);
    }
    let voltage_v = own[0].kind.voltage_v;
    let mut bench = Bench::new(simulated, plant(&names), Supply::stiff(voltage_v));
    for (place, servo) in own.iter().enumerate() {
        let home = (servo.home_rad / servo.kind.resolution_rad).round() as i32;
        let to = home + if goal.0 == place { goal.1 } else { 0 };
        write(&mut bench, servo.id().unwrap(), 64, &[1]);
        write(&mut bench, servo.id().unwrap(), 116, &to.to_le_bytes());
    }
    let mut shafts = vec![Vec::new(); own.len()];
    for _ in 0..steps {
        bench.run_us(1000);
        for (track, servo) in shafts.iter_mut().zip(bench.servos()) {
            track.push(servo.shaft().position_rad);
        }
    }
    Run { shafts }
}

/// Tests one servo on one joint: the rig behaves like that servo's arm.
#[test]
fn a_rig_of_one_servo_moves_as_its_arm_does() {
    // Only the joint that bends can move: the joint that turns has no servo on the bench, so it stays.
    let description = arm(2).unwrap();
    let mechanism = description.mechanism().unwrap();
    let arms = vec![servos(&description, &mechanism).unwrap()[1].load];
    let alone = run(&description, |_| arms, &[true], (0, 500), 600);
    let whole = |names: &[&str]| RigPlant::new(&description, &mechanism, names).unwrap();
    let rig = run(&description, whole, &[true], (0, 500), 600);
    let farthest = alone.shafts[0]
        .iter()
        .zip(&rig.shafts[0])
        .map(|(alone, rig)| (alone - rig).abs())
        .fold(0.0, f64::max);
    let moved = alone.shafts[0][599] - alone.shafts[0][0];
    assert!(moved > 0.6, "{moved}");
    println!("{farthest:e}");
    // Tolerance: the motion in one step of the plant, 0.25 ms, at the 2 rad/s of this test.
    assert!(farthest < 5e-4, "{farthest}");
}

/// Gravity at home agrees with inverse dynamics, and a servo that swings moves its neighbours, whose torque is off.
#[test]
fn what_one_servo_moves_the_others_feel() {
    let description = arm(4).unwrap();
    let mechanism = description.mechanism().unwrap();
    let run = |plant: bool, goal| {
        let on = [true, true, false, false];
        if plant {
            let whole = |names: &[&str]| RigPlant::new(&description, &mechanism, names).unwrap();
            run(&description, whole, &on, goal, 400)
        } else {
            let own = servos(&description, &mechanism).unwrap();
            let arms: Vec<Arm> = own.iter().map(|servo| servo.load).collect();
            run(&description, |_| arms, &on, goal, 400)
        }
    };
    let far = |a: &Run, b: &Run| {
        let of = |servo: usize| (a.shafts[servo][399] - b.shafts[servo][399]).abs();
        [of(1), of(2)]
    };
    let [moved, followed] = far(&run(true, (1, 700)), &run(true, (1, 0)));
    assert!(moved > 0.5 && followed > 0.1, "{moved} {followed}");
    let [moved, followed] = far(&run(false, (1, 700)), &run(false, (1, 0)));
    assert!(moved > 0.5 && followed < 1e-12, "{moved} {followed}");
}

/// Torques that hold a pose by virtual work keep the rig still: with a mirrored servo, a gear, a differential, a mimic
/// joint, and two servos on one joint.
#[test]
fn drives_of_all_kinds_hold_what_they_have_to() {
    let (half, two) = (vec![0.5, 0.5], vec![0.5, -0.5]);
    let rows = |rows: Vec<Vec<f64>>| DriveKind::Matrix { rows, offset: Vec::new() };
    let cases: [(&str, Vec<usize>, Vec<usize>, DriveKind); 3] = [
        ("differential", vec![1, 2], vec![1, 2], rows(vec![half, two.clone()])),
        ("mimic", vec![1, 2], vec![1], rows(vec![vec![1.0], vec![0.5]])),
        ("pair", vec![1], vec![1, 2], rows(vec![two])),
    ];
    for (name, joints, own, kind) in cases {
        let mut description = arm(if name == "pair" { 2 } else { 3 }).unwrap();
        if name == "pair" {
            let twin = description.servos[1].clone();
            let (name, address) = ("twin".to_owned(), Address::Id(9));
            description.servos.push(sinew_rig::description::Servo { name, address, ..twin });
        }
        description.servos[0].direction = -1;
        description.servos[0].gear = 1.5;
        let drive = Drive {
            joints: joints.iter().map(|at| description.joints[*at].name.clone()).collect(),
            servos: own.iter().map(|at| description.servos[*at].name.clone()).collect(),
            kind,
        };
        description.drives.truncate(1);
        description.drives.push(drive);
        let moved = 1 + joints.len();
        for joint in &mut description.joints {
            joint.home_rad = Some(0.5);
        }
        let mechanism = description.mechanism().unwrap();
        let names: Vec<String> = description.servos.iter().map(|s| s.name.clone()).collect();
        let names: Vec<&str> = names[..=*own.last().unwrap()].iter().map(String::as_str).collect();
        let mut plant = RigPlant::new(&description, &mechanism, &names).unwrap();
        let actuation = description.actuation().unwrap();
        let q: Vec<f32> = plant.q.iter().map(|q| *q as f32).collect();
        let rest = vec![0.0; q.len()];
        let mut dynamics = InverseDynamics::of(&mechanism).unwrap();
        let efforts = dynamics.efforts(&q, &rest, &rest).unwrap().to_vec();
        let mut pushes = vec![Push::default(); names.len()];
        for of in &actuation.drives {
            let pose = of.drive.at_joints(&of.joints.iter().map(|at| q[*at]).collect::<Vec<_>>());
            let needed: Vec<f32> = of.joints.iter().map(|at| efforts[*at]).collect();
            for (servo, shaft) in
                of.servos.iter().zip(pose.unwrap().servo_torques(&needed).unwrap())
            {
                let gear = actuation.servos[*servo].settings().gear;
                pushes[*servo].torque_nm = f64::from(shaft / gear);
            }
        }
        let begin = plant.q.clone();
        let mut shafts = plant.own.clone();
        for _ in 0..400 {
            plant.step(STEP_S, &pushes, &mut shafts);
        }
        // The torques are balanced up to f32 rounding, whose effect grows as exp(0.1 s · 20 / s).
        for at in 0..moved {
            assert!((plant.q[at] - begin[at]).abs() < 1e-4, "{name}: {:?} {begin:?}", plant.q);
        }
        // Without these torques the rig falls.
        for _ in 0..400 {
            plant.step(STEP_S, &vec![Push::default(); names.len()], &mut shafts);
        }
        let fell: f64 = plant.q.iter().zip(&begin).map(|(q, begin)| (q - begin).abs()).sum();
        assert!(fell > 1e-3, "{name}: {fell}");
        // Positions of servos and joints still match.
        for (drive, of) in actuation.drives.iter().enumerate() {
            let expected = {
                let driven = &plant.drives[drive];
                driven.positions_rad(&driven.at(&plant.q).unwrap())
            };
            for (servo, expected) in of.servos.iter().zip(expected) {
                let off = plant.own[*servo].position_rad - expected;
                assert!(off.abs() < 1e-5, "{name}: {off}");
            }
        }
    }
}

/// Creates a bench with all servos of a rig without gravity, with torque off.
fn limp<'m>(
    description: &Description,
    memory: &'m mut [[u8; MEMORY_LEN]],
    change: impl Fn(&mut Parameters),
) -> Bench<'m, RigPlant> {
    let mechanism = description.mechanism().unwrap();
    let own = servos(description, &mechanism).unwrap();
    let names: Vec<&str> = own.iter().map(|servo| servo.name.as_str()).collect();
    let plant = RigPlant::under(description, &mechanism, &names, DVec3::ZERO).unwrap();
    let mut simulated = Vec::new();
    for (servo, memory) in own.iter().zip(memory) {
        let mut kind = servo.kind.clone();
        change(&mut kind);
        let mut device = Servo::new(&kind, servo.id().unwrap(), memory).unwrap();
        device.place(servo.home_rad);
        device.set(11, 16);
        simulated.push(device);
    }
    Bench::new(simulated, plant, Supply::stiff(own[0].kind.voltage_v))
}

/// A push below the shafts' friction moves them only until the servos react; a push above it moves them through the
/// play.
#[test]
fn friction_at_shafts_holds_a_rig() {
    let description = arm(6).unwrap();
    let kind = Parameters::built_in("XL330-M288-T").unwrap();
    let most_nm = kind.output_friction_share * kind.friction_nm;
    for (dof, sign) in [(1, 1.0), (2, -1.0), (5, 1.0)] {
        let mut memory = [[0; MEMORY_LEN]; 6];
        let mut bench = limp(&description, &mut memory, |_| ());
        let home = bench.plant.q.clone();
        let moved = |plant: &RigPlant| {
            plant.q.iter().zip(&home).map(|(q, home)| (q - home).abs()).fold(0.0, f64::max)
        };
        assert!(bench.plant.push(dof, sign * 0.9 * most_nm));
        bench.run_us(1_000_000);
        let soon = moved(&bench.plant);
        bench.run_us(60_000_000);
        let late = moved(&bench.plant);
        println!("{dof}: {soon:e} rad, {late:e} rad");
        // At first the joint moves by some thousandths of the play, then only by rounding errors.
        assert!(soon < 5e-5 && late - soon < 1e-9, "{dof}: {soon:e} {late:e}");
        assert!(bench.plant.push(dof, sign * 1.5 * most_nm));
        bench.run_us(1_000_000);
        let through = moved(&bench.plant);
        assert!(through > 0.4 * kind.backlash_rad, "{dof}: {through}");
    }
    assert!(!limp(&description, &mut [[0; MEMORY_LEN]; 6], |_| ()).plant.push(6, 1.0));
}

/// Swinging neighbours shake a joint that is held by friction: it must not drift.
#[test]
fn friction_at_shafts_holds_beside_what_swings() {
    let description = arm(3).unwrap();
    let mut memory = [[0; MEMORY_LEN]; 3];
    // All friction is at the shaft, and exceeds the shaking by the neighbour.
    let mut bench = limp(&description, &mut memory, |kind| {
        kind.output_friction_share = 1.0;
        kind.friction_nm = 0.08;
    });
    let begin = bench.plant.q[2];
    bench.plant.push(2, 0.02);
    let mut swung = 0.0_f64;
    let mut after = Vec::new();
    for step in 0..20_000 {
        let phase = 2.0 * std::f64::consts::PI * 3.0 * f64::from(step) * 1e-3;
        bench.plant.push(1, 0.1 * libm::sin(phase));
        bench.run_us(1_000);
        swung = swung.max(bench.plant.qd[1].abs());
        if step % 5_000 == 4_999 {
            after.push((bench.plant.q[2] - begin).abs());
        }
    }
    println!("{swung} rad/s: {after:?} rad");
    assert!(swung > 0.5, "{swung}");
    // The push moved the joint at the start; 60 swings add almost nothing.
    assert!(after[0] < 5e-5 && (after[3] - after[0]).abs() < 1e-7, "{after:?}");
}

/// Strong servos with full and changing PWM move very light bodies against each other and against the stops.
#[test]
fn it_is_stable_with_stiff_gears_and_light_bodies() {
    for (joints, model, mass, stiffer) in [
        (6, "XM430-W350-T", 0.05, 1.0),
        (6, "XL330-M288-T", 1.0, 1.0),
        (6, "XM430-W350-T", 5.0, 1.0),
        // In these chains the torque of one servo shakes all bodies. With torques for predicted shafts alone, they
        // diverge.
        (14, "XM430-W350-T", 1.0, 1.0),
        (12, "MX-64", 1.0, 1.0),
        (20, "XL330-M288-T", 0.02, 30.0),
        (14, "XM430-W350-T", 0.02, 30.0),
    ] {
        let mut description = arm(joints).unwrap();
        for servo in &mut description.servos {
            model.clone_into(&mut servo.model);
        }
        for body in &mut description.bodies {
            body.mass_kg *= mass;
        }
        let mechanism = description.mechanism().unwrap();
        let own = servos(&description, &mechanism).unwrap();
        let names: Vec<&str> = own.iter().map(|servo| servo.name.as_str()).collect();
        let plant = RigPlant::new(&description, &mechanism, &names).unwrap();
        let mut memory = vec![[0; MEMORY_LEN]; own.len()];
        let mut simulated = Vec::new();
        for (servo, memory) in own.iter().zip(&mut memory) {
            let mut kind = servo.kind.clone();
            kind.gear_stiffness_nm_rad *= stiffer;
            let mut device = Servo::new(&kind, servo.id().unwrap(), memory).unwrap();
            device.place(servo.home_rad);
            // Operating mode PWM.
            device.set(11, 16);
            simulated.push(device);
        }
        let mut bench = Bench::new(simulated, plant, Supply::stiff(own[0].kind.voltage_v));
        let ids = 1..=u8::try_from(joints).unwrap();
        ids.clone().for_each(|id| write(&mut bench, id, 64, &[1]));
        let mut random = crate::random::Random::new(7);
        let free_rad_s = own[0].kind.voltage_v / own[0].kind.torque_constant_nm_a;
        for _ in 0..200 {
            for id in ids.clone() {
                let pwm = random.between(-885.0, 885.0) as i16;
                write(&mut bench, id, 100, &pwm.to_le_bytes());
            }
            bench.run_us(20_000);
            for servo in bench.servos() {
                let Shaft { position_rad, velocity_rad_s } = servo.shaft();
                // A motor cannot drive a shaft faster than its no-load speed, but falling bodies and rebounds from a
                // stop can.
                assert!(
                    velocity_rad_s.abs() < 10.0 * free_rad_s,
                    "{joints} {model}: {velocity_rad_s} rad/s"
                );
                assert!(position_rad.abs() < 10.0, "{joints} {model}: {position_rad} rad");
            }
        }
    }
}
