//! Tests the requirements of a rig file for its servos: compared, applied, calibrated.
#![expect(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![expect(clippy::cast_possible_truncation, reason = "a board computes in f32")]

use sinew_rig::Description;
use sinew_rig::description::ServoModel;
use sinew_servo_bus::settings::{self, ServoRequirements, Setting};
use sinew_servo_bus::table::{Access, Range};
use sinew_servo_sim::registers::RegisterTable;
use sinew_servo_tools::calibrate::{self, Calibration};
use sinew_servo_tools::compare::{apply, diff, span};
use sinew_servo_tools::desired::{Mode, desired};
use sinew_servo_tools::position_gain::GainReason;
use sinew_servo_tools::registers::{self, Number};
use sinew_servo_tools::rig_servo::{RigServo, of_bus, own_rad};
use sinew_servo_tools::{Client, Registers, ServiceError, Servo, Table, rig_file};

use crate::common;
use crate::common::{SimLine, client};

/// Returns a rig file with one joint and one servo.
fn text(kind: &str) -> String {
    format!(
        r#"name = "arm"
[[body]]
name = "base"
[[body]]
name = "link"
[[joint]]
name = "bend"
parent = "base"
child = "link"
axis = [0, 0, 1]
range_deg = [-60, 80]
home_deg = 20
[[drive]]
joints = ["bend"]
servos = ["elbow"]
[[servo]]
name = "elbow"
model = "{kind}"
id = 1
gear = 1.5   # belt
direction = -1
range_deg = [-100, 90.05] # by eye
torque_nm = 0.2
"#
    )
}

fn rig(kind: &str) -> Description {
    sinew_rig::toml_file::read(&text(kind)).unwrap()
}

fn opened(kind: &str) -> (Client<SimLine>, RigServo, Servo) {
    let mut client = client(&[(kind, 1)]);
    let rig_servo = of_bus(&rig(kind), None).unwrap().remove(0);
    let servo = rig_servo.open(&mut client).unwrap();
    (client, rig_servo, servo)
}

fn names(differences: &[sinew_servo_tools::compare::Difference]) -> Vec<&'static str> {
    differences.iter().map(|difference| difference.name).collect()
}

#[test]
fn what_a_new_servo_lacks_is_named_applied_and_gone() {
    for (kind, missing) in [
        (
            "XL330-M288-T",
            &[
                "Return Delay Time",
                "Current Limit",
                "Max Position Limit",
                "Min Position Limit",
                "Position P Gain",
            ][..],
        ),
        (
            "XL430-W250-T",
            &[
                "Return Delay Time",
                "PWM Limit",
                "Max Position Limit",
                "Min Position Limit",
                "Position P Gain",
            ],
        ),
        (
            "STS3215-7.4V",
            &[
                "Min Position Limit",
                "Max Position Limit",
                "Max Torque Limit",
                "P Coefficient",
                "Torque Limit",
            ],
        ),
    ] {
        let (mut client, rig, servo) = opened(kind);
        let settings = desired(&rig, &servo.table, Mode::Position).unwrap();
        let found = diff(&mut client, &servo, &settings).unwrap();
        assert_eq!(names(&found), missing, "{kind}");
        let limit = found.iter().find(|found| found.name == "Max Position Limit").unwrap();
        // 90.05 deg is 1024.6 counts above the middle, rounded inwards.
        assert_eq!((limit.has.raw, limit.should.raw), (4095, 2048 + 1024));

        let before = client.line_mut().writes();
        let applied = apply(&mut client, &servo, &settings, false).unwrap();
        assert_eq!(names(&applied.written), missing);
        assert!(!applied.let_go);
        assert_eq!(diff(&mut client, &servo, &settings).unwrap(), []);
        // The lock of a Feetech is opened before and shut after each of the four EEPROM registers.
        let locks = if kind.starts_with("STS") { 8 } else { 0 };
        assert_eq!(client.line_mut().writes() - before, missing.len() + locks, "only what differs");
        // The second time there is nothing to write.
        let before = client.line_mut().writes();
        assert_eq!(apply(&mut client, &servo, &settings, false).unwrap().written, []);
        assert_eq!(client.line_mut().writes(), before);
    }
}

#[test]
fn after_a_reboot_all_is_as_it_was_applied_but_what_was_changed_in_ram_before() {
    for (kind, in_ram) in [
        ("XL330-M288-T", "Status Return Level"),
        ("XL430-W250-T", "Position P Gain"),
        ("STS3215-7.4V", "Torque Limit"),
    ] {
        let (mut client, rig, servo) = opened(kind);
        let settings = desired(&rig, &servo.table, Mode::Position).unwrap();
        apply(&mut client, &servo, &settings, false).unwrap();
        registers::write(&mut client, &servo, in_ram, Number::Raw(1)).unwrap();
        let found = diff(&mut client, &servo, &settings).unwrap();
        assert_eq!(names(&found), [in_ram], "{kind}");
        assert!(!found[0].is_kept);
        client.reboot(&servo).unwrap();
        // A Dynamixel loses its P gain: a controller writes it again.
        let forgotten: &[&str] = if kind.starts_with("XL") { &["Position P Gain"] } else { &[] };
        assert_eq!(names(&diff(&mut client, &servo, &settings).unwrap()), forgotten, "{kind}");
    }
}

#[test]
fn a_servo_that_holds_something_is_not_let_go_unasked() {
    for kind in common::KINDS {
        let (mut client, rig, servo) = opened(kind);
        let settings = desired(&rig, &servo.table, Mode::Position).unwrap();
        registers::set_torque(&mut client, &servo, true).unwrap();
        let on = apply(&mut client, &servo, &settings, false).unwrap_err();
        assert!(matches!(on, ServiceError::Register(Registers::TorqueOn { .. })), "{on}");
        assert!(registers::torque_is_on(&mut client, &servo).unwrap());
        assert!(apply(&mut client, &servo, &settings, true).unwrap().let_go);
        assert!(!registers::torque_is_on(&mut client, &servo).unwrap());
        assert_eq!(diff(&mut client, &servo, &settings).unwrap(), []);
        // A difference in RAM alone can be corrected with torque on.
        registers::set_torque(&mut client, &servo, true).unwrap();
        let last = settings.last().unwrap();
        let other = if last.raw == 0 { 1 } else { last.raw - 1 };
        registers::write(&mut client, &servo, last.item.name, Number::Raw(other)).unwrap();
        assert!(!apply(&mut client, &servo, &settings, false).unwrap().let_go);
        assert!(registers::torque_is_on(&mut client, &servo).unwrap());
    }
}

#[test]
fn a_change_of_mode_and_gains_ends_without_a_difference() {
    let (mut client, rig, servo) = opened("XL330-M288-T");
    registers::write(&mut client, &servo, "Position P Gain", Number::Raw(999)).unwrap();
    let settings = desired(&rig, &servo.table, Mode::CurrentPosition).unwrap();
    assert!(names(&diff(&mut client, &servo, &settings).unwrap()).contains(&"Position P Gain"));
    apply(&mut client, &servo, &settings, false).unwrap();
    assert_eq!(diff(&mut client, &servo, &settings).unwrap(), []);
    assert_eq!(client.line_mut().bench.servos()[0].get(11), 5);
    // (0.2 N m + friction) / 0.387 N m/A = 0.55 A.
    assert_eq!(client.line_mut().bench.servos()[0].get(38), 550);
}

#[test]
fn a_bad_line_ends_in_the_same_settings() {
    for kind in common::KINDS {
        let (client, rig, servo) = opened(kind);
        let settings = desired(&rig, &servo.table, Mode::Position).unwrap();
        let mut line = client.into_line();
        (line.lost, line.damaged) = (15, 15);
        let patient =
            sinew_servo_tools::Settings { tries: 12, ..sinew_servo_tools::Settings::default() };
        let baud = line.bench.baud;
        let mut client = Client::new(line, servo.table.protocol(), baud, patient).unwrap();
        apply(&mut client, &servo, &settings, false).unwrap();
        for setting in &settings {
            let has = client.line_mut().bench.servos()[0].get(setting.item.address);
            assert_eq!(has, setting.raw, "{kind} {}", setting.item.name);
        }
    }
}

#[test]
fn what_a_rig_cannot_ask_of_its_servo_is_refused() {
    let (mut client, rig_servo, servo) = opened("XL430-W250-T");
    let current = desired(&rig_servo, &servo.table, Mode::Current).unwrap_err().to_string();
    assert!(current.contains("does not control current"), "{current}");
    let wide = RigServo { range_rad: Some([-1.0, 3.5]), ..rig_servo.clone() };
    let seam = desired(&wide, &servo.table, Mode::Position).unwrap_err().to_string();
    assert!(seam.contains("seam") && seam.contains("200.54"), "{seam}");
    let whole = RigServo {
        range_rad: Some([-std::f64::consts::PI, std::f64::consts::PI]),
        ..rig_servo.clone()
    };
    assert!(desired(&whole, &servo.table, Mode::Position).is_ok());

    let other = of_bus(&rig("XL330-M288-T"), None).unwrap().remove(0);
    let wrong = other.open(&mut client).unwrap_err().to_string();
    assert_eq!(
        wrong,
        "elbow (id 1) is an XL430-W250; the rig file says XL330-M288-T. Change the file, or the servo"
    );
    let channel = text("MG90S").replace("id = 1", "channel = 1");
    let none =
        of_bus(&sinew_rig::toml_file::read(&channel).unwrap(), None).unwrap_err().to_string();
    assert!(none.contains("none of its servos has an id"), "{none}");
}

#[test]
fn all_kinds_get_settings_that_their_registers_take() {
    let kinds = ServoModel::built_in_names().map(|kind| ServoModel::built_in(kind).unwrap());
    let (mut seen, mut wanted) = (0, 0);
    for model in kinds {
        let rig = RigServo {
            name: "any".to_owned(),
            id: 1,
            model,
            range_rad: Some([-1.0, 1.0]),
            homing_offset_rad: None,
            torque_nm: Some(1e3),
            joint_friction_nm: 0.0,
            position_gain: None,
        };
        let Some(table) = rig.table() else { continue };
        wanted += if table.has_current() { 4 } else { 2 };
        for mode in [Mode::Position, Mode::CurrentPosition, Mode::Current, Mode::Pwm] {
            let Ok(settings) = desired(&rig, &table, mode) else {
                assert!(
                    matches!(mode, Mode::Current | Mode::CurrentPosition) && !table.has_current()
                );
                continue;
            };
            seen += 1;
            let addresses: Vec<u16> = settings.iter().map(|setting| setting.item.address).collect();
            assert!(addresses.is_sorted_by(|a, b| a < b), "{}: {addresses:?}", table.model());
            for setting in &settings {
                assert_eq!(setting.item.access, Access::ReadWrite);
                if let Range::Between(least, most) = setting.item.range {
                    let name = setting.item.name;
                    assert!((least..=most).contains(&setting.raw), "{} {name}", table.model());
                }
            }
            // One read covers all registers.
            assert!(span(&settings).1 < 128);
        }
    }
    assert!(seen > 0);
    assert_eq!(seen, wanted, "modes of all kinds");
}

#[test]
fn a_simulated_servo_has_the_registers_that_tools_expect() {
    for kind in ServoModel::built_in_names() {
        let expected = Table::named_model(kind, u8::MAX);
        let simulated = RegisterTable::of(kind);
        assert_eq!(
            simulated.map(|table| table.name()),
            expected.map(|table| table.model()),
            "{kind}"
        );
    }
}

/// A board has the rig's numbers in f32, and its encoder's middle as an angle.
#[test]
fn a_board_comes_to_the_same_counts() {
    let single = |number: f64| number as f32;
    for kind in ServoModel::built_in_names() {
        let model = ServoModel::built_in(kind).unwrap();
        let stall_nm = model.stall_torque_nm.value;
        for tenths in (5..=1800).step_by(5) {
            let most = f64::from(tenths).to_radians() / 10.0;
            let rig = RigServo {
                name: "any".to_owned(),
                id: 1,
                model: model.clone(),
                range_rad: Some([-most, 0.9 * most]),
                homing_offset_rad: None,
                torque_nm: (tenths < 1800).then_some(stall_nm * f64::from(tenths) / 1800.0),
                joint_friction_nm: 0.0,
                position_gain: None,
            };
            let Some(table) = rig.table() else { continue };
            let requirements = ServoRequirements {
                mode: Mode::Position,
                range_rad: [-most, 0.9 * most].map(|own| single(own) + std::f32::consts::PI),
                torque_nm: single(rig.torque_nm.unwrap_or(stall_nm)),
                stall_nm: single(stall_nm),
                friction_nm: single(model.friction_nm.value),
                torque_constant_nm_a: single(model.torque_constant_nm_a.value),
                shutdown_c: single(model.shutdown_c.value),
                gain_ratio: 1.0,
            };
            let board: Vec<Setting> = match &table {
                Table::Dynamixel(table) => settings::dynamixel(*table, requirements).collect(),
                Table::Feetech(table) => {
                    settings::feetech(table.model.family, requirements).collect()
                }
            };
            assert_eq!(desired(&rig, &table, Mode::Position).unwrap(), board, "{kind} {tenths}");
        }
    }
}

/// Moves the shaft by hand; angles are in deg from the middle of the encoder.
fn hand(client: &mut Client<SimLine>, calibration: &mut Calibration, from_deg: f64, to_deg: f64) {
    for step in 0..=20 {
        let degrees = from_deg + (to_deg - from_deg) * f64::from(step) / 20.0;
        client.line_mut().bench.servos_mut()[0].place((180.0 + degrees).to_radians());
        client.line_mut().bench.run_us(5_000);
        calibration.look(client).unwrap();
    }
}

#[test]
fn a_range_found_by_hand_goes_into_the_rig_file() {
    for kind in common::KINDS {
        let (mut client, rig_servo, servo) = opened(kind);
        registers::set_torque(&mut client, &servo, true).unwrap();
        let mut calibration =
            Calibration::begin(&mut client, &[(rig_servo.clone(), servo.clone())]).unwrap();
        assert!(!registers::torque_is_on(&mut client, &servo).unwrap());
        hand(&mut client, &mut calibration, 0.0, -80.0);
        hand(&mut client, &mut calibration, -80.0, 100.0);
        let ranges = calibration.ranges(2.0).unwrap();
        // Home is 20 deg of the joint: times -1 times 1.5 that is -30 deg of the servo.
        hand(&mut client, &mut calibration, 100.0, -42.0);
        let rig = rig(kind);
        let offsets = calibrate::offsets(&rig, 0, &calibration.now_rad()).unwrap();

        let changed = rig_file::edited(&text(kind), &ranges).unwrap();
        let changed = rig_file::edited(&changed, &offsets).unwrap();
        assert!(changed.contains("# by eye") && changed.contains("gear = 1.5   # belt"));
        let servo = sinew_rig::toml_file::read(&changed).unwrap().servos.remove(0);
        let [least, most] = servo.range_rad[0].map(f64::to_degrees);
        // One count is 0.09 deg.
        assert!((least + 78.0).abs() < 0.1 && (most - 98.0).abs() < 0.1, "{kind} {least} {most}");
        let offset = servo.offset_rad.unwrap().to_degrees();
        assert!((offset + 12.0).abs() < 0.1, "{kind} {offset}");
    }
}

#[test]
fn a_range_over_the_seam_or_none_at_all_is_refused() {
    let (mut client, rig_servo, servo) = opened("STS3215-7.4V");
    let both = [(rig_servo, servo)];
    let mut calibration = Calibration::begin(&mut client, &both).unwrap();
    let still = calibration.ranges(2.0).unwrap_err().to_string();
    assert!(still.contains("0.0 deg only"), "{still}");
    hand(&mut client, &mut calibration, 0.0, 150.0);
    assert!(calibration.ranges(2.0).is_ok());
    hand(&mut client, &mut calibration, 150.0, 200.0);
    let seam = calibration.ranges(2.0).unwrap_err().to_string();
    assert!(seam.contains("seam"), "{seam}");
}

#[test]
fn joints_and_servos_name_drives() {
    let rig = rig("XL330-M288-T");
    for name in ["bend", "elbow"] {
        assert_eq!(calibrate::drives_of(&rig, &[name.to_owned()]).unwrap(), [0]);
    }
    assert_eq!(calibrate::drives_of(&rig, &[]).unwrap(), [0]);
    let unknown = calibrate::drives_of(&rig, &["knee".to_owned()]).unwrap_err().to_string();
    assert!(unknown.contains("\"knee\"; there are: bend"), "{unknown}");
    assert_eq!(calibrate::home_of(&rig, 0), ["bend at 20.0 deg"]);
}

#[test]
fn own_positions_count_from_the_middle_of_the_encoder() {
    let (_, _, servo) = opened("XL330-M288-T");
    assert!(own_rad(&servo.table, 2048).abs() < 1e-12);
    assert!((own_rad(&servo.table, 3072).to_degrees() - 90.0).abs() < 1e-5);
}

#[test]
fn a_p_gain_is_the_files_or_by_gear_and_load() {
    let mut rig = sinew_rig::new::arm(6).unwrap();
    let gain =
        |rig: &Description| of_bus(rig, None).map(|mut servos| servos.remove(1).position_gain);
    let by_rule = gain(&rig).unwrap().unwrap();
    assert_eq!((by_rule.reason, by_rule.factory), (GainReason::Damping, 400));
    assert!(by_rule.stiffness_nm_rad > 5.0 * 0.55, "{by_rule:?}");
    let servo = of_bus(&rig, None).unwrap().remove(1);
    let raw = |mode| {
        let settings = desired(&servo, &servo.table().unwrap(), mode).unwrap();
        settings.into_iter().find(|setting| setting.item.name == "Position P Gain").unwrap().raw
    };
    assert_eq!(raw(Mode::Position), by_rule.raw);
    assert_eq!(raw(Mode::Current), 400);

    rig.servos[1].p_gain = Some(640);
    let stated = gain(&rig).unwrap().unwrap();
    assert_eq!((stated.raw, stated.reason), (640, GainReason::File));
    assert!((stated.stiffness_nm_rad - 1.6 * 0.55).abs() < 1e-9);
    rig.servos[1].p_gain = Some(16_384);
    assert!(gain(&rig).unwrap_err().to_string().contains("takes 1 to 16383"));
    rig.servos[1].model = "MG90S".to_owned();
    assert!(gain(&rig).unwrap_err().to_string().contains("no known P gain"));
}

#[test]
fn bits_that_change_what_a_goal_means_are_applied_and_explained() {
    let reversed = Some("negate them");
    for (kind, register, has, should, explained) in [
        ("XL330-M288-T", "Drive Mode", 1, 0, reversed),
        ("XL330-M288-T", "Drive Mode", 8, 0, Some("switches its torque on")),
        ("XL330-M288-T", "Drive Mode", 4, 0, None),
        ("STS3215-7.4V", "Phase", 12 + 129, 12, reversed),
        ("STS3215-7.4V", "Phase", 76 + 129, 76, reversed),
        ("STS3215-7.4V", "Phase", 8, 12, None),
        ("STS3215-7.4V", "Phase", 28, 12, None),
    ] {
        let (mut client, rig, servo) = opened(kind);
        let settings = desired(&rig, &servo.table, Mode::Position).unwrap();
        apply(&mut client, &servo, &settings, false).unwrap();
        registers::write(&mut client, &servo, register, Number::Raw(has)).unwrap();
        let found = diff(&mut client, &servo, &settings).unwrap();
        let [difference] = found.as_slice() else { panic!("{kind} {has}: {found:?}") };
        assert_eq!((difference.name, difference.should.raw), (register, should), "{kind} {has}");
        let told = difference.consequence();
        let is_told = told.zip(explained).map(|(told, words)| told.contains(words));
        assert_eq!((told.is_some(), is_told), (explained.is_some(), explained.map(|_| true)));
        apply(&mut client, &servo, &settings, false).unwrap();
        assert_eq!(diff(&mut client, &servo, &settings).unwrap(), []);
    }
    // Bits of the servo's own electronics are its own.
    let (mut client, rig, servo) = opened("STS3215-7.4V");
    let settings = desired(&rig, &servo.table, Mode::Position).unwrap();
    apply(&mut client, &servo, &settings, false).unwrap();
    registers::write(&mut client, &servo, "Phase", Number::Raw(12 + 64 + 32)).unwrap();
    assert_eq!(diff(&mut client, &servo, &settings).unwrap(), []);
}
