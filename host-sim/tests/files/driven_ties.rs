//! Rigs with tied joints and a servo on each leader. The tests play, export and bake a motion, as a user would.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use sinew_rig::description::{Drive, DriveKind, JointType, Servo, ServoModel};
use sinew_rig::mechanism::{JointModel, Mechanism, Ties};
use sinew_rig::servo::Address;
use sinew_rig::{Description, toml_file};

use crate::common::{sinew_in, text};
use crate::field::{done, table};
use crate::ties::urdf;

/// Maximum number of joints that a drive moves.
const DRIVE_MOST: usize = 6;
/// Torque of an XM430 at standstill, N m.
const XM430_NM: f64 = 4.1;
/// Distance that a slide moves per radian of its servo, m/rad.
const RACK_M_RAD: f64 = 0.02;

/// Returns a kind of servo like an XM430, whose motor is `motor` times as strong, and whose ratio is `gear` times as
/// large.
fn model(name: &str, motor: f64, gear: f64) -> ServoModel {
    let xm430 = ServoModel::built_in("XM430-W350-T").expect("it is built in");
    let mut model = ServoModel { name: name.to_owned(), ..xm430 };
    model.stall_current_a.value *= motor;
    model.torque_constant_nm_a.value *= gear;
    model.no_load_speed_rad_s.value /= gear;
    for torque in
        [&mut model.stall_torque_nm, &mut model.continuous_torque_nm, &mut model.friction_nm]
    {
        torque.value *= motor * gear;
    }
    for reflected in
        [&mut model.rotor_inertia_kg_m2, &mut model.damping_nm_s, &mut model.position_gain_nm_rad]
    {
        reflected.value *= motor * gear * gear;
    }
    for gears in
        [&mut model.gear_stiffness_nm_rad, &mut model.gear_damping_nm_s].into_iter().flatten()
    {
        gears.value *= motor * gear * gear;
    }
    model
}

/// Adds a servo to each joint that follows no other joint. The servo's drive also moves the followers, unless there are
/// too many. The kind of servo depends on the joint's effort; the strongest kind has a ratio of `gear` times the
/// XM430's.
fn put_servos(rig: &mut Description, mechanism: &Mechanism, gear: f64) {
    let ties = mechanism.ties();
    // Two kinds are built in, and two are kinds that a maker could build.
    rig.servo_models = vec![model("XM540-W270-T", 3.0, 1.0), model("XH540-W270-T", 3.0, gear)];
    let kinds =
        [("XL330-M288-T", 0.6), ("XM430-W350-T", XM430_NM), ("XM540-W270-T", 3.0 * XM430_NM)];
    for (body, link) in mechanism.bodies.iter().enumerate().skip(1) {
        let (JointModel::Revolute(_) | JointModel::Prismatic(_)) = link.joint else { continue };
        if ties.of(body).is_some() {
            continue;
        }
        let slides = |body: usize| matches!(mechanism.bodies[body].joint, JointModel::Prismatic(_));
        let own = if slides(body) { RACK_M_RAD } else { 1.0 };
        let mut moved = vec![(body, own, 0.0)];
        let followers = ties.each().filter(|tie| tie.leader == body);
        moved.extend(followers.map(|tie| (tie.body, own * tie.factor, tie.offset)));
        if moved.len() > DRIVE_MOST {
            moved.truncate(1);
        }
        let joint = rig.joints.iter().find(|joint| joint.name == link.joint_name).expect("a joint");
        // The servo has a margin above the joint's effort.
        let effort = 2.5 * joint.effort.unwrap_or(1.0);
        let kind = kinds
            .iter()
            .find(|(_, most)| effort <= *most)
            .map_or("XH540-W270-T", |(name, _)| *name);
        let id = u8::try_from(rig.servos.len() + 1).expect("few servos");
        rig.drives.push(Drive {
            joints: moved
                .iter()
                .map(|(body, ..)| mechanism.bodies[*body].joint_name.clone())
                .collect(),
            servos: vec![link.joint_name.clone()],
            kind: DriveKind::Matrix {
                rows: moved.iter().map(|(_, factor, _)| vec![*factor]).collect(),
                offset: moved.iter().map(|(.., offset)| *offset).collect(),
            },
        });
        rig.servos.push(Servo {
            name: link.joint_name.clone(),
            model: kind.to_owned(),
            // All servos of one bus must have the same supply voltage.
            bus: kind[..5].to_owned(),
            address: Address::Id(id),
            ..Servo::default()
        });
    }
    // The limits in the file apply to the robot's own motors, not to these servos.
    rig.joints.iter_mut().for_each(|joint| joint.effort = None);
}

/// Returns a table in which all leaders swing about home for 2 s. `share`: amplitude as a share of the distance to the
/// farther end of the range.
fn swung(mechanism: &Mechanism, ties: &Ties, share: f64) -> String {
    let leads = |(body, link): &(usize, &sinew_rig::mechanism::Link)| {
        matches!(link.joint, JointModel::Revolute(_) | JointModel::Prismatic(_))
            && ties.of(*body).is_none()
    };
    let leaders: Vec<_> =
        mechanism.bodies.iter().enumerate().filter(leads).map(|(_, link)| link).collect();
    let unit =
        |joint: JointModel| if matches!(joint, JointModel::Prismatic(_)) { "m" } else { "rad" };
    let mut csv = "time".to_owned();
    for link in &leaders {
        write!(csv, ",{}_{}", link.joint_name, unit(link.joint))
            .expect("a string takes everything");
    }
    for row in 0..=100 {
        let time_s = 0.02 * f64::from(row);
        write!(csv, "\n{time_s:.2}").expect("a string takes everything");
        for link in &leaders {
            let (home, [least, most]) =
                (link.home[0], link.ranges.first().copied().unwrap_or([-1.0, 1.0]));
            let reach = share * (most - home).max(home - least);
            let swing = home + reach * libm::sin(std::f64::consts::PI * time_s);
            write!(csv, ",{:.6}", swing.max(least).min(most)).expect("a string takes everything");
        }
    }
    csv + "\n"
}

/// Adds servos to a rig; plays, exports and bakes a swing; and checks that followers agree with their leaders.
#[track_caller]
fn assert_plays(folder: &Path, rig: &str, share: f64, gear: f64) {
    let mut description =
        toml_file::read(&fs::read_to_string(folder.join(rig)).expect("a rig")).expect("a rig");
    let mechanism = description.mechanism().expect("a mechanism");
    let ties = mechanism.ties();
    put_servos(&mut description, &mechanism, gear);
    let leaders = description.servos.len();
    fs::write(folder.join("driven.toml"), toml_file::write(&description)).expect("a rig");
    fs::write(folder.join("own.csv"), swung(&mechanism, &ties, share)).expect("a table");
    let on_rig = ["own.csv", "--rig", "driven.toml"];
    done(
        folder,
        &[&["clip", "export"], &on_rig[..], &["--fit", "--base", "stand", "-o", "o.csv"]].concat(),
    );
    let (header, rows) = table(&folder.join("o.csv"));
    for tie in ties.each() {
        let [own, leader] = [tie.body, tie.leader].map(|body| {
            let name = &mechanism.bodies[body].joint_name;
            header.iter().position(|column| column == name).expect("a column")
        });
        for row in &rows {
            let off = row[own] - tie.factor * row[leader] - tie.offset;
            assert!(off.abs() < 1e-7, "{rig}: {} is off by {off}", header[own]);
        }
    }
    let baked = sinew_in(folder, &[&["bake"], &on_rig[..], &["--fit", "-o", "o.show"]].concat());
    let said = text(&baked.stderr) + &text(&baked.stdout);
    assert!(baked.status.success() && !said.contains("EXCEEDED"), "{rig}: {said}");
    let played = sinew_in(folder, &[&["play"], &on_rig[..]].concat());
    let said = text(&played.stderr) + &text(&played.stdout);
    assert!(played.status.success() && said.contains("faults: none"), "{rig}: {said}");
    let driven: usize = description.drives.iter().map(|drive| drive.joints.len()).sum();
    println!("{rig}: {leaders} servos move {driven} joints");
}

#[test]
fn a_servo_on_each_leader_plays_ten_rigs() {
    // Each line contains the kind of the joints, and for each follower: its leader, factor, offset, half of its range.
    let rigs = [
        ("revolute", vec![(1, 1.0, 0.1, 2.0)]),
        ("revolute", vec![(1, 0.8, 0.0, 2.0)]),
        ("revolute", vec![(1, -1.0, 0.0, 2.0)]),
        ("revolute", vec![(1, 3.0, -0.5, 2.0)]),
        ("revolute", vec![(1, 0.02, 0.3, 1.0)]),
        ("revolute", vec![(1, 0.5, 0.0, 0.05)]),
        ("revolute", vec![(1, 0.7, 0.1, 1.5), (2, -1.3, 0.0, 1.5)]),
        (
            "revolute",
            vec![(1, 0.7, 0.1, 1.5), (2, 1.6, 0.2, 0.4), (3, -0.5, 0.0, 1.5), (1, 1.1, 0.0, 2.0)],
        ),
        ("prismatic", vec![(1, -1.0, 0.0, 0.02)]),
        ("prismatic", vec![(1, 0.5, 0.005, 0.008), (1, 2.0, 0.0, 0.05)]),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    for (index, (kind, followers)) in rigs.iter().enumerate() {
        fs::write(folder.join("r.urdf"), urdf(kind, followers)).expect("a robot");
        let rig = format!("r{index}.toml");
        done(folder, &["rig", "import", "r.urdf", "-o", &rig]);
        assert_plays(folder, &rig, 0.5, 2.4);
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn a_servo_on_each_leader_plays_humanoids_and_grippers() {
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data");
    let files = PathBuf::from(data).join("field/files");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    // Pepper's geared servos carry its trunk. The G1's waist is locked, because without torque its trunk would fall
    // before the rig is armed.
    for (name, share, gear) in [
        ("pepper", 0.1, 5.0),
        ("g1_29dof_rev_1_0_with_inspire_hand_FTP", 0.1, 2.4),
        ("robotiq2F85", 0.5, 2.4),
    ] {
        let urdf = files.join(format!("{name}.urdf"));
        let (urdf, rig) = (urdf.to_str().expect("UTF-8"), format!("{name}.toml"));
        done(folder, &["rig", "import", urdf, "--repair-inertia", "-o", &rig]);
        let path = folder.join(&rig);
        let mut description =
            toml_file::read(&fs::read_to_string(&path).expect("a rig")).expect("a rig");
        for joint in description.joints.iter_mut().filter(|joint| joint.name.starts_with("waist_"))
        {
            (joint.kind, joint.axis) = (JointType::Fixed, None);
            (joint.range_rad, joint.speed_rad_s, joint.effort) = (Vec::new(), None, None);
            (joint.friction, joint.damping) = (0.0, 0.0);
        }
        fs::write(&path, toml_file::write(&description)).expect("a rig");
        assert_plays(folder, &rig, share, gear);
    }
}
