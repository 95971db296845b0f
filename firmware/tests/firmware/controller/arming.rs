//! A rig that is still falling cannot be armed: its servos could not catch it before the following error becomes a
//! fault.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{Command, Refused, State};

use super::test_rig::{Kind, TestRig};

#[test]
fn a_rig_that_moves_is_armed_when_it_rests() {
    // An arm of XL430 is left out: friction holds it.
    for kind in [Kind::Current, Kind::Position] {
        let mut test_rig = TestRig::new(kind, Start::default());
        // Until now the arm was held at home, and it falls. Meanwhile registers are compared, and the way to stop is
        // tested.
        test_rig.run(0.4);
        let moving = test_rig.controller.report().moving.expect("it falls");
        assert!(moving.mrad_s > moving.most_mrad_s, "{moving}");
        test_rig.tick(Some(Command::Arm));
        let answer = test_rig.controller.report().answer;
        let Some(Err(Refused::Moving(moving))) = answer else { panic!("{answer:?}") };
        let words = Refused::Moving(moving).to_string();
        assert!(words.starts_with("the rig is moving: joint ") && words.ends_with("it rests"));
        assert_eq!((test_rig.state(), test_rig.servos_on()), (State::Limp, 0));

        test_rig.arm();
        // While torque is on, movement is intended and is not reported.
        for _ in 0..test_rig.ticks_of(3.0) {
            test_rig.tick(None);
            let report = test_rig.controller.report();
            assert!(report.raised.is_empty() && report.moving.is_none(), "{report:?}");
        }
        assert_eq!(test_rig.state(), State::Holding);
    }
}
