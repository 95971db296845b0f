use glam::{DQuat, DVec3};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, LinkedRange};
use sinew_rig::review::Servos;

use crate::feasibility::tests::{arm, exceeds_nothing, swing};
use crate::feasibility::{Fit, FitError, FitSettings, Heat, Kind, Limits, RigMotion, fit, refit};

const IN_TIME: FitSettings = FitSettings {
    change: 0.05,
    share: 0.95,
    room: 0.005,
    rate_hz: 200.0,
    keep_time: true,
    from_rest: false,
};

/// Fits a motion in time; checks that the time is kept and that no limit is exceeded.
#[track_caller]
fn kept(mechanism: &Mechanism, limits: &Limits, motion: &RigMotion) -> Fit {
    let fitted = fit(mechanism, limits, motion, IN_TIME).unwrap();
    exceeds_nothing(mechanism, limits, &fitted.motion);
    assert!(fitted.settings.keep_time && fitted.slowest.0 >= 1.0);
    assert!((fitted.motion.duration_s() - motion.duration_s()).abs() < 1e-9);
    fitted
}

/// Returns the way of a coordinate as a share of its way in the given motion, and the correlation of both motions.
fn left(fit: &Fit, given: &RigMotion, k: usize) -> [f64; 2] {
    let of = |motion: &RigMotion| motion.rows.iter().map(|row| row[k]).collect::<Vec<_>>();
    let (a, b) = (of(&fit.motion), of(given));
    let way = |x: &[f64]| x.windows(2).map(|w| (w[1] - w[0]).abs()).sum::<f64>();
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let off = |x: &[f64]| x.iter().map(|v| v - mean(x)).collect::<Vec<_>>();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (c, d) = (off(&a), off(&b));
    [way(&a) / way(&b), dot(&c, &d) / libm::sqrt(dot(&c, &c) * dot(&d, &d))]
}

#[test]
fn a_motion_within_all_limits_stays() {
    let arm = arm(2.0);
    let (limits, motion) = swing(&arm, 0.4, 0.5);
    assert_eq!(kept(&arm, &limits, &motion).motion, motion);
}

#[test]
fn a_motion_that_is_too_fast_becomes_smaller_in_time() {
    // The given motion needs 8.8 of 4 rad/s and 110 of 60 rad/s2 at the shoulder, 4.4 rad/s and 55 rad/s2 at the elbow.
    let arm = arm(20.0);
    let (limits, motion) = swing(&arm, 0.7, 2.0);
    let fitted = kept(&arm, &limits, &motion);
    let [way, alike] = left(&fitted, &motion, 0);
    assert!((0.4..0.6).contains(&way) && alike > 0.97, "{way} {alike}");
    let [way, alike] = left(&fitted, &motion, 1);
    assert!(way > 0.9 && alike > 0.99, "{way} {alike}");
}

#[test]
fn a_motion_that_begins_at_speed_may_begin_at_rest() {
    let arm = arm(20.0);
    // The shoulder of the given motion begins at 1.8 rad/s.
    let (limits, motion) = swing(&arm, 0.7, 0.4);
    let settings = FitSettings { from_rest: true, ..IN_TIME };
    let fitted = fit(&arm, &limits, &motion, settings).unwrap();
    exceeds_nothing(&arm, &limits, &fitted.motion);
    let first = |motion: &RigMotion| (motion.rows[1][0] - motion.rows[0][0]) / motion.dt_s;
    assert!(first(&motion) > 1.5 && first(&fitted.motion).abs() < 0.4, "{}", first(&fitted.motion));
    assert!(left(&fitted, &motion, 0)[1] > 0.99);
}

#[test]
fn a_fit_to_tighter_limits_goes_on_from_the_one_before() {
    let arm = arm(1.0);
    let (limits, motion) = swing(&arm, 0.7, 1.5);
    let first = kept(&arm, &limits, &motion);
    let mut tight = limits.clone();
    tight.dofs[0].speed *= 0.8;
    let again = refit(&arm, &tight, &motion, &first.progress, IN_TIME).unwrap();
    exceeds_nothing(&arm, &tight, &again.motion);
    assert!(left(&again, &motion, 0)[1] > 0.9);
    // A fit that slows down does not continue from a fit that keeps the time.
    let slowed = FitSettings { keep_time: false, ..IN_TIME };
    let anew = fit(&arm, &tight, &motion, slowed).unwrap();
    assert_eq!(refit(&arm, &tight, &motion, &first.progress, slowed), Ok(anew));
}

#[test]
fn a_weak_drive_gets_a_calmer_motion() {
    // Holding the pose takes up to 0.78 N m; the swing alone needs 1.6 N m and more.
    let arm = arm(1.0);
    let (limits, motion) = swing(&arm, 0.7, 1.0);
    let fitted = kept(&arm, &limits, &motion);
    for k in [0, 1] {
        let [way, alike] = left(&fitted, &motion, k);
        assert!(way > 0.3 && alike > 0.85, "{k}: {way} {alike}");
    }
}

#[test]
fn where_gravity_is_too_strong_the_pose_is_drawn_towards_home() {
    let arm = arm(0.5);
    let (limits, motion) = swing(&arm, 0.7, 0.2);
    let fitted = kept(&arm, &limits, &motion);
    assert!(fitted.lowered.iter().any(|lowered| lowered.joint == "shoulder"));
    let mut hot = limits.clone();
    hot.dofs[0].heat = Some(Heat { continuous: 0.3, time_s: 1.0 });
    kept(&arm, &hot, &motion);
}

#[test]
fn a_range_and_what_joins_two_joints_hold() {
    let mut arm = arm(20.0);
    let joined =
        LinkedRange { body: 2, other: 1, factor: 1.0, other_factor: 1.0, range: [-1.2, -0.2] };
    arm.linked.push(joined);
    let (limits, motion) = swing(&arm, 1.0, 0.4);
    let fitted = kept(&arm, &limits, &motion);
    assert!(fitted.clamped.iter().any(|(joint, _)| joint == "elbow"), "{:?}", fitted.clamped);
}

#[test]
fn a_ball_keeps_its_speed() {
    let mut arm = arm(20.0);
    arm.bodies[2].joint = JointModel::Spherical;
    arm.bodies[2].ranges = vec![[0.0, 0.9]];
    arm.bodies[2].home = vec![0.0, 0.0, 0.0, 1.0];
    let limits = Limits::of(&arm, &Servos::default());
    let row = |row: i32| {
        let turn = DVec3::new(0.8, 0.3, 0.0) * libm::sin(0.08 * f64::from(row));
        [&[-0.7][..], &DQuat::from_scaled_axis(turn).to_array()].concat()
    };
    let motion = RigMotion { dt_s: 0.01, rows: (0..=400).map(row).collect() };
    kept(&arm, &limits, &motion);
}

#[test]
fn a_rig_that_is_too_heavy_everywhere_is_told() {
    let mut arm = arm(0.1);
    arm.bodies[1].home = vec![0.0];
    arm.bodies[1].ranges = vec![[-0.5, 0.5]];
    let (limits, motion) = swing(&arm, 0.2, 0.2);
    let refused = fit(&arm, &limits, &motion, IN_TIME).unwrap_err();
    assert!(matches!(refused, FitError::Heavy { ref joint, .. } if joint == "shoulder"));
    // The refusal of a fit in time names the alternatives.
    let refused = FitError::OutOfReach {
        joint: "jaw".into(),
        slides: false,
        kind: Kind::Speed,
        value: 2.0,
        limit: 1.0,
        time_s: 0.5,
        in_time: true,
    };
    let told = refused.to_string();
    assert!(told.contains("smaller, rounder and nearer") && told.contains("--keep-time"), "{told}");
}
