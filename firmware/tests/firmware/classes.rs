//! Tests of the drive classes: their commands, and the settings that they refuse.

use sinew_core::coordinates::DofCommand;
use sinew_core::tracker::Timing;
use sinew_firmware::drives::{
    Class, ClassError, Condition, CurrentDrive, CurrentSettings, CutOff, DriveSettings, Drives,
    Encoder, Limit, PositionDrive, PositionSettings, Refused, SetupError, ShaftTarget, TargetDrive,
    TargetSettings, VoltageDrive, VoltageSettings,
};
use sinew_rig::board::BoardRig;
use sinew_rig::servo::{Servo, ServoSettings, SignalLoss};
use sinew_rig::toml_file;
use sinew_servo_bus::dynamixel::{self, table::MODELS};
use sinew_servo_bus::{Command, Effort, Feedback, feetech};

const TIMING: Timing = Timing { dt_s: 0.005, latency_ticks: 1 };
const CURRENT: CurrentSettings = CurrentSettings {
    encoder: Encoder { zero_rad: std::f32::consts::PI, turn_rad: std::f32::consts::TAU },
    blind_rad: 10.0,
    current_a: 1.0,
    cut_off: CutOff { stale_s: 0.1, warm_c: 55.0, hot_c: 65.0 },
};

const VOLTAGE: VoltageSettings =
    VoltageSettings { current: CURRENT, resistance_ohm: 4.0, back_emf_v_s: 0.5, supply_v: 10.0 };

fn servo(change: impl Fn(&mut ServoSettings)) -> Servo {
    let mut settings = ServoSettings {
        gear: -2.0,
        offset_rad: 0.5,
        range_rad: [-2.0, 2.0],
        torque_nm: 0.5,
        speed_rad_s: 10.0,
        acceleration_rad_s2: f32::INFINITY,
        torque_constant_nm_a: 0.4,
        position_gain_nm_rad: 0.5,
        friction_nm: 0.02,
        damping_nm_s: 0.01,
        rotor_inertia_kg_m2: 0.002,
        on_signal_loss: SignalLoss::Limp,
    };
    change(&mut settings);
    Servo::new(settings).unwrap()
}

fn at(own_rad: f32, temperature_c: f32) -> Condition {
    let feedback = Feedback {
        position_rad: own_rad + std::f32::consts::PI,
        velocity_rad_s: 0.0,
        effort: Effort::Current(0.0),
        age_ticks: 1,
    };
    Condition {
        feedback: Some(feedback),
        temperature_c: Some(temperature_c),
        ..Condition::default()
    }
}

fn current(command: Command) -> f32 {
    let Command::Current(a) = command else { panic!("{command:?}") };
    a
}

#[test]
fn a_current_drive_gives_the_whole_effort_and_the_friction() {
    let mut drive = CurrentDrive::new(&servo(|_| {}), &CURRENT, TIMING).unwrap();
    let target = ShaftTarget {
        velocity_rad_s: 1.0,
        feedforward_nm: 0.1,
        feedback_nm: -0.3,
        ..ShaftTarget::default()
    };
    let mut steps = (0..100).map(|_| drive.command(&target, &at(0.0, 30.0)));
    let first = current(steps.next().unwrap().command);
    let settled = steps.last().unwrap();
    // -0.2 N m at the shaft are 0.1 N m at the servo, which turns backwards at 2 rad/s: friction takes 0.02 + 0.02 N
    // m.
    assert!((current(settled.command) - (0.1 - 0.04) / 0.4).abs() < 1e-4, "{settled:?}");
    assert_eq!(settled.limit, None);
    // The current rises within 0.2 s.
    assert!((first / current(settled.command) - 0.025).abs() < 1e-3);

    let strong = ShaftTarget { feedforward_nm: -5.0, ..ShaftTarget::default() };
    let held = drive.command(&strong, &at(0.0, 30.0));
    assert_eq!((current(held.command), held.limit), (1.0, Some(Limit::Current)));
    let warm = drive.command(&strong, &at(0.0, 57.5));
    assert!(current(warm.command) > 0.9 && warm.limit == Some(Limit::Heat));
    let outside = drive.command(&strong, &at(2.1, 30.0));
    assert!(current(outside.command).abs() <= 0.0 && outside.limit == Some(Limit::Range));
    assert!(current(drive.command(&strong, &at(-2.1, 30.0)).command) > 0.9, "inwards it may");
}

fn part(command: Command) -> f32 {
    let Command::Pwm(part) = command else { panic!("{command:?}") };
    part
}

#[test]
fn a_voltage_drive_gives_what_drives_the_current_and_holds_against_the_back_emf() {
    let mut drive = VoltageDrive::new(&servo(|_| {}), &VOLTAGE, TIMING).unwrap();
    let target = ShaftTarget {
        velocity_rad_s: 1.0,
        feedforward_nm: 0.1,
        feedback_nm: -0.3,
        ..ShaftTarget::default()
    };
    let turning = |velocity_rad_s: f32, supply_v: Option<f32>| {
        let mut condition = at(0.0, 30.0);
        condition.feedback.as_mut().unwrap().velocity_rad_s = velocity_rad_s;
        Condition { supply_v, ..condition }
    };
    let settled = (0..100).map(|_| drive.command(&target, &turning(-2.0, None))).last().unwrap();
    // 0.15 A, the current drive's result, through 4 ohm; plus 0.5 V s/rad at -2 rad/s; divided by 10 V.
    assert!((part(settled.command) - (0.6 - 1.0) / 10.0).abs() < 2e-5, "{settled:?}");
    assert_eq!(settled.limit, None);
    // The motor itself corrects a lower speed. A reported supply voltage is used; an impossible one is not.
    for (supply_v, of_v) in [(Some(8.0), 8.0), (Some(0.1), 5.0), (None, 10.0)] {
        let slow = drive.command(&target, &turning(-1.8, supply_v));
        assert!((part(slow.command) + 0.4 / of_v).abs() < 2e-5, "{slow:?}");
    }

    let strong = ShaftTarget { feedforward_nm: -5.0, ..ShaftTarget::default() };
    // 1 A through 4 ohm, and the same maximum current when the servo turns the other way.
    let held = drive.command(&strong, &at(0.0, 30.0));
    assert!((part(held.command) - 0.4).abs() < 1e-5 && held.limit == Some(Limit::Current));
    let braking = drive.command(&strong, &turning(-2.0, None));
    assert!((part(braking.command) - 0.3).abs() < 1e-5, "{braking:?}");
    assert_eq!(braking.limit, Some(Limit::Current));
    // 4 V for its torque, and 5 V for its speed; at a supply of 5 V even full duty is not enough.
    let fast = ShaftTarget { velocity_rad_s: -100.0, ..strong };
    let most = drive.command(&fast, &turning(20.0, None));
    assert!((part(most.command) - 0.9).abs() < 1e-5, "{most:?}");
    assert_eq!(most.limit, Some(Limit::Voltage));

    let outside = drive.command(&strong, &at(2.1, 30.0));
    assert!(part(outside.command).abs() <= 0.0 && outside.limit == Some(Limit::Range));
    assert!(part(drive.command(&strong, &at(-2.1, 30.0)).command) > 0.3, "inwards it may");
    let warm = drive.command(&strong, &at(0.0, 57.5));
    assert!(part(warm.command) > 0.3 && warm.limit == Some(Limit::Heat));
}

/// At -3 rad/s the back-EMF is 1.5 V: with half of the voltage the motor would brake with 0.19 A, without voltage
/// with 0.38 A.
#[test]
fn a_hot_servo_by_voltage_coasts_as_one_by_current_does() {
    let turning = |velocity_rad_s: f32, temperature_c: f32, age_ticks: u32| {
        let mut condition = at(0.0, temperature_c);
        let read = condition.feedback.as_mut().unwrap();
        (read.velocity_rad_s, read.age_ticks) = (velocity_rad_s, age_ticks);
        condition
    };
    // Current in the winding, for 10 V, 0.5 V s/rad and 4 ohm.
    let taken_a =
        |command, velocity_rad_s: f32| (10.0 * part(command) - 0.5 * velocity_rad_s) / 4.0;
    for (temperature_c, share) in [(55.0, 1.0), (60.0, 0.5), (65.0, 0.0), (80.0, 0.0)] {
        for effort_nm in [0.0, 0.1, -0.1, 5.0, -5.0] {
            let target = ShaftTarget { feedforward_nm: effort_nm, ..ShaftTarget::default() };
            let moving = ShaftTarget { velocity_rad_s: 1.5, ..target };
            let mut drive = VoltageDrive::new(&servo(|_| {}), &VOLTAGE, TIMING).unwrap();
            let mut by_current = CurrentDrive::new(&servo(|_| {}), &CURRENT, TIMING).unwrap();
            let read = turning(-3.0, temperature_c, 0);
            for _ in 0..100 {
                // The target is as fast as the servo.
                let own = drive.command(&moving, &read);
                let a = taken_a(own.command, -3.0);
                let other_a = current(by_current.command(&moving, &read).command);
                assert!((a - other_a).abs() < 1e-4, "{temperature_c} degC: {a} A, {other_a} A");
            }
            // The target stands still while the servo turns: the motor may brake, with its permitted share.
            let a = taken_a(drive.command(&target, &read).command, -3.0);
            assert!(a.abs() <= share + 1e-5, "{temperature_c} degC: {a} A");
        }
    }
    // Without a fresh reading the speed is not known: after 0.2 s the winding is shorted.
    let mut drive = VoltageDrive::new(&servo(|_| {}), &VOLTAGE, TIMING).unwrap();
    let target = ShaftTarget { velocity_rad_s: 1.5, ..ShaftTarget::default() };
    let parts: Vec<f32> = [0, 21]
        .map(|age_ticks| [turning(-3.0, 30.0, age_ticks); 50])
        .iter()
        .flatten()
        .map(|read| part(drive.command(&target, read).command))
        .collect();
    assert!(parts[49] < -0.15 && (parts[69] / parts[49] - 0.5).abs() < 1e-3, "{parts:?}");
    assert!(parts[99].abs() < 1e-6, "{parts:?}");
}

#[test]
fn a_position_drive_gives_target_and_offset_and_no_feedback() {
    for gain_ratio in [1.0, 2.0] {
        let settings = PositionSettings { gain_ratio, ..PositionSettings::default() };
        let mut drive = PositionDrive::new(&servo(|_| {}), &settings, TIMING).unwrap();
        let target = ShaftTarget {
            position_rad: 0.5,
            feedforward_nm: 0.1,
            feedback_nm: 100.0,
            ..ShaftTarget::default()
        };
        let settled = (0..200).map(|_| drive.command(&target, &at(0.0, 30.0))).last().unwrap();
        let Command::PositionAt { position_rad, speed_rad_s } = settled.command else { panic!() };
        // -2 times 0.5 rad plus 0.5 rad; -0.05 N m divided by 0.5 N m/rad, or by twice that.
        let own_rad = position_rad - std::f32::consts::PI;
        assert!((own_rad - (-0.5 - 0.1 / gain_ratio)).abs() < 1e-5, "{own_rad}");
        assert!(speed_rad_s.abs() <= 0.0 && settled.limit.is_none());

        let heavy = ShaftTarget { feedforward_nm: 0.5, ..target };
        let next = drive.command(&heavy, &at(0.0, 30.0));
        let Command::PositionAt { speed_rad_s, .. } = next.command else { panic!() };
        // 5 rad/s, and a tenth more.
        assert!((speed_rad_s - 5.5).abs() < 1e-3, "{speed_rad_s}");
        assert_eq!(
            next.limit,
            Some(if gain_ratio > 1.5 { Limit::OffsetRate } else { Limit::Offset })
        );
    }
}

#[test]
fn what_a_class_cannot_do_is_refused_with_what_would_be_right() {
    let slow = Timing { dt_s: 0.02, latency_ticks: 1 };
    let message = |refused: Refused| refused.to_string();
    let current = |servo: &Servo, timing| CurrentDrive::new(servo, &CURRENT, timing).unwrap_err();
    assert_eq!(
        message(current(&servo(|_| {}), slow)),
        "a current drive needs at least 200 Hz, and readings that are no later than it allows"
    );
    // Each servo is read only in every third tick: too late at 200 Hz.
    let late = Timing { dt_s: 0.005, latency_ticks: 3 };
    assert!(matches!(current(&servo(|_| {}), late), Refused::TooSlow { .. }));
    assert_eq!(
        current(&servo(|s| s.torque_constant_nm_a = 1e-3), TIMING),
        Refused::NoTorqueConstant
    );
    let seam = servo(|s| s.range_rad = [-2.0, 3.5]);
    assert!(message(current(&seam, TIMING)).contains("goes over the seam of its encoder"));
    assert!(
        current(&servo(|_| {}), Timing { dt_s: f32::NAN, ..TIMING })
            .to_string()
            .contains("dt_s is NaN")
    );

    let voltage = |settings: VoltageSettings, timing| {
        VoltageDrive::new(&servo(|_| {}), &settings, timing).map(|_| ()).map_err(message)
    };
    assert_eq!(
        voltage(VOLTAGE, slow).unwrap_err(),
        "a voltage drive needs at least 200 Hz, and readings that are no later than it allows"
    );
    assert_eq!(
        voltage(VoltageSettings { resistance_ohm: 0.0, ..VOLTAGE }, TIMING).unwrap_err(),
        "resistance_ohm is 0; it must be a number from 0.001 to 1000"
    );
    let no_number = VoltageSettings { back_emf_v_s: f32::NAN, ..VOLTAGE };
    assert!(voltage(no_number, TIMING).unwrap_err().contains("back_emf_v_s is NaN"));
    let no_supply = VoltageSettings { supply_v: 0.0, ..VOLTAGE };
    assert!(voltage(no_supply, TIMING).unwrap_err().contains("supply_v is 0"));
    let unknown = servo(|s| s.torque_constant_nm_a = 1e-3);
    assert_eq!(
        VoltageDrive::new(&unknown, &VOLTAGE, TIMING).unwrap_err(),
        Refused::NoTorqueConstant
    );

    let position =
        |servo: &Servo, timing| PositionDrive::new(servo, &PositionSettings::default(), timing);
    assert_eq!(
        position(&servo(|s| s.position_gain_nm_rad = 0.0), slow).unwrap_err(),
        Refused::NoStiffness
    );
    assert!(position(&servo(|_| {}), slow).is_ok());
    let slower = Timing { dt_s: 0.021, ..slow };
    assert!(matches!(position(&servo(|_| {}), slower).unwrap_err(), Refused::TooSlow { .. }));
    assert!(matches!(position(&seam, slow).unwrap_err(), Refused::Seam { .. }));
    let bad = PositionSettings { gain_ratio: f32::NAN, ..PositionSettings::default() };
    assert!(PositionDrive::new(&servo(|_| {}), &bad, slow).is_err());

    assert!(
        TargetDrive::new(&seam, &TargetSettings::default(), slow).is_ok(),
        "pulses have no seam"
    );
    assert!(
        TargetDrive::new(&seam, &TargetSettings { encoder: Some(Encoder::default()) }, slow)
            .is_err()
    );
    assert!(TargetDrive::new(&seam, &TargetSettings::default(), slower).is_err());
}

#[test]
fn a_mode_has_its_class() {
    let model = |name: &str| MODELS.iter().find(|model| model.name == name).unwrap();
    let of = |name, mode| Class::of_dynamixel(model(name), mode);
    assert_eq!(of("XL330-M288", dynamixel::Mode::Current), Ok(Class::Current));
    assert_eq!(of("XL430-W250", dynamixel::Mode::Current), Err(ClassError::NoCurrentSensor));
    assert_eq!(of("XL430-W250", dynamixel::Mode::Position), Ok(Class::Position));
    assert_eq!(
        of("XL330-M288", dynamixel::Mode::CurrentPosition),
        Err(ClassError::CurrentPosition)
    );
    assert_eq!(of("XL330-M288", dynamixel::Mode::Pwm), Ok(Class::Voltage));
    assert_eq!(of("XL430-W250", dynamixel::Mode::Pwm), Ok(Class::Voltage));
    assert_eq!(Class::of_feetech(feetech::Mode::Position), Ok(Class::Position));
    assert_eq!(Class::of_feetech(feetech::Mode::Pwm), Err(ClassError::FeetechPwm));
}

type Rig = BoardRig<2, 1, 2>;

fn rig(text: &str) -> Rig {
    let described = toml_file::read(text).unwrap_or_else(|error| panic!("{error}"));
    Rig::bake(&described, &described.mechanism().unwrap()).unwrap()
}

const PAIR: &str = r#"
name = "pair"
[[body]]
name = "base"
mass_kg = 1
[[body]]
name = "arm"
mass_kg = 0.1
[[joint]]
name = "j"
parent = "base"
child = "arm"
axis = [1, 0, 0]
[[drive]]
joints = ["j"]
servos = ["a", "b"]
matrix = { rows = [[0.5, -0.5]] }
[[servo]]
name = "a"
model = "XL330-M288-T"
id = 1
[[servo]]
name = "b"
model = "XL330-M288-T"
"#;

#[test]
fn a_rig_is_refused_by_servo_and_by_drive() {
    let position = DriveSettings::Position(PositionSettings::default());
    let target = DriveSettings::Target(TargetSettings::default());
    let two = rig(&format!("{PAIR}id = 2"));
    let refused = |rig: &Rig, settings: &[DriveSettings]| {
        Drives::new(rig, settings, TIMING).map(|_| ()).unwrap_err()
    };
    assert_eq!(refused(&two, &[position]), SetupError::Count { expected: 2, found: 1 });
    assert_eq!(refused(&two, &[position, target]), SetupError::Mixed { drive: 0 });
    let voltage = DriveSettings::Voltage(VOLTAGE);
    let mixed = [DriveSettings::Current(CURRENT), voltage];
    assert_eq!(refused(&two, &mixed), SetupError::Mixed { drive: 0 });
    let pulses = rig(&format!("{PAIR}bus = \"pwm\"\nchannel = 2"));
    assert_eq!(
        refused(&pulses, &[position, position]).to_string(),
        "servo 1: a position drive needs a servo on a bus; this one takes pulses"
    );
    assert_eq!(
        refused(&pulses, &[voltage, voltage]).to_string(),
        "servo 1: a voltage drive needs a servo on a bus; this one takes pulses"
    );
}

#[test]
fn angles_are_unwrapped_next_to_the_middle_of_the_range_or_to_the_last() {
    let settings = [DriveSettings::Target(TargetSettings { encoder: Some(Encoder::default()) }); 2];
    let single = |range: &str| {
        let text = PAIR.replace("axis = [1, 0, 0]", &format!("axis = [1, 0, 0]\n{range}"));
        rig(&format!("{text}id = 2"))
    };
    let reached = |rig: &Rig, angles: &[f32]| {
        let mut drives = Drives::new(rig, &settings, TIMING).unwrap();
        let mut out = [None; 2];
        for angle in angles {
            for _ in 0..200 {
                let asked = DofCommand { position: *angle, ..DofCommand::default() };
                drives.step(&[asked], &[Condition::default(); 2], &mut out).unwrap();
            }
        }
        let Command::Position(rad) = out[0].unwrap().command else { panic!() };
        rad - std::f32::consts::PI
    };
    // The range is 0 to almost 180 deg, so -179 deg is unwrapped to 181 deg.
    let narrow = single("range_deg = [0, 179.9]\nhome_deg = 10");
    assert!((reached(&narrow, &[-3.13]) - std::f32::consts::PI).abs() < 2e-3);
    // Without a range the joint continues, and stops at the end of the servo's range instead of turning back.
    let free = single("");
    assert!((reached(&free, &[2.0, 3.0, -3.0]) - std::f32::consts::PI).abs() < 2e-3);
    assert!((reached(&free, &[-3.0]) + 3.0).abs() < 1e-5);
}
