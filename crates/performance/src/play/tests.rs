use std::f64::consts::FRAC_PI_8;

use sinew_firmware::supervisor::{Command, FaultSet, Overload, Refused, RegisterDiffers, State};
use sinew_retarget::feasibility::RigMotion;
use sinew_rig::Description;
use sinew_rig::description::{DriveKind, Mount, Supply};
use sinew_rig::new::arm;
use sinew_rig::servo::Address;
use sinew_servo_bus::dynamixel::table::address;
use sinew_servo_bus::feetech::table::address as feetech_address;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_show::write::Settings;

use super::*;
use crate::{Baker, ShowMarks};

/// Returns the end of a performance of an arm at rest on two buses, after `wrong` has set one register of a servo.
fn ended(wrong: Option<(usize, u16, i32)>) -> Ended {
    let mut rig = arm(3).unwrap();
    // The servos have two voltages, so the rig has no common supply.
    rig.supply = None;
    "STS3215-7.4V".clone_into(&mut rig.servos[1].model);
    "tip".clone_into(&mut rig.servos[1].bus);
    let mechanism = rig.mechanism().unwrap();
    let parts = RigParts::new(&rig, &mechanism, Options::default()).unwrap();
    let motion = RigMotion { dt_s: 0.1, rows: vec![mechanism.home(); 11] };
    let (rig_crc, settings) = (parts.rig_crc(), Settings::default());
    let baker = Baker { mechanism: &mechanism, rig: rig_crc, settings };
    let show = baker.bake(&motion, &ShowMarks::default());
    let show = show.unwrap().written.bytes;
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig, &mechanism).unwrap();
    let mut sim = SimulatedRig::new(&parts, Some(&show), &mut memories, plant).unwrap();
    if let Some((servo, register, raw)) = wrong {
        sim.set_register(servo, register, raw);
    }
    let mut director = Director::default();
    // From power-on to limp it takes 10 s: arming, the show, stopping and lowering.
    let most = 20 * parts.rate_hz;
    (0..most).find_map(|_| director.tick(&mut sim, false)).expect("it ends")
}

#[test]
fn a_rig_whose_registers_are_as_asked_plays_on_two_buses() {
    assert_eq!(ended(None), Ended::Done);
}

/// Sets a wrong register in the second servo of one bus, and in the only servo of the other bus.
#[test]
fn a_wrong_register_refuses_with_what_is_wrong() {
    let dynamixel = (2, address::TEMPERATURE_LIMIT, 80);
    let feetech = (1, u16::from(feetech_address::UNLOADING), 0);
    for ((servo, address, found), item, expected) in
        [(dynamixel, "Temperature Limit", 70), (feetech, "Unloading Condition", 44)]
    {
        let Ended::Refused(Refused::RegisterDiffers(differs)) =
            ended(Some((usize::from(servo), address, found)))
        else {
            panic!("{item} does not refuse")
        };
        assert_eq!(differs, RegisterDiffers { servo, item, address, found, expected });
    }
}

/// Returns the end of a performance of a hanging arm of 20 XL330, whose show begins with its second joint at an
/// angle.
fn ended_at(angle_rad: f64, supply_a: f64) -> (Ended, f64) {
    let mut rig = arm(20).unwrap();
    rig.mount = Mount { rotation_xyzw: [1.0, 0.0, 0.0, 0.0], ..Mount::default() };
    rig.supply = Some(Supply { voltage_v: 5.0, current_a: supply_a });
    for joint in &mut rig.joints {
        joint.home_rad = Some(0.0);
    }
    let mechanism = rig.mechanism().unwrap();
    let parts = RigParts::new(&rig, &mechanism, Options::default()).unwrap();
    let mut first = mechanism.home();
    first[1] = angle_rad;
    let motion = RigMotion { dt_s: 0.1, rows: vec![first; 11] };
    let (rig_crc, settings) = (parts.rig_crc(), Settings::default());
    let baker = Baker { mechanism: &mechanism, rig: rig_crc, settings };
    let show = baker.bake(&motion, &ShowMarks::default()).unwrap().written.bytes;
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig, &mechanism).unwrap();
    let mut sim = SimulatedRig::new(&parts, Some(&show), &mut memories, plant).unwrap();
    let mut director = Director::default();
    let mut most = 0.0_f64;
    let ended = (0..40 * parts.rate_hz).find_map(|_| {
        let ended = director.tick(&mut sim, false);
        most = sim.q().iter().fold(most, |most, q| most.max(q.abs()));
        ended
    });
    (ended.expect("it ends"), most.to_degrees())
}

/// The arm must not swing up until the supply sags: it is not armed.
#[test]
fn a_hanging_arm_that_its_servos_or_supply_cannot_lift_is_not_armed() {
    let (ended, most_deg) = ended_at(1.5, 60.0);
    let Ended::Refused(why @ Refused::Overload(Overload::Servo { dof: 1, mnm, most_mnm: 520 })) =
        ended
    else {
        panic!("{ended:?}")
    };
    assert!((521..3000).contains(&mnm), "{mnm}");
    let words = why.to_string();
    assert!(words.contains("joint 1 takes ") && words.ends_with(", which gives 520"), "{words}");
    assert!(most_deg < 2.0, "it moved by {most_deg} deg");

    // The servos can lift the arm by a small angle; with a weaker supply they cannot.
    let (ended, _) = ended_at(0.1, 60.0);
    assert_eq!(ended, Ended::Done);
    let (ended, _) = ended_at(0.3, 0.5);
    let is_weak = matches!(
        ended,
        Ended::Refused(Refused::Overload(Overload::Supply { dof: 1, ma: 501.., most_ma: 500 }))
    );
    assert!(is_weak, "{ended:?}");
}

/// Returns the face with the eight servos of `docs/first-rig.md`, on the channels of that page.
fn face() -> Description {
    const ON_IT: [&str; 8] = [
        "neck_turn",
        "jaw",
        "eye_turn_left",
        "eye_nod_left",
        "lid_upper_left",
        "eye_turn_right",
        "eye_nod_right",
        "lid_upper_right",
    ];
    let mut rig = sinew_rig::new::face();
    rig.servos.retain(|servo| ON_IT.contains(&servo.name.as_str()));
    rig.drives.retain(|drive| ON_IT.contains(&drive.joints[0].as_str()));
    rig
}

/// Bytes to a simulated PCA9685 move simulated servos. Its pin OE switches all pulses off, at the end and at an
/// emergency stop.
#[test]
fn a_face_on_a_pca9685_performs_and_gets_no_pulse_when_it_is_limp() {
    for is_stopped in [false, true] {
        let rig = face();
        let mechanism = rig.mechanism().unwrap();
        let parts = RigParts::new(&rig, &mechanism, Options::default()).unwrap();
        let jaw = parts.names.iter().position(|name| name == "jaw").unwrap();
        let eye = parts.names.iter().position(|name| name == "eye_turn_left").unwrap();
        assert!(parts.tells_nothing(jaw) && parts.servos.len() == 8);
        // In 3 s the jaw opens and closes, and the eye turns to the left and back.
        let rows = (0..=30).map(|row| {
            let share = (f64::from(row) / 30.0 * std::f64::consts::TAU).cos().mul_add(-0.5, 0.5);
            let mut q = mechanism.home();
            (q[jaw], q[eye]) = (-0.3 * share, 0.5 * share);
            q
        });
        let motion = RigMotion { dt_s: 0.1, rows: rows.collect() };
        let settings = Settings::default();
        let baker = Baker { mechanism: &mechanism, rig: parts.rig_crc(), settings };
        let show = baker.bake(&motion, &ShowMarks::default()).unwrap().written.bytes;
        let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
        let plant = parts.plant(&rig, &mechanism).unwrap();
        let mut sim = SimulatedRig::new(&parts, Some(&show), &mut memories, plant).unwrap();
        let (mut director, mut tally) = (Director::default(), Tally::new(&parts));
        let (mut least, mut most) = (0.0_f64, 0.0_f64);
        let ended = (0..20 * parts.rate_hz).find_map(|_| {
            if is_stopped && tally.ticks() == 100 {
                assert_eq!(sim.servos_on(), 8);
                sim.tick(Some(Command::EStop));
                return Some(None);
            }
            let ended = director.tick(&mut sim, false);
            tally.note(&sim);
            (least, most) = (least.min(sim.q()[jaw]), most.max(sim.q()[eye]));
            // Pulses exist only while torque is on.
            assert_eq!(sim.servos_on(), if sim.permission().torque { 8 } else { 0 });
            ended.map(Some)
        });
        assert_eq!(sim.servos_on(), 0);
        let errors = tally.errors(&parts, Some(Drive::Pulses)).unwrap();
        assert_eq!(errors.joints, 8);
        if is_stopped {
            assert_eq!((ended, sim.report().state), (Some(None), State::Faulted));
            continue;
        }
        assert_eq!(ended, Some(Some(Ended::Done)));
        // It reached its targets, except for dead band, play and friction; and it is never exactly on target.
        assert!((least + 0.3).abs() < 0.05 && (most - 0.5).abs() < 0.05, "{least} {most}");
        assert!(errors.most_rad > 1e-3 && errors.most_rad < 0.1, "{errors:?}");
        // Servos that are driven by pulses do not answer.
        assert!(sim.wires().answered == 0 && sim.wires().sent > 0);
        assert_eq!(director.raised(), FaultSet::EMPTY);
    }
}

#[test]
fn a_servo_is_refused_where_its_kind_cannot_be() {
    let refused = |change: fn(&mut Description)| {
        let mut rig = face();
        change(&mut rig);
        let mechanism = rig.mechanism().unwrap();
        RigParts::new(&rig, &mechanism, Options::default())
            .err()
            .expect("it is refused")
            .to_string()
    };
    let with_id = refused(|rig| rig.servos[1].address = Address::Id(3));
    assert!(with_id.contains("`jaw` is an MG90S") && with_id.contains("found id 3"), "{with_id}");
    let on_channel = refused(|rig| "XL330-M288-T".clone_into(&mut rig.servos[0].model));
    assert!(on_channel.contains("expected an `id`"), "{on_channel}");
    let mixed = refused(|rig| {
        "XL330-M288-T".clone_into(&mut rig.servos[0].model);
        rig.servos[0].address = Address::Id(1);
    });
    assert!(mixed.contains("two protocols (neck_turn, jaw)"), "{mixed}");
    // A servo driven by position beside a servo driven by pulses, on one joint.
    let facing = refused(|rig| {
        let mut other = rig.servos[0].clone();
        (other.name, other.bus) = ("other".to_owned(), "arm".to_owned());
        (other.model, other.address) = ("XL330-M288-T".to_owned(), Address::Id(1));
        rig.drives[0].servos.push(other.name.clone());
        rig.drives[0].kind = DriveKind::Matrix { rows: vec![vec![0.5, -0.5]], offset: vec![0.0] };
        rig.servos.push(other);
    });
    assert!(facing.contains("`neck_turn` and `other` share a drive"), "{facing}");
}

#[test]
fn a_class_that_a_kind_does_not_have_is_refused() {
    let refused = |model: &str, drive: Drive| {
        let mut rig = arm(2).unwrap();
        rig.servos.iter_mut().for_each(|servo| model.clone_into(&mut servo.model));
        let options = Options { drive: Some(drive), ..Options::default() };
        let parts = RigParts::new(&rig, &rig.mechanism().unwrap(), options);
        parts.map(|parts| parts.drives).map_err(|error| error.to_string())
    };
    assert_eq!(
        refused("STS3215-7.4V", Drive::Voltage).unwrap_err(),
        "--drive voltage: servo `turn1` is an STS3215-7.4V, which has no voltage mode; choose position"
    );
    assert_eq!(
        refused("XL430-W250-T", Drive::Current).unwrap_err(),
        "--drive current: servo `turn1` is an XL430-W250-T, which has no current mode; choose voltage or \
         position"
    );
    for model in ["XL330-M288-T", "XL430-W250-T", "MX-28"] {
        assert_eq!(refused(model, Drive::Voltage).unwrap(), [Some(Drive::Voltage); 2]);
    }
    let rig = face();
    for drive in [Drive::Current, Drive::Voltage, Drive::Position] {
        let options = Options { drive: Some(drive), ..Options::default() };
        let Err(error) = RigParts::new(&rig, &rig.mechanism().unwrap(), options) else {
            panic!("{drive:?} is taken by servos on pulses")
        };
        let expected = format!(
            "--drive {}: servo `neck_turn` is an MG90S, which is driven only by pulses; leave `--drive` out",
            drive.name()
        );
        assert_eq!(error.to_string(), expected);
    }
}

/// A quarter turn is 1 ms of pulse, and 1.5 ms is the middle. The pulses are those of the joint's range, not of the
/// servo's range.
#[test]
fn pulses_are_told_as_far_as_joints_go() {
    let mut rig = face();
    let jaw = rig.joints.iter_mut().find(|joint| joint.name == "jaw").unwrap();
    jaw.range_rad = vec![[-FRAC_PI_8, 0.0]];
    let parts = RigParts::new(&rig, &rig.mechanism().unwrap(), Options::default()).unwrap();
    let all = parts.pulses_us();
    assert_eq!(all.len(), 8);
    let jaw = all.iter().find(|of| of.servo == "jaw").unwrap();
    assert!((jaw.us[1] - jaw.us[0] - 250.0).abs() < 0.1 && !jaw.is_measured, "{jaw:?}");
    assert!(jaw.us.iter().any(|us| (us - 1500.0).abs() < 0.1), "{jaw:?}");
    // The file's pulses: 160 deg correspond to 1750 us.
    let servo = rig.servos.iter_mut().find(|servo| servo.name == "jaw").unwrap();
    servo.pulse_us = Some([600.0, 1480.0, 2350.0]);
    servo.travel_rad = Some(160_f64.to_radians());
    let parts = RigParts::new(&rig, &rig.mechanism().unwrap(), Options::default()).unwrap();
    let all = parts.pulses_us();
    let jaw = all.iter().find(|of| of.servo == "jaw").unwrap();
    assert!(jaw.is_measured && jaw.us.iter().any(|us| (us - 1480.0).abs() < 0.1), "{jaw:?}");
    assert!((jaw.us[1] - jaw.us[0] - 22.5 / 160.0 * 1750.0).abs() < 0.1, "{jaw:?}");
}

/// Without damping, only the loop acts on a swing through the gear. A stiff gear has a fast observer, which is
/// unstable with slow ticks.
#[test]
fn a_rig_whose_joint_would_shake_by_itself_is_refused() {
    let mut rig = arm(6).unwrap();
    let own = rig.servos[0].model.clone();
    let mut model = rig.servo_model(&own).unwrap();
    model.damping_nm_s.value = 0.0;
    if let Some(damping) = &mut model.gear_damping_nm_s {
        damping.value = 0.0;
    }
    if let Some(stiffness) = &mut model.gear_stiffness_nm_rad {
        stiffness.value = 300.0;
    }
    // The file's own data for a model override the built-in data.
    rig.servo_models.push(model);
    let mechanism = rig.mechanism().unwrap();
    let parts = |drive| {
        let options = Options { drive: Some(drive), rate_hz: Some(250), ..Options::default() };
        RigParts::new(&rig, &mechanism, options)
    };
    let refused = parts(Drive::Current).err().unwrap().to_string();
    assert!(refused.contains(&format!("servo `{}` would shake", rig.servos[0].name)), "{refused}");
    // With the drive `voltage` the winding damps the oscillation.
    assert!(refused.contains("a stiffer gear, less load, or `--drive voltage`"), "{refused}");
    assert!(parts(Drive::Voltage).is_ok());
    assert!(parts(Drive::Position).is_ok());
}

/// Plays an arm with six joints that stands still for 6 s. Returns its warnings, the mean of its errors, rad, and the
/// table. `kp`: gain of its tracker. `bandwidth_rad_s`: bandwidth of all observers; `None`: by the rule.
fn stands(kp: f32, bandwidth_rad_s: Option<f32>, swing_gain: f32) -> (FaultSet, String) {
    let rig = arm(6).unwrap();
    let mechanism = rig.mechanism().unwrap();
    let options = Options { drive: Some(Drive::Current), ..Options::default() };
    let mut parts = RigParts::new(&rig, &mechanism, options).unwrap();
    parts.settings.tracker.kp = kp;
    if let Some(rad_s) = bandwidth_rad_s {
        parts.setups.iter_mut().for_each(|setup| setup.bandwidth_rad_s = rad_s);
    }
    parts.settings.swing_gain = swing_gain;
    let motion = RigMotion { dt_s: 0.1, rows: vec![mechanism.home(); 61] };
    let (rig_crc, settings) = (parts.rig_crc(), Settings::default());
    let baker = Baker { mechanism: &mechanism, rig: rig_crc, settings };
    let show = baker.bake(&motion, &ShowMarks::default()).unwrap().written.bytes;
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(&rig, &mechanism).unwrap();
    let mut sim = SimulatedRig::new(&parts, Some(&show), &mut memories, plant).unwrap();
    let (mut director, mut tally) = (Director::default(), Tally::new(&parts));
    let ended = (0..60 * parts.rate_hz).find_map(|_| {
        let ended = director.tick(&mut sim, false);
        tally.note(&sim);
        ended
    });
    assert_eq!(ended, Some(Ended::Done), "a warning ends nothing");
    (director.raised(), tally.table(&sim, director.raised()))
}

/// An observer that is three times faster than the gears allow.
const FAST_RAD_S: f32 = 150.0;

/// With four times the gains, and fast observers, the arm swings, and the warning names the joints. The setting
/// `swing_gain` calms it.
#[test]
fn a_rig_that_swings_says_so_and_ends_well() {
    let (raised, table) = stands(800.0, Some(FAST_RAD_S), 1.0);
    assert_eq!(raised, FaultSet::WARNINGS);
    assert!(
        table.contains("faults: none, 1 warning\nwarning 64 (swing): bend2, bend3, bend5, bend6\n"),
        "{table}"
    );
    let of_joint = |table: &str, name: &str| {
        let line = table.lines().find(|line| line.split_whitespace().next() == Some(name)).unwrap();
        line.split_whitespace().skip(8).map(str::to_owned).collect::<Vec<_>>()
    };
    // Columns swing and limited. `turn1` turns about the vertical, so gravity does not load it.
    let [still, swings] = ["turn1", "bend3"].map(|name| of_joint(&table, name));
    assert!(still[0] == "0.00" && still[1..] == ["0", "%"], "{table}");
    let deg = |columns: &[String]| columns[0].parse::<f64>().unwrap();
    let swings_deg = deg(&swings);
    assert!(swings_deg > 1.0, "{table}");
    assert!(swings[1] != "0" && swings[2..] == ["%", "current"], "{table}");

    let (raised, table) = stands(800.0, Some(FAST_RAD_S), 0.3);
    assert_eq!(raised, FaultSet::WARNINGS);
    // The gains are 0.3 times as high: a motion that is left may be no larger than in proportion.
    let calmed_deg = deg(&of_joint(&table, "bend3"));
    assert!(calmed_deg < 0.3 * swings_deg, "{calmed_deg}, {swings_deg}: {table}");

    let (raised, table) = stands(50.0, None, 1.0);
    assert!(raised.is_empty() && !table.contains("warning"), "{table}");
}
