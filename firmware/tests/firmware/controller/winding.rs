//! Heat of windings computed from servos' readings, compared with the currents of their simulated motors.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::detect::Winding;
use sinew_firmware::supervisor::{Command, Feed, State};

use super::play::show;
use super::test_rig::{Kind, SERVOS, TestRig, setup};

/// XL430 report the part of the supply that they apply, and no current.
#[test]
fn windings_of_servos_by_voltage_heat_as_their_motors_do() {
    let kind = Kind::Voltage;
    let mut test_rig = TestRig::new(kind, Start::default());
    let dt_s = 1.0 / kind.rate_hz() as f32;
    let settings = setup(kind).servos.map(|servo| servo.winding);
    let mut motors = settings.map(|settings| Winding::new(settings, dt_s).unwrap());
    test_rig.controller.load_show(Some(show(kind, 0))).unwrap();
    let mut run = |test_rig: &mut TestRig, ticks: u32| {
        for _ in 0..ticks {
            test_rig.tick(None);
            for (motor, servo) in motors.iter_mut().zip(test_rig.bench.servos()) {
                motor.step(servo.current_a() as f32);
            }
        }
        let told = test_rig.controller.report().servos.iter().map(|servo| servo.heat);
        let both: Vec<[f32; 2]> =
            told.zip(&motors).map(|(told, motor)| [told, motor.heat()]).collect();
        both
    };
    // The arm falls without torque: nothing drives its motors.
    let fallen = run(&mut test_rig, 400);
    assert!(fallen.iter().all(|[told, _]| *told <= 0.0), "{fallen:?}");
    while test_rig.ask_to_arm().is_some() {}
    test_rig.until(State::Holding, 2.0);
    test_rig.tick(Some(Command::Play(Feed::Show)));
    let ticks = test_rig.ticks_of(5.0);
    let played = run(&mut test_rig, ticks);
    assert_eq!((test_rig.state(), played.len()), (State::Playing, SERVOS));
    println!("{played:?}");
    for [told, motor] in played {
        // The tolerance covers the steps of the speed's reading, 0.024 rad/s, and readings that are a tick late.
        assert!((told - motor).abs() < 0.1 * motor + 1e-3, "{told} {motor}");
    }
}
