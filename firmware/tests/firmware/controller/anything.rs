//! Random commands and random damage: there is never torque without arming, and no limit is ever exceeded.

use proptest::prelude::*;
use sinew_firmware::controller::{Jog, Start};
use sinew_firmware::supervisor::{Command, FaultSet, Feed, GuardReason, Operator, State};
use sinew_servo_sim::fault;

use super::play::show;
use super::test_rig::{Kind, SERVOS, TestRig, figure};

fn command() -> impl Strategy<Value = Command> {
    use Command::{
        Arm, Calibrate, ClearFaults, Disarm, EStop, Enable, Float, Hold, Leave, Maintain, Play,
        Stop, Teach,
    };
    let one = Operator(1);
    let rare = vec![Disarm, Stop, Calibrate, Teach, EStop, Leave(one)];
    let usual = vec![
        Arm,
        Arm,
        ClearFaults,
        Play(Feed::Show),
        Play(Feed::Live),
        Hold,
        Float,
        Maintain(one),
        Enable(one),
    ];
    prop_oneof![1 => prop::sample::select(rare), 4 => prop::sample::select(usual)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn nothing_leaves_its_limits(
        commands in prop::collection::vec((command(), 1_u32..200, any::<bool>()), 1..30),
        seed in any::<u64>(),
        damages in 0_usize..6,
        live in prop::collection::vec(-4.0_f32..4.0, SERVOS),
        speed in -1e3_f32..1e3,
        kind in prop::sample::select(vec![Kind::Current, Kind::Voltage]),
    ) {
        let mut test_rig = TestRig::new(kind, Start::default());
        test_rig.controller.load_show(Some(show(kind, 0))).unwrap();
        test_rig.live.0 = Some(live);
        test_rig.jog = Some(Jog { dof: 1, speed });
        test_rig.bench.faults = fault::random(seed, damages, SERVOS, 10.0);
        test_rig.run(0.5);
        let mut is_armed = false;
        for (command, ticks, heard) in commands {
            for tick in 0..ticks {
                test_rig.heard = heard;
                let given = (tick == 0).then_some(command);
                test_rig.tick(given);
                let report = test_rig.controller.report();
                is_armed |= report.answer == Some(Ok(State::Arming)) && given == Some(Command::Arm);
                is_armed &= report.state.is_on();
                prop_assert!(is_armed || test_rig.sent_off(), "{:?}", report);
                prop_assert_eq!(is_armed, test_rig.controller.permission().torque);
                let refused = report.servos.iter().any(|servo| {
                    matches!(servo.guard, Some(GuardReason::NotFinite | GuardReason::Kind))
                });
                prop_assert!(!refused);
                let (q, qd) = test_rig.controller.commanded();
                for ((q, qd), dof) in q.iter().zip(qd).zip(figure(kind).board.dofs()) {
                    let [least, most] = dof.range;
                    prop_assert!((least..=most).contains(q));
                    prop_assert!(qd.abs() <= dof.speed * 1.001);
                }
                // Goal current (102) is in mA, with the limit of the drives' settings. Goal PWM (100) may reach its
                // maximum.
                let (goal, most) = if kind == Kind::Current { (102, 1_200) } else { (100, 885) };
                for servo in test_rig.bench.servos() {
                    prop_assert!(!is_armed || servo.get(goal).abs() <= most);
                }
                prop_assert!(report.latched == FaultSet::EMPTY || report.state != State::Arming
                    || given != Some(Command::Arm));
            }
        }
    }
}
