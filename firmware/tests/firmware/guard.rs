//! The guard: it leaves alone what drives give, and holds what anybody else gives.

use proptest::prelude::*;
use sinew_core::coordinates::DofCommand;
use sinew_core::tracker::Timing;
use sinew_firmware::drives::{
    Condition, CurrentSettings, CutOff, DriveSettings, Drives, Encoder, PositionSettings,
    TargetSettings, VoltageSettings,
};
use sinew_firmware::supervisor::{Guard, GuardReason, GuardSettings, Permission, Source};
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

fn settings() -> GuardSettings {
    GuardSettings {
        zero_rad: 3.0,
        range_rad: [-1.0, 1.5],
        gear: 2.0,
        speed_rad_s: 4.0,
        acceleration_rad_s2: 50.0,
        offset_rad_s: 0.0,
        lead_rad: 0.5,
        effort: 0.8,
        stale_s: 0.1,
        tells: true,
    }
}

fn guard() -> Guard {
    Guard::new(settings(), DT_S).unwrap()
}

/// At an own position, at rest.
fn at(own_rad: f32) -> Feedback {
    let effort = Effort::Current(0.0);
    Feedback { position_rad: own_rad + 3.0, velocity_rad_s: 0.0, effort, age_ticks: 0 }
}

fn own(command: Option<Command>) -> f32 {
    match command {
        Some(Command::Position(rad) | Command::PositionAt { position_rad: rad, .. }) => rad - 3.0,
        other => panic!("{other:?}"),
    }
}

#[test]
fn it_says_what_it_changed() {
    let from_rest = |wanted: f32, permission: &Permission| {
        let mut guard = guard();
        guard.check(Command::Position(3.0), Some(at(0.0)), permission);
        let guarded = guard.check(Command::Position(3.0 + wanted), Some(at(0.0)), permission);
        (own(guarded.command), guarded.reason)
    };
    // Of 50 rad/s²: 1.25 mm of a radian in the first tick, and rounding.
    let (rad, reason) = from_rest(0.5, &FREE);
    assert!((rad - 0.001_25).abs() < 2e-5 && reason == Some(GuardReason::Acceleration), "{rad}");
    assert_eq!(from_rest(0.001, &FREE).1, None);
    // A joint at 0.05 rad/s turns this servo at 0.1.
    let soft = Permission { speed_rad_s: Some(0.05), ..FREE };
    let (rad, reason) = from_rest(0.001, &soft);
    assert!((rad - 0.0005).abs() < 2e-5 && reason == Some(GuardReason::Speed), "{rad}");

    let mut guard = guard();
    // A goal far from where the servo is: it begins there.
    let unread = guard.check(Command::Position(3.0), None, &FREE);
    assert_eq!((unread.command, unread.reason), (None, Some(GuardReason::Stale)));
    let far = guard.check(Command::Position(4.0), Some(at(0.0)), &FREE);
    assert!(own(far.command) < 0.01, "{far:?}");
    for command in [Command::Position(f32::NAN), Command::Pwm(f32::INFINITY)] {
        let guarded = guard.check(command, Some(at(0.0)), &FREE);
        assert_eq!((guarded.command, guarded.reason), (None, Some(GuardReason::NotFinite)));
    }
    let limp = Permission { torque: false, ..FREE };
    for command in [Command::Torque(true), Command::Position(3.0), Command::Current(0.0)] {
        let guarded = guard.check(command, Some(at(0.0)), &limp);
        assert_eq!((guarded.command, guarded.reason), (None, Some(GuardReason::NotAllowed)));
    }
    let off = guard.check(Command::Torque(false), None, &limp);
    assert_eq!((off.command, off.reason), (Some(Command::Torque(false)), None));
}

#[test]
fn a_servo_that_is_held_back_is_not_left_behind() {
    let mut guard = guard();
    let mut last = guard.check(Command::Position(3.0), Some(at(0.0)), &FREE);
    for tick in 1..400_u16 {
        last = guard.check(Command::Position(3.0 + 0.0025 * f32::from(tick)), Some(at(0.0)), &FREE);
    }
    assert_eq!((own(last.command), last.reason), (0.5, Some(GuardReason::Lead)));
}

#[test]
fn a_current_and_a_voltage_are_held() {
    let mut guard = guard();
    // What holds of one holds of the other, but for the reason.
    let mut given = |wanted: f32, own_rad: f32, velocity_rad_s: f32, age_ticks: u32| {
        let read = Feedback { velocity_rad_s, age_ticks, ..at(own_rad) };
        let by_current = guard.check(Command::Current(wanted), Some(read), &FREE);
        let by_voltage = guard.check(Command::Pwm(wanted), Some(read), &FREE);
        let Some(Command::Current(a)) = by_current.command else { panic!("{by_current:?}") };
        assert_eq!(by_voltage.command, Some(Command::Pwm(a)));
        let reason = match by_current.reason {
            Some(GuardReason::Current) => Some(GuardReason::Voltage),
            reason => reason,
        };
        assert_eq!(by_voltage.reason, reason);
        (a, by_current.reason)
    };
    assert_eq!(given(0.5, 0.0, 0.0, 0), (0.5, None));
    assert!((given(-2.0, 0.0, 0.0, 0).0 + 0.8).abs() < 1e-5);
    assert_eq!(given(0.5, 1.6, 0.0, 0), (0.0, Some(GuardReason::Range)));
    assert_eq!(given(-0.5, 1.6, 0.0, 0), (-0.5, None));
    assert_eq!(given(0.5, 0.0, 5.2, 0), (0.0, Some(GuardReason::Speed)));
    assert_eq!(given(-0.5, 0.0, 5.2, 0), (-0.5, None), "it brakes");
    assert_eq!(given(0.5, 0.0, 0.0, 21), (0.0, Some(GuardReason::Stale)));
    assert_eq!(guard.check(Command::Current(0.5), None, &FREE).reason, Some(GuardReason::Stale));
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let bad = GuardSettings { speed_rad_s: f32::NAN, ..settings() };
    assert_eq!(Guard::new(bad, DT_S).unwrap_err().what, "speed_rad_s");
    assert!(Guard::new(GuardSettings { range_rad: [1.0, -1.0], ..settings() }, DT_S).is_err());
    assert!(Guard::new(settings(), 0.0).is_err());
}

/// Any number, and often one of a machine.
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
    /// A hostile caller, of a servo that follows perfectly.
    #[test]
    fn nothing_gets_past_it(
        commands in prop::collection::vec((any_command(), prop::option::weighted(0.9, number())), 1..200),
        speed in prop::option::of(0.01_f32..10.0),
        begins in -1.0_f32..1.5,
    ) {
        let mut guard = guard();
        let permission = Permission { speed_rad_s: speed, ..FREE };
        let fastest = speed.map_or(4.0, |speed| (2.0 * speed).min(4.0));
        let (mut is, mut moved) = (begins, 0.0_f32);
        for (command, velocity) in commands {
            let velocity_rad_s = velocity.unwrap_or(0.0);
            let read = velocity.map(|_| Feedback { velocity_rad_s, ..at(is) });
            let guarded = guard.check(command, read, &permission);
            match guarded.command {
                Some(Command::Position(rad) | Command::PositionAt { position_rad: rad, .. }
                    | Command::PositionWithin { position_rad: rad, .. }) => {
                    let goal = rad - 3.0;
                    // A rounding of f32 at 3 rad, and the guard's own.
                    prop_assert!((-1.000_001..=1.500_001).contains(&goal), "{goal}");
                    let way = goal - is;
                    // The guard allows its own rounding, 1e-5 rad, and lets out with its own bits what is within it.
                    prop_assert!(way.abs() <= fastest * DT_S + 2.2e-5, "{way}");
                    let along = (moved * way.signum()).max(0.0);
                    prop_assert!(way.abs() <= along + 50.0 * DT_S * DT_S + 2.3e-5, "{way} {moved}");
                    (is, moved) = (goal, way);
                }
                Some(Command::Current(a) | Command::Pwm(a)) => prop_assert!(a.abs() <= 0.800_01),
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
            if let Some(Command::PositionWithin { current_a, .. }) = guarded.command {
                prop_assert!((0.0..=0.8).contains(&current_a));
            }
        }
    }

    /// What drives give of any targets is within the guard's limits, too: it leaves it alone, to the last bit.
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
                let guarded = guard.check(servo.command, condition.feedback, &FREE);
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
