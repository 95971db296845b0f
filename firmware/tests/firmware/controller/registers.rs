//! Comparison of servos' registers with the rig's requirements: servos that differ are not armed.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{Command, Refused, RegisterDiffers, Registers, State};
use sinew_servo_sim::fault::{Fault as Damage, FaultKind};

use super::test_rig::{Kind, SERVOS, TestRig, settings_of, setup};

const WHO: usize = 2;
/// All kinds of arm, with the address of their operating mode's register.
const KINDS: [(Kind, u16); 3] = [(Kind::Current, 11), (Kind::Voltage, 11), (Kind::Position, 33)];

fn refused(test_rig: &mut TestRig) -> Option<Refused> {
    test_rig.ask_to_arm()
}

/// Returns the number of ticks until all registers of all servos are compared. Fails after half a second.
fn ticks_to_compare(test_rig: &mut TestRig) -> u32 {
    for tick in 0..test_rig.ticks_of(0.5) {
        if test_rig.controller.report().registers != Registers::Unread {
            return tick;
        }
        test_rig.tick(None);
    }
    panic!("not all was read: {:?}", test_rig.controller.report());
}

#[test]
fn each_register_that_differs_refuses_and_says_so_until_it_is_mended() {
    for (kind, _) in KINDS {
        for setting in settings_of(kind, &setup(kind), WHO) {
            let (address, raw) = (setting.item.address, setting.raw);
            // A status level of 0 would mean that the servo does not answer.
            let found = if raw > 1 { raw - 1 } else { raw + 1 };
            let expected = setting.wanted(found);
            let mut test_rig = TestRig::new(kind, Start::default());
            test_rig.bench.servos_mut()[WHO].set(address, found);
            test_rig.run(0.5);
            let item = setting.item.name;
            let differs = RegisterDiffers { servo: WHO as u16, item, address, found, expected };
            assert_eq!(refused(&mut test_rig), Some(Refused::RegisterDiffers(differs)), "{kind:?}");
            assert_eq!(test_rig.controller.report().registers, Registers::Differ(differs));
            assert_eq!((test_rig.state().is_on(), test_rig.servos_on()), (false, 0));

            test_rig.bench.servos_mut()[WHO].set(address, expected);
            test_rig.run(1.0);
            assert_eq!(refused(&mut test_rig), None, "{kind:?} {item}");
            test_rig.run(0.1);
            assert_eq!((test_rig.state(), test_rig.servos_on()), (State::Arming, SERVOS));
        }
    }
}

#[test]
fn a_difference_is_told_in_words() {
    let mut test_rig = TestRig::new(Kind::Current, Start::default());
    test_rig.bench.servos_mut()[WHO].set(11, 3);
    test_rig.run(0.5);
    assert_eq!(
        refused(&mut test_rig).unwrap().to_string(),
        "servo 2: Operating Mode (11) is 3, it must be 0: `sinew servo apply` sets it"
    );
}

#[test]
fn arming_waits_until_all_was_read() {
    for (kind, _) in KINDS {
        let mut test_rig = TestRig::new(kind, Start::default());
        assert_eq!(refused(&mut test_rig), Some(Refused::InState(State::Off)));
        let ticks = ticks_to_compare(&mut test_rig);
        println!("{kind:?}: {SERVOS} servos are compared in {ticks} ticks");
        assert_eq!(test_rig.controller.report().registers, Registers::Same);
        assert_eq!((refused(&mut test_rig), test_rig.state()), (None, State::Arming));
        test_rig.tick(Some(Command::Disarm));
        test_rig.until(State::Limp, 20.0);
        test_rig.tick(None);
        assert_eq!(refused(&mut test_rig), Some(Refused::RegistersUnread));
        ticks_to_compare(&mut test_rig);
        assert_eq!(refused(&mut test_rig), None);
    }
}

/// Returns the addresses that were read individually in the last tick.
fn reads(test_rig: &TestRig) -> Vec<u16> {
    let mut addresses = Vec::new();
    for at in 0..test_rig.sent.len() {
        match (test_rig.kind, &test_rig.sent[at..]) {
            (Kind::Current | Kind::Voltage, &[0xFF, 0xFF, 0xFD, 0, _, 7, 0, 2, low, high, ..]) => {
                addresses.push(u16::from_le_bytes([low, high]));
            }
            (Kind::Position, &[0xFF, 0xFF, _, 4, 2, address, ..]) => addresses.push(address.into()),
            _ => {}
        }
    }
    addresses
}

#[test]
fn registers_are_read_while_torque_is_off_alone_one_question_a_tick() {
    for (kind, mode) in KINDS {
        let mut test_rig = TestRig::new(kind, Start::default());
        let last = settings_of(kind, &setup(kind), 0).pop().unwrap().item.address;
        let is_register = |address: &u16| *address <= last;
        let mut seen = Vec::new();
        for _ in 0..test_rig.ticks_of(1.0) {
            test_rig.tick(None);
            let asked = reads(&test_rig).into_iter().filter(is_register);
            assert!(asked.clone().count() <= 1);
            seen.extend(asked);
        }
        assert!(seen.iter().any(|from| (*from..*from + 10).contains(&mode)), "{seen:?}");
        assert_eq!((refused(&mut test_rig), test_rig.state()), (None, State::Arming));
        for _ in 0..test_rig.ticks_of(2.0) {
            assert!(!reads(&test_rig).iter().any(is_register), "{kind:?}");
            assert_eq!(test_rig.controller.report().overruns, 0);
            test_rig.tick(None);
        }
        test_rig.tick(Some(Command::Disarm));
        test_rig.until(State::Limp, 20.0);
        // The comparison starts again, regardless of earlier results.
        assert_eq!(test_rig.controller.report().registers, Registers::Unread);
        ticks_to_compare(&mut test_rig);
    }
}

#[test]
fn a_servo_that_starts_anew_in_a_performance_is_compared_before_it_is_armed_again() {
    let mut test_rig = TestRig::new(Kind::Current, Start::default());
    test_rig.run(1.0);
    assert_eq!(refused(&mut test_rig), None);
    test_rig.until(State::Holding, 2.0);
    // The servo is replaced by another one with the factory's settings.
    let (at_s, for_s) = (test_rig.bench.time_s(), f64::INFINITY);
    test_rig.bench.faults.push(Damage { servo: WHO, at_s, for_s, kind: FaultKind::Reboot });
    test_rig.until(State::Lowering, 3.0);
    test_rig.bench.servos_mut()[WHO].set(11, 3);
    test_rig.until(State::Faulted, 20.0);
    test_rig.run(0.5);
    test_rig.tick(Some(Command::ClearFaults));
    assert_eq!((test_rig.state(), test_rig.servos_on()), (State::Limp, 0));
    let item = "Operating Mode";
    let differs = RegisterDiffers { servo: WHO as u16, item, address: 11, found: 3, expected: 0 };
    assert_eq!(refused(&mut test_rig), Some(Refused::RegisterDiffers(differs)));
    test_rig.bench.servos_mut()[WHO].set(11, 0);
    test_rig.run(0.5);
    assert_eq!(refused(&mut test_rig), None);
}

#[test]
fn a_servo_that_was_silent_is_compared_anew() {
    let mut test_rig = TestRig::new(Kind::Position, Start::default());
    test_rig.run(1.0);
    assert_eq!(test_rig.controller.report().registers, Registers::Same);
    let at_s = test_rig.bench.time_s();
    test_rig.bench.faults.push(Damage { servo: WHO, at_s, for_s: 0.2, kind: FaultKind::Silent });
    test_rig.run(0.1);
    assert_eq!(test_rig.controller.report().registers, Registers::Unread);
    test_rig.run(0.1);
    ticks_to_compare(&mut test_rig);
}

#[test]
fn a_bad_line_only_delays() {
    for (kind, _) in KINDS {
        let mut good = TestRig::new(kind, Start::default());
        let mut bad = TestRig::new(kind, Start::default());
        // One reply in five is lost, cut or damaged: an LCG selects them.
        let mut seed = 7_u32;
        let mut random = |below: u32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 16) % below
        };
        let dt_s = 1.0 / f64::from(kind.rate_hz());
        for tick in 0..bad.ticks_of(4.0) {
            for servo in 0..SERVOS {
                let kind = match random(15) {
                    0 => FaultKind::Silent,
                    1 => FaultKind::Short(7),
                    2 => FaultKind::WrongCheck,
                    _ => continue,
                };
                let at_s = f64::from(tick) * dt_s;
                bad.bench.faults.push(Damage { servo, at_s, for_s: 0.9 * dt_s, kind });
            }
        }
        let ticks = [&mut good, &mut bad].map(|test_rig| {
            (0..test_rig.ticks_of(4.0))
                .find(|_| {
                    test_rig.tick(None);
                    let report = test_rig.controller.report();
                    assert!(!matches!(report.registers, Registers::Differ(_)), "{report:?}");
                    report.registers == Registers::Same
                })
                .unwrap()
        });
        // Both are armed then, at rest, with a reading of each servo.
        for test_rig in [&mut good, &mut bad] {
            let is_armed = (0..test_rig.ticks_of(10.0)).any(|_| {
                test_rig.tick(Some(Command::Arm));
                test_rig.state() == State::Arming
            });
            assert!(is_armed, "{:?}", test_rig.controller.report());
        }
        println!("{kind:?}: compared after {} ticks, on a bad line after {}", ticks[0], ticks[1]);
        assert!(ticks[1] > ticks[0]);
    }
}
