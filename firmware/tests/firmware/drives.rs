//! Properties of drives of random rigs: no command exceeds a limit, NaN is refused, cut-offs work, and joints and
//! servos do the same work.

use proptest::prelude::*;
use sinew_core::coordinates::DofCommand;
use sinew_core::tracker::Timing;
use sinew_firmware::drives::{
    Condition, CurrentSettings, CutOff, DriveSettings, Drives, Encoder, Limit, Measured,
    PositionSettings, ServoCommand, ServoDrive, TargetSettings, VoltageSettings,
};
use sinew_servo_bus::{Command, Effort};

use crate::common::{Kind, Rig, kinds, read, rig};

const TIMING: Timing = Timing { dt_s: 0.005, latency_ticks: 1 };
const CURRENT_A: f32 = 0.7;
const OFFSET_RAD: f32 = 0.2;
const VOLTS: (f32, f32, f32) = (3.4, 0.4, 5.0);

const CURRENT: CurrentSettings = CurrentSettings {
    encoder: Encoder { zero_rad: std::f32::consts::PI, turn_rad: std::f32::consts::TAU },
    blind_rad: 10.0,
    current_a: CURRENT_A,
    cut_off: CutOff { stale_s: 0.1, warm_c: 55.0, hot_c: 65.0 },
};
/// Numbers of the classes that use an effort.
const OF_EFFORT: [u8; 3] = [0, 1, 3];

fn settings(class: u8) -> DriveSettings {
    match class {
        0 => DriveSettings::Current(CURRENT),
        1 => DriveSettings::Position(PositionSettings {
            offset_rad: OFFSET_RAD,
            ..PositionSettings::default()
        }),
        2 => DriveSettings::Target(TargetSettings { encoder: Some(Encoder::default()) }),
        _ => {
            let (resistance_ohm, back_emf_v_s, supply_v) = VOLTS;
            let current = CURRENT;
            DriveSettings::Voltage(VoltageSettings {
                current,
                resistance_ohm,
                back_emf_v_s,
                supply_v,
            })
        }
    }
}

fn drives(rig: &Rig, class: u8) -> Drives<'_, 16, 24, 24> {
    Drives::new(rig, &vec![settings(class); rig.servos().len()], TIMING).unwrap()
}

/// Generates finite numbers that are accepted, often of a realistic size.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![-1e6_f32..1e6, -4.0_f32..4.0, Just(0.0), Just(1e6), Just(-1e6)]
}

fn asked(numbers: &[f32], dofs: usize) -> Vec<DofCommand> {
    let of = |index: usize| numbers[index % numbers.len()];
    let command = |index: usize| DofCommand {
        position: of(4 * index),
        velocity: of(4 * index + 1),
        feedforward_effort: of(4 * index + 2),
        feedback_effort: of(4 * index + 3),
        limited: None,
    };
    (0..dofs).map(command).collect()
}

fn is_within(rig: &Rig, servo: usize, command: Command) -> Result<(), TestCaseError> {
    let own = rig.servos()[servo].servo.settings();
    let in_range = |rad: f32| {
        let own_rad = rad - Encoder::default().zero_rad;
        // The tolerance is a rounding of f32 at half a turn.
        (own.range_rad[0] - 1e-6..=own.range_rad[1] + 1e-6).contains(&own_rad)
    };
    match command {
        Command::Current(a) => {
            let most = CURRENT_A.min(own.torque_nm / own.torque_constant_nm_a);
            prop_assert!(a.abs() <= most * (1.0 + 1e-6), "{a} A");
        }
        Command::Pwm(part) => {
            let (ohm, v_s, supply_v) = VOLTS;
            let most_a = CURRENT_A.min(own.torque_nm / own.torque_constant_nm_a);
            let most = ((ohm * most_a + v_s * own.speed_rad_s) / supply_v).min(1.0);
            prop_assert!(part.abs() <= most * (1.0 + 1e-6), "{part} of the supply");
        }
        Command::Position(rad) => prop_assert!(in_range(rad), "{rad} rad"),
        Command::PositionAt { position_rad, speed_rad_s } => {
            prop_assert!(in_range(position_rad), "{position_rad} rad");
            // The goal's own speed plus the offset's, and a tenth.
            let most = 1.1 * (own.speed_rad_s + PositionSettings::default().offset_rad_s) + 1e-2;
            prop_assert!((0.0..=most).contains(&speed_rad_s), "{speed_rad_s} rad/s");
        }
        other => prop_assert!(false, "{other:?}"),
    }
    Ok(())
}

/// Returns random poses of all shafts, within any range, as readings and as the joints' measured state.
fn posed(rig: &Rig, class: u8, numbers: &[f32]) -> (Vec<Condition>, Vec<Option<Measured>>) {
    let conditions: Vec<_> = (0..rig.servos().len())
        .map(|servo| {
            let shaft_rad = 0.4 * numbers[servo % numbers.len()];
            let own = rig.servos()[servo].servo.own_position(shaft_rad).unwrap().value;
            read(own, 0.0, 0.0)
        })
        .collect();
    let mut measured = vec![None; rig.dofs().len()];
    drives(rig, class).measured(&conditions, &mut measured).unwrap();
    (conditions, measured)
}

/// Returns the conditions of servos that move at these speeds.
fn moving(conditions: &[Condition], speeds: &[f32]) -> Vec<Condition> {
    let mut moving = conditions.to_vec();
    for (index, condition) in moving.iter_mut().enumerate() {
        condition.feedback.as_mut().unwrap().velocity_rad_s = speeds[index % speeds.len()];
    }
    moving
}

proptest! {
    #[test]
    fn no_finite_input_drives_a_servo_beyond_its_limits(
        kinds in kinds(),
        ticks in prop::collection::vec((prop::collection::vec(number(), 12), prop::collection::vec(number(), 9)), 1..8),
        class in 0_u8..4,
        start in prop::collection::vec(-2.0_f32..2.0, 6),
    ) {
        let rig = rig(&kinds);
        let mut drives = drives(&rig, class);
        drives.begin(&posed(&rig, class, &start).0);
        let mut out = vec![None; rig.servos().len()];
        for (commands, readings) in ticks {
            let conditions: Vec<_> = (0..rig.servos().len())
                .map(|servo| {
                    let of = |index: usize| readings[(3 * servo + index) % readings.len()];
                    let mut condition = read(of(0), of(1), 0.1 * of(2));
                    condition.temperature_c = Some(of(2) * 1e-4 + 40.0);
                    condition.supply_v = Some(of(1));
                    condition
                })
                .collect();
            let asked = asked(&commands, rig.dofs().len());
            // Values that follow from the input may be too large for a drive: then nothing is commanded.
            let Ok(()) = drives.step(&asked, &conditions, &mut out) else { continue };
            for (servo, command) in out.iter().enumerate() {
                is_within(&rig, servo, command.unwrap().command)?;
                if let ServoDrive::Position(drive) = &drives.servos()[servo] {
                    prop_assert!(drive.offset_rad().abs() <= OFFSET_RAD);
                }
            }
        }
    }

    #[test]
    fn what_is_no_number_is_refused_and_changes_nothing(
        kinds in kinds(),
        numbers in prop::collection::vec(-1.0_f32..1.0, 12),
        bad in prop::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.1e6]),
        place in 0_usize..9,
        index in 0_usize..24,
        class in 0_u8..4,
    ) {
        let rig = rig(&kinds);
        let mut drives = drives(&rig, class);
        let (conditions, _) = posed(&rig, class, &numbers);
        let asked = asked(&numbers, rig.dofs().len());
        let mut first = vec![None; rig.servos().len()];
        drives.step(&asked, &conditions, &mut first).unwrap();
        let (mut worse, mut broken) = (asked.clone(), conditions.clone());
        let (dof, servo) = (index % asked.len(), index % conditions.len());
        let read = broken[servo].feedback.as_mut().unwrap();
        match place {
            0 => worse[dof].position = bad,
            1 => worse[dof].velocity = bad,
            2 => worse[dof].feedforward_effort = bad,
            3 => worse[dof].feedback_effort = bad,
            4 => read.position_rad = bad,
            5 => read.velocity_rad_s = bad,
            6 => read.effort = Effort::Current(bad),
            7 => broken[servo].supply_v = Some(bad),
            _ => broken[servo].temperature_c = Some(bad),
        }
        let mut other = drives.clone();
        let mut out = first.clone();
        prop_assert!(other.step(&worse, &broken, &mut out).is_err());
        prop_assert_eq!(&out, &first);
        let (mut after, mut without) = (first.clone(), first);
        other.step(&asked, &conditions, &mut after).unwrap();
        drives.step(&asked, &conditions, &mut without).unwrap();
        prop_assert_eq!(after, without);
    }

    #[test]
    fn positions_come_back_as_they_were_asked(kinds in kinds(), numbers in prop::collection::vec(-1.0_f32..1.0, 6)) {
        let rig = rig(&kinds);
        let (conditions, measured) = posed(&rig, 2, &numbers);
        let mut drives = drives(&rig, 2);
        let asked: Vec<_> = measured
            .iter()
            .map(|measured| DofCommand { position: measured.unwrap().position, ..DofCommand::default() })
            .collect();
        let mut out = vec![None; rig.servos().len()];
        // At 10.8 rad/s half a turn takes 60 ticks.
        for _ in 0..100 {
            drives.step(&asked, &conditions, &mut out).unwrap();
        }
        let reached: Vec<_> = out
            .iter()
            .map(|out: &Option<ServoCommand>| {
                let Command::Position(rad) = out.unwrap().command else { panic!("{out:?}") };
                read(rad - Encoder::default().zero_rad, 0.0, 0.0)
            })
            .collect();
        let mut back = vec![None; rig.dofs().len()];
        drives.measured(&reached, &mut back).unwrap();
        for (back, measured) in back.iter().zip(&measured) {
            let (back, measured) = (back.unwrap().position, measured.unwrap().position);
            // The tolerance covers some roundings through a matrix of condition up to 100, or a four-bar.
            prop_assert!((back - measured).abs() < 2e-4, "{back} for {measured}");
        }
    }

    #[test]
    fn efforts_do_the_same_work_on_both_sides(
        kinds in kinds(),
        numbers in prop::collection::vec(-1.0_f32..1.0, 6),
        efforts in prop::collection::vec(-0.02_f32..0.02, 12),
        speeds in prop::collection::vec(-2.0_f32..2.0, 5),
    ) {
        let rig = rig(&kinds);
        let mut drives = drives(&rig, 0);
        let (conditions, measured) = posed(&rig, 0, &numbers);
        let asked: Vec<_> = (0..rig.dofs().len())
            .map(|index| DofCommand {
                position: measured[index].unwrap().position,
                feedforward_effort: efforts[(2 * index) % efforts.len()],
                feedback_effort: efforts[(2 * index + 1) % efforts.len()],
                ..DofCommand::default()
            })
            .collect();
        let mut out = vec![None; rig.servos().len()];
        // After 0.2 s no effort is faded.
        for _ in 0..50 {
            drives.step(&asked, &conditions, &mut out).unwrap();
        }
        // Motions that the servos can make, and the joints' motions that follow.
        let moving = moving(&conditions, &speeds);
        let mut motion = vec![None; rig.dofs().len()];
        drives.measured(&moving, &mut motion).unwrap();
        let of_joints: f32 =
            asked.iter().zip(&motion).map(|(asked, motion)| asked.effort() * motion.unwrap().velocity).sum();
        let mut of_servos = 0.0;
        let mut pushed = moving.clone();
        for (servo, out) in out.iter().enumerate() {
            let out = out.unwrap();
            let Command::Current(a) = out.command else { panic!("{out:?}") };
            prop_assert_eq!(out.limit, None);
            let read = pushed[servo].feedback.as_mut().unwrap();
            of_servos += a * rig.servos()[servo].servo.settings().torque_constant_nm_a * read.velocity_rad_s;
            read.effort = Effort::Current(a);
        }
        let tolerance = 1e-4 * (of_servos.abs() + 0.1);
        prop_assert!((of_joints - of_servos).abs() < tolerance, "{of_joints} W at joints, {of_servos} W at servos");
        // Efforts that are measured by currents do the same work, too.
        drives.measured(&pushed, &mut motion).unwrap();
        let told: f32 = motion.iter().map(|motion| motion.unwrap().effort.unwrap() * motion.unwrap().velocity).sum();
        prop_assert!((told - of_servos).abs() < tolerance, "{told} W told, {of_servos} W at servos");
    }

    #[test]
    fn stale_and_hot_servos_lose_their_effort_and_keep_their_target(
        kinds in kinds(),
        numbers in prop::collection::vec(-1.0_f32..1.0, 6),
        effort in 0.01_f32..0.1,
        is_hot in any::<bool>(),
    ) {
        let rig = rig(&kinds);
        let (conditions, measured) = posed(&rig, 1, &numbers);
        let asked: Vec<_> = measured
            .iter()
            .map(|measured| DofCommand {
                position: measured.unwrap().position,
                feedforward_effort: effort,
                feedback_effort: 0.5 * effort,
                ..DofCommand::default()
            })
            .collect();
        let mut lost = conditions.clone();
        for condition in &mut lost {
            if is_hot {
                condition.temperature_c = Some(70.0);
            } else {
                condition.feedback.as_mut().unwrap().age_ticks = 21;
            }
        }
        let reason = if is_hot { Limit::Heat } else { Limit::Stale };
        let mut out = vec![None; rig.servos().len()];
        for class in OF_EFFORT {
            let mut drives = drives(&rig, class);
            drives.begin(&conditions);
            for _ in 0..100 {
                drives.step(&asked, &conditions, &mut out).unwrap();
            }
            let mut without = asked.clone();
            for asked in &mut without {
                asked.feedforward_effort = 0.0;
            }
            let mut plain = self::drives(&rig, class);
            plain.begin(&conditions);
            let mut targets = out.clone();
            for _ in 0..100 {
                plain.step(&without, &conditions, &mut targets).unwrap();
            }
            for _ in 0..100 {
                drives.step(&asked, &lost, &mut out).unwrap();
            }
            for (out, target) in out.iter().zip(&targets) {
                let out: ServoCommand = out.unwrap();
                match (out.command, target.unwrap().command) {
                    (Command::Current(a) | Command::Pwm(a), _) => prop_assert!(a.abs() <= 0.0, "{a}"),
                    (Command::PositionAt { position_rad: found, .. }, Command::PositionAt { position_rad, .. }) => {
                        prop_assert!((found - position_rad).abs() < 1e-6, "{found} rad for {position_rad}");
                    }
                    other => prop_assert!(false, "{other:?}"),
                }
                prop_assert_eq!(out.limit, Some(reason));
            }
        }
    }
}

/// Each kind of drive makes a valid rig, so no property is true only because a kind is left out.
#[test]
fn every_kind_of_drive_makes_a_rig() {
    let rows = [[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.1, 0.0, 1.0]];
    let all = [
        Kind::Single { gear: 2.0, direction: -1 },
        Kind::Mirrored,
        Kind::Mimic { ratio: 0.5 },
        Kind::Differential,
        Kind::Slide { m_rad: 0.01 },
        Kind::Curve { falls: true },
        Kind::FourBar,
        Kind::Ball { rows },
    ];
    let rig = rig(&all);
    assert_eq!((rig.drives().len(), rig.servos().len(), rig.dofs().len()), (8, 12, 12));
    assert_eq!(drives(&rig, 1).servos().len(), 12);
}
