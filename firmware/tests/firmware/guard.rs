//! Tests of the guard: it does not change the commands of drives, and it limits any other command.

use proptest::prelude::*;
use sinew_core::coordinates::DofCommand;
use sinew_core::tracker::Timing;
use sinew_firmware::drives::{
    Condition, CurrentSettings, CutOff, DriveSettings, Drives, Encoder, PositionSettings,
    TargetSettings, VoltageSettings,
};
use sinew_firmware::supervisor::{
    GoalLimits, Guard, GuardLimits, GuardReason, GuardSettings, Permission, Source, VoltageLimits,
};
use sinew_servo_bus::{Command, Effort, Feedback};

use crate::common::{Rig, kinds, read, rig};

const DT_S: f32 = 0.005;

const FREE: Permission = Permission {
    torque: true,
    source: Source::Hold,
    weight: 1.0,
    runs: true,
    speed_rad_s: None,
    effort: 1.0,
};

fn drive(class: u8) -> DriveSettings {
    let current = CurrentSettings {
        encoder: Encoder::default(),
        blind_rad: 10.0,
        current_a: 0.7,
        cut_off: CutOff::default(),
    };
    match class {
        0 => DriveSettings::Current(current),
        1 => DriveSettings::Position(PositionSettings::default()),
        2 => DriveSettings::Target(TargetSettings { encoder: Some(Encoder::default()) }),
        _ => DriveSettings::Voltage(VoltageSettings {
            current,
            resistance_ohm: 3.4,
            back_emf_v_s: 0.4,
            supply_v: 5.0,
        }),
    }
}

const GOAL: GuardLimits = GuardLimits::Goal(GoalLimits {
    acceleration_rad_s2: 50.0,
    offset_rad_s: 0.0,
    lead_rad: 0.5,
    tells: true,
});
const CURRENT: GuardLimits = GuardLimits::Current { most_a: 0.8 };
/// Limits of 4 V for the current and 2 V for the speed, with a supply of 10 V.
const VOLTAGE: GuardLimits = GuardLimits::Voltage(VoltageLimits {
    most_a: 0.8,
    resistance_ohm: 5.0,
    back_emf_v_s: 0.5,
    supply_v: 10.0,
});

fn settings(limits: GuardLimits) -> GuardSettings {
    GuardSettings {
        zero_rad: 3.0,
        range_rad: [-1.0, 1.5],
        gear: 2.0,
        speed_rad_s: 4.0,
        stale_s: 0.4,
        limits,
    }
}

fn guard(limits: GuardLimits) -> Guard {
    Guard::new(settings(limits), DT_S).unwrap()
}

/// Returns the condition of a servo at rest at its own position.
fn at(own_rad: f32) -> Condition {
    turning(own_rad, 0.0, 0)
}

fn turning(own_rad: f32, velocity_rad_s: f32, age_ticks: u32) -> Condition {
    let effort = Effort::Current(0.0);
    let position_rad = own_rad + 3.0;
    let feedback = Some(Feedback { position_rad, velocity_rad_s, effort, age_ticks });
    Condition { feedback, temperature_c: Some(30.0), supply_v: None }
}

const UNREAD: Condition = Condition { feedback: None, temperature_c: None, supply_v: None };

fn own(command: Option<Command>) -> f32 {
    match command {
        Some(Command::Position(rad) | Command::PositionAt { position_rad: rad, .. }) => rad - 3.0,
        other => panic!("{other:?}"),
    }
}

#[test]
fn it_says_what_it_changed() {
    let from_rest = |wanted: f32, permission: &Permission| {
        let mut guard = guard(GOAL);
        guard.check(Command::Position(3.0), &at(0.0), permission);
        let guarded = guard.check(Command::Position(3.0 + wanted), &at(0.0), permission);
        (own(guarded.command), guarded.reason)
    };
    // At 50 rad/s² the first tick allows 1.25e-3 rad, plus rounding.
    let (rad, reason) = from_rest(0.5, &FREE);
    assert!((rad - 0.001_25).abs() < 2e-5 && reason == Some(GuardReason::Acceleration), "{rad}");
    assert_eq!(from_rest(0.001, &FREE).1, None);
    // A joint at 0.05 rad/s turns this servo at 0.1 rad/s.
    let soft = Permission { speed_rad_s: Some(0.05), ..FREE };
    let (rad, reason) = from_rest(0.001, &soft);
    assert!((rad - 0.0005).abs() < 2e-5 && reason == Some(GuardReason::Speed), "{rad}");

    let mut guard = guard(GOAL);
    // A goal that is far from the servo: the movement begins at the servo's position.
    let unread = guard.check(Command::Position(3.0), &UNREAD, &FREE);
    assert_eq!((unread.command, unread.reason), (None, Some(GuardReason::Stale)));
    let far = guard.check(Command::Position(4.0), &at(0.0), &FREE);
    assert!(own(far.command) < 0.01, "{far:?}");
    for command in [Command::Position(f32::NAN), Command::Pwm(f32::INFINITY)] {
        let guarded = guard.check(command, &at(0.0), &FREE);
        assert_eq!((guarded.command, guarded.reason), (None, Some(GuardReason::NotFinite)));
    }
    let limp = Permission { torque: false, ..FREE };
    for command in [Command::Torque(true), Command::Position(3.0), Command::Current(0.0)] {
        let guarded = guard.check(command, &at(0.0), &limp);
        assert_eq!((guarded.command, guarded.reason), (None, Some(GuardReason::NotAllowed)));
    }
    let off = guard.check(Command::Torque(false), &UNREAD, &limp);
    assert_eq!((off.command, off.reason), (Some(Command::Torque(false)), None));
}

#[test]
fn a_servo_that_is_held_back_is_not_left_behind() {
    let mut guard = guard(GOAL);
    let mut last = guard.check(Command::Position(3.0), &at(0.0), &FREE);
    for tick in 1..400_u16 {
        last = guard.check(Command::Position(3.0 + 0.0025 * f32::from(tick)), &at(0.0), &FREE);
    }
    assert_eq!((own(last.command), last.reason), (0.5, Some(GuardReason::Lead)));
}

#[test]
fn a_current_is_held() {
    let mut guard = guard(CURRENT);
    let mut given = |wanted: f32, own_rad: f32, velocity_rad_s: f32, age_ticks: u32| {
        let read = turning(own_rad, velocity_rad_s, age_ticks);
        let guarded = guard.check(Command::Current(wanted), &read, &FREE);
        let Some(Command::Current(a)) = guarded.command else { panic!("{guarded:?}") };
        (a, guarded.reason)
    };
    assert_eq!(given(0.5, 0.0, 0.0, 0), (0.5, None));
    let (a, reason) = given(-2.0, 0.0, 0.0, 0);
    assert!((a + 0.8).abs() < 1e-5 && reason == Some(GuardReason::Current));
    assert_eq!(given(0.5, 1.6, 0.0, 0), (0.0, Some(GuardReason::Range)));
    assert_eq!(given(-0.5, 1.6, 0.0, 0), (-0.5, None));
    assert_eq!(given(0.5, 0.0, 5.2, 0), (0.0, Some(GuardReason::Speed)));
    assert_eq!(given(-0.5, 0.0, 5.2, 0), (-0.5, None), "it brakes");
    assert_eq!(given(0.5, 0.0, 0.0, 81), (0.0, Some(GuardReason::Stale)));
    assert_eq!(guard.check(Command::Current(0.5), &UNREAD, &FREE).reason, Some(GuardReason::Stale));
}

/// With a supply of 10 V, a part of 0.4 drives the maximum current at standstill, and each rad/s adds a part of 0.05
/// for the back-EMF.
#[test]
fn a_voltage_is_held_to_that_of_the_most_current() {
    let mut guard = guard(VOLTAGE);
    let mut given = |wanted: f32, read: Condition, permission: &Permission| {
        let guarded = guard.check(Command::Pwm(wanted), &read, permission);
        let Some(Command::Pwm(part)) = guarded.command else { panic!("{guarded:?}") };
        // Rounding is removed.
        ((1e5 * part).round() * 1e-5, guarded.reason)
    };
    let near = |(part, reason): (f32, _), expected: f32, why| {
        assert!((part - expected).abs() < 1e-6 && reason == why, "{part} {expected} {reason:?}");
    };
    let voltage = Some(GuardReason::Voltage);
    // The whole supply would drive 2 A at standstill.
    near(given(1.0, at(0.0), &FREE), 0.4, voltage);
    near(given(-1.0, at(0.0), &FREE), -0.4, voltage);
    near(given(0.39, at(0.0), &FREE), 0.39, None);
    near(given(1.0, turning(0.0, 4.0, 0), &FREE), 0.6, voltage);
    near(given(-1.0, turning(0.0, 4.0, 0), &FREE), -0.2, voltage);
    // The servo's reading of the supply is used unless it is impossible.
    let at_v = |supply_v| Condition { supply_v: Some(supply_v), ..at(0.0) };
    near(given(1.0, at_v(8.0), &FREE), 0.5, voltage);
    near(given(1.0, at_v(0.1), &FREE), 0.6, voltage);
    // A servo at twice its permitted speed gets nothing that drives it, even if it is turned by hand, and no brake
    // beyond its current.
    let fast = turning(0.0, 10.0, 0);
    near(given(0.6, fast, &FREE), 0.5, Some(GuardReason::Speed));
    near(given(0.0, fast, &FREE), 0.1, voltage);
    near(given(0.2, fast, &FREE), 0.2, None);
    // Less voltage drives a servo that is lowered; its winding may brake it.
    let [half, limp] = [0.5, 0.0].map(|effort| Permission { effort, ..FREE });
    near(given(1.0, at(0.0), &half), 0.2, voltage);
    near(given(0.0, turning(0.0, 5.0, 0), &limp), 0.0, None);
    near(given(0.4, turning(0.0, 5.0, 0), &limp), 0.25, voltage);
    // Beyond an end, and without a reading, there is no voltage; a drive that releases the servo may short its
    // winding.
    near(given(0.3, at(1.6), &FREE), 0.0, Some(GuardReason::Range));
    near(given(-0.3, at(1.6), &FREE), -0.3, None);
    near(given(0.0, turning(1.6, 10.0, 0), &FREE), 0.0, None);
    near(given(0.3, turning(0.0, 0.0, 81), &FREE), 0.0, Some(GuardReason::Stale));
    near(given(0.0, turning(0.0, 10.0, 21), &FREE), 0.0, None);
    near(given(1.0, turning(0.0, 0.0, 21), &FREE), 0.4, voltage);
}

#[test]
fn a_servo_gets_no_command_that_its_drive_does_not_give() {
    let all = [
        (Command::Position(3.0), GOAL),
        (Command::Current(0.0), CURRENT),
        (Command::Pwm(0.0), VOLTAGE),
    ];
    for (command, _) in all {
        for (own, limits) in all {
            let guarded = guard(limits).check(command, &at(0.0), &FREE);
            let refused = (command != own).then_some(GuardReason::Kind);
            assert_eq!((guarded.command.is_none(), guarded.reason), (refused.is_some(), refused));
        }
    }
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let refused = |settings: GuardSettings| Guard::new(settings, DT_S).unwrap_err().what;
    assert_eq!(refused(GuardSettings { speed_rad_s: f32::NAN, ..settings(GOAL) }), "speed_rad_s");
    let backwards = GuardSettings { range_rad: [1.0, -1.0], ..settings(GOAL) };
    assert_eq!(refused(backwards), "most of range_rad");
    let most_a = f32::NAN;
    assert_eq!(refused(settings(GuardLimits::Current { most_a })), "most_a");
    let GuardLimits::Goal(goal) = GOAL else { unreachable!("a goal") };
    let GuardLimits::Voltage(voltage) = VOLTAGE else { unreachable!("a voltage") };
    let lead_rad = 0.0;
    assert_eq!(refused(settings(GuardLimits::Goal(GoalLimits { lead_rad, ..goal }))), "lead_rad");
    for (limits, what) in [
        (VoltageLimits { most_a, ..voltage }, "most_a"),
        (VoltageLimits { resistance_ohm: 0.0, ..voltage }, "resistance_ohm"),
        (VoltageLimits { back_emf_v_s: -1.0, ..voltage }, "back_emf_v_s"),
        (VoltageLimits { supply_v: 0.0, ..voltage }, "supply_v"),
    ] {
        assert_eq!(refused(settings(GuardLimits::Voltage(limits))), what);
    }
    assert!(Guard::new(settings(GOAL), 0.0).is_err());
}

/// Generates any numbers, often of a realistic size.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![any::<f32>(), -4.0_f32..8.0, Just(f32::NAN), Just(f32::INFINITY), Just(3.0)]
}

fn any_command() -> impl Strategy<Value = Command> {
    prop_oneof![
        number().prop_map(Command::Position),
        (number(), number()).prop_map(|(position_rad, speed_rad_s)| Command::PositionAt {
            position_rad,
            speed_rad_s
        }),
        (number(), number()).prop_map(|(position_rad, current_a)| Command::PositionWithin {
            position_rad,
            current_a
        }),
        number().prop_map(Command::Current),
        number().prop_map(Command::Pwm),
        any::<bool>().prop_map(Command::Torque),
    ]
}

proptest! {
    /// A hostile caller with a servo that follows perfectly.
    #[test]
    fn nothing_gets_past_it(
        limits in prop::sample::select(vec![GOAL, CURRENT, VOLTAGE]),
        commands in prop::collection::vec((any_command(), prop::option::weighted(0.9, number())), 1..200),
        speed in prop::option::of(0.01_f32..10.0),
        begins in -1.0_f32..1.5,
    ) {
        let mut guard = guard(limits);
        let permission = Permission { speed_rad_s: speed, ..FREE };
        let fastest = speed.map_or(4.0, |speed| (2.0 * speed).min(4.0));
        let (mut is, mut moved) = (begins, 0.0_f32);
        for (command, velocity) in commands {
            let velocity_rad_s = velocity.unwrap_or(0.0);
            let read = velocity.map_or(UNREAD, |_| turning(is, velocity_rad_s, 0));
            let guarded = guard.check(command, &read, &permission);
            match guarded.command {
                Some(Command::Position(rad) | Command::PositionAt { position_rad: rad, .. }) => {
                    prop_assert_eq!(limits, GOAL);
                    let goal = rad - 3.0;
                    // The tolerance is a rounding of f32 at 3 rad, and the guard's own.
                    prop_assert!((-1.000_001..=1.500_001).contains(&goal), "{goal}");
                    let way = goal - is;
                    // The guard tolerates its own rounding, 1e-5 rad, and passes a goal within its limits unchanged.
                    prop_assert!(way.abs() <= fastest * DT_S + 2.2e-5, "{way}");
                    let along = (moved * way.signum()).max(0.0);
                    prop_assert!(way.abs() <= along + 50.0 * DT_S * DT_S + 2.3e-5, "{way} {moved}");
                    (is, moved) = (goal, way);
                }
                Some(Command::Current(a)) => {
                    prop_assert!(limits == CURRENT && a.abs() <= 0.800_01);
                }
                Some(Command::Pwm(part)) => {
                    prop_assert!(limits == VOLTAGE && part.abs() <= 0.600_01, "{part}");
                    // Checked only if the whole window is within that part.
                    let emf = 0.05 * velocity_rad_s;
                    let held = (part - emf).abs() <= 0.400_01 || emf.abs() > 0.2 || emf.is_nan();
                    prop_assert!(held, "{part} {emf}");
                }
                Some(Command::Torque(on)) => {
                    if !on {
                        moved = 0.0;
                    }
                }
                None => prop_assert!(guarded.reason.is_some()),
                other => prop_assert!(false, "{other:?}"),
            }
            if let Some(Command::PositionAt { speed_rad_s, .. }) = guarded.command {
                prop_assert!((0.0..=1.2 * fastest + 0.01).contains(&speed_rad_s));
            }
        }
    }

    /// The commands of drives for any targets are within the guard's limits, too: it passes them unchanged, to the
    /// last bit.
    #[test]
    fn drives_keep_to_it(
        kinds in kinds(),
        class in 0_u8..4,
        numbers in prop::collection::vec(prop_oneof![-1e6_f32..1e6, -4.0_f32..4.0], 4..400),
    ) {
        let rig: Rig = rig(&kinds);
        let timing = Timing { dt_s: DT_S, latency_ticks: 1 };
        let servos = rig.servos().len();
        let mut drives = Drives::new(&rig, &vec![drive(class); servos], timing).unwrap();
        let mut guards: Vec<Guard> = rig.servos().iter().map(|servo| {
            Guard::new(GuardSettings::of(&servo.servo, &drive(class)), DT_S).unwrap()
        }).collect();
        let mut conditions: Vec<Condition> = rig.servos().iter().map(|servo| {
            let [least, most] = servo.servo.settings().range_rad;
            read(0.0_f32.max(least).min(most), 0.0, 0.0)
        }).collect();
        drives.begin(&conditions);
        let mut commands = vec![None; servos];
        for tick in 0..numbers.len() / 4 {
            let of = |index: usize| numbers[(4 * tick + index) % numbers.len()];
            let asked = DofCommand {
                position: of(0), velocity: of(1), feedforward_effort: of(2), feedback_effort: of(3),
                limited: None,
            };
            drives.step(&vec![asked; rig.dofs().len()], &conditions, &mut commands).unwrap();
            for ((guard, condition), command) in guards.iter_mut().zip(&mut conditions).zip(&commands) {
                let Some(servo) = command else { continue };
                let guarded = guard.check(servo.command, condition, &FREE);
                prop_assert_eq!(guarded.command, Some(servo.command), "{:?}", guarded.reason);
                prop_assert_eq!(guarded.reason, None);
                // The servo follows at once.
                if let (Command::Position(rad) | Command::PositionAt { position_rad: rad, .. }, Some(read))
                    = (servo.command, &mut condition.feedback) {
                    read.position_rad = rad;
                }
            }
        }
    }
}
