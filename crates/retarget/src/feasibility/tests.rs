use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Link, LinkedRange};
use sinew_rig::review::Servos;

use super::*;

/// Creates an arm: a fixed base, and a shoulder and an elbow that bend about z, each with a rod of 0.2 m and 0.2
/// kg.
pub(super) fn arm(effort: f64) -> Mechanism {
    let rod = |parent, joint, x: f64, name: &str| Link {
        joint_name: name.to_owned(),
        mass_kg: 0.2,
        center_of_mass_m: DVec3::X * 0.1,
        inertia_kg_m2: DMat3::from_diagonal(DVec3::splat(1e-3)),
        ranges: vec![[-1.5, 1.5]],
        speed: 4.0,
        acceleration: 60.0,
        effort,
        // The home pose hangs down.
        home: vec![-1.4],
        ..Link::on(Some(parent), joint, DVec3::X * x)
    };
    let bend = JointModel::Revolute(DVec3::Z);
    let base = Link::on(None, JointModel::Fixed, DVec3::ZERO);
    let mut elbow = rod(1, bend, 0.2, "elbow");
    elbow.home = vec![0.0];
    Mechanism { bodies: vec![base, rod(0, bend, 0.0, "shoulder"), elbow], linked: vec![] }
}

pub(super) fn swing(mechanism: &Mechanism, size: f64, hz: f64) -> (Limits, RigMotion) {
    let rows = (0..=400)
        .map(|row| {
            let phase = std::f64::consts::TAU * hz * f64::from(row) * 0.01;
            vec![-0.7 + size * libm::sin(phase), 0.5 * size * libm::cos(phase)]
        })
        .collect();
    (Limits::of(mechanism, &Servos::default()), RigMotion { dt_s: 0.01, rows })
}

#[track_caller]
pub(super) fn exceeds_nothing(mechanism: &Mechanism, limits: &Limits, motion: &RigMotion) {
    let curve = Curve::new(mechanism, motion).unwrap();
    // Five times the sampling rate of the fit.
    let report = check(mechanism, limits, &curve, 1000.0).unwrap();
    assert_eq!(report.excesses, []);
}

#[test]
fn a_motion_within_all_limits_stays_as_it_is() {
    let arm = arm(2.0);
    let (limits, motion) = swing(&arm, 0.4, 0.5);
    let fitted = fit(&arm, &limits, &motion, FitSettings::default()).unwrap();
    assert_eq!(fitted.motion, motion);
    assert!(fitted.smoothed.is_empty() && fitted.lowered.is_empty() && fitted.clamped.is_empty());
    assert!(fitted.slowest.0 >= 1.0);
}

#[test]
fn a_motion_that_is_too_fast_becomes_slower() {
    let arm = arm(20.0);
    let (limits, motion) = swing(&arm, 0.7, 2.0);
    let curve = Curve::new(&arm, &motion).unwrap();
    let report = check(&arm, &limits, &curve, 1000.0).unwrap();
    assert!(report.excesses.iter().any(|excess| excess.kind == Kind::Speed && excess.dof == 0));
    assert!(report.excesses.iter().any(|excess| excess.kind == Kind::Acceleration));
    let fitted = fit(&arm, &limits, &motion, FitSettings::default()).unwrap();
    exceeds_nothing(&arm, &limits, &fitted.motion);
    assert!(fitted.slowest.0 < 0.7 && fitted.slowest.0 > 0.3, "{:?}", fitted.slowest);
    assert!(fitted.motion.duration_s() > 1.3 * motion.duration_s());
    assert!((fitted.given_s.last().unwrap() - motion.duration_s()).abs() < 1e-6);
    assert!(fitted.given_s.windows(2).all(|pair| pair[1] > pair[0]));
}

#[test]
fn a_fit_to_tighter_limits_goes_on_from_the_one_before() {
    let arm = arm(20.0);
    let (limits, motion) = swing(&arm, 0.7, 2.0);
    let settings = FitSettings::default();
    let first = fit(&arm, &limits, &motion, settings).unwrap();
    // For equal limits nothing remains to be done.
    assert_eq!(refit(&arm, &limits, &motion, &first.progress, settings).as_ref(), Ok(&first));
    let mut tight = limits.clone();
    tight.dofs[0].speed *= 0.8;
    let [anew, again] = [
        fit(&arm, &tight, &motion, settings).unwrap(),
        refit(&arm, &tight, &motion, &first.progress, settings).unwrap(),
    ];
    exceeds_nothing(&arm, &tight, &again.motion);
    // It is as slow as necessary, and hardly slower than without the earlier fit.
    let [anew_s, again_s] = [anew, again].map(|fit| fit.motion.duration_s());
    assert!(again_s > 1.05 * first.motion.duration_s(), "{again_s}");
    assert!(again_s < 1.1 * anew_s, "{again_s} {anew_s}");
}

#[test]
fn a_limit_is_tightened_once_however_often_it_was_exceeded() {
    let arm = arm(20.0);
    let (limits, motion) = swing(&arm, 0.9, 1.0);
    let curve = Curve::new(&arm, &motion).unwrap();
    let report = check(&arm, &limits, &curve, 1000.0).unwrap();
    let of = |kind| {
        let excesses = report.excesses.iter().filter(move |excess| excess.dof == 0);
        excesses.filter(move |excess| excess.kind == kind).collect::<Vec<_>>()
    };
    assert!(of(Kind::Speed).len() > 2 && of(Kind::Range).len() > 2);
    let tight = limits.tightened(&report);
    assert!((tight.dofs[0].speed - 0.93 * limits.dofs[0].speed).abs() < 1e-9);
    // The range is tightened by the largest excess.
    let beyond = |excess: &&Excess| (excess.value - excess.limit).abs();
    let worst = of(Kind::Range).iter().map(beyond).fold(0.0, f64::max);
    let [least, most] = [0, 1].map(|end| (tight.dofs[0].range[end]).abs());
    assert!((1.5 - least - 1.5 * worst).abs() < 1e-9 && (1.5 - most - 1.5 * worst).abs() < 1e-9);
    // A limit that was not exceeded is unchanged.
    assert!(of(Kind::Effort).is_empty());
    assert!((tight.dofs[0].effort - limits.dofs[0].effort).abs() < 1e-9);
}

#[test]
fn without_a_limit_of_effort_the_fit_is_that_of_endless_strength() {
    let mut strong = arm(1e9);
    let (limits, motion) = swing(&strong, 0.7, 2.0);
    let fitted = fit(&strong, &limits, &motion, FitSettings::default()).unwrap();
    strong.bodies.iter_mut().for_each(|link| link.effort = f64::INFINITY);
    let (limits, _) = swing(&strong, 0.7, 2.0);
    assert_eq!(fit(&strong, &limits, &motion, FitSettings::default()), Ok(fitted));
}

#[test]
fn a_pose_that_is_too_heavy_is_drawn_towards_home() {
    // The stretched arm needs 0.2 * 9.81 * (0.1 + 0.3) = 0.78 N m.
    let arm = arm(0.5);
    let (limits, motion) = swing(&arm, 0.7, 0.2);
    let fitted = fit(&arm, &limits, &motion, FitSettings::default()).unwrap();
    exceeds_nothing(&arm, &limits, &fitted.motion);
    assert!(fitted.lowered.iter().any(|lowered| lowered.joint == "shoulder"));
    assert!(fitted.lowered.iter().all(|lowered| lowered.share > 0.3), "{:?}", fitted.lowered);
}

#[test]
fn where_gravity_takes_nearly_all_the_pose_changes_too() {
    // Stretched: gravity needs 0.78 of the 0.80 N m that the fit permits. Slowing alone would need a seventh of the
    // speed.
    let arm = arm(0.84);
    let (limits, mut motion) = swing(&arm, 0.0, 1.0);
    for (row, q) in (0..).zip(&mut motion.rows) {
        *q = vec![0.15 * libm::sin(0.04 * std::f64::consts::PI * f64::from(row)), 0.0];
    }
    let fitted = fit(&arm, &limits, &motion, FitSettings::default()).unwrap();
    exceeds_nothing(&arm, &limits, &fitted.motion);
    assert!(fitted.slowest.0 > 0.25, "{:?}", fitted.slowest);
    assert!(fitted.lowered.iter().all(|lowered| lowered.share > 0.5), "{:?}", fitted.lowered);
}

#[test]
fn a_home_that_is_too_heavy_gives_way_to_a_lighter_pose() {
    let mut arm = arm(0.3);
    arm.bodies[1].home = vec![0.0];
    let (limits, motion) = swing(&arm, 0.4, 0.2);
    let fitted = fit(&arm, &limits, &motion, FitSettings::default()).unwrap();
    exceeds_nothing(&arm, &limits, &fitted.motion);
    assert!(fitted.lightened.iter().any(|(joint, by)| joint == "shoulder" && *by > 0.5));
}

#[test]
fn a_rig_that_is_too_heavy_everywhere_is_told() {
    let mut arm = arm(0.1);
    arm.bodies[1].home = vec![0.0];
    arm.bodies[1].ranges = vec![[-0.5, 0.5]];
    let (limits, motion) = swing(&arm, 0.2, 0.2);
    let refused = fit(&arm, &limits, &motion, FitSettings::default()).unwrap_err();
    let FitError::Heavy { joint, held, limit, .. } = &refused else { panic!("{refused}") };
    assert!(held > limit);
    assert_eq!(joint, "shoulder");
}

#[test]
fn what_is_beyond_a_range_is_brought_back_and_told() {
    let arm = arm(20.0);
    let (limits, motion) = swing(&arm, 1.0, 0.2);
    let fitted = fit(&arm, &limits, &motion, FitSettings::default()).unwrap();
    exceeds_nothing(&arm, &limits, &fitted.motion);
    let [(joint, change)] = &fitted.clamped[..] else { panic!("{:?}", fitted.clamped) };
    assert!(joint == "shoulder" && (change - 0.205).abs() < 1e-3, "{change}");
}

/// A mouth corner that slides by 8 mm.
fn lip() -> Mechanism {
    let base = Link::on(None, JointModel::Fixed, DVec3::ZERO);
    let lip = Link {
        joint_name: "lip".to_owned(),
        ranges: vec![[0.0, 0.008]],
        ..Link::on(Some(0), JointModel::Prismatic(DVec3::X), DVec3::ZERO)
    };
    Mechanism { bodies: vec![base, lip], linked: vec![] }
}

#[test]
fn a_small_slide_keeps_its_way() {
    let lip = lip();
    let limits = Limits::of(&lip, &Servos::default());
    let row = |row: i32| vec![0.004 - 0.005 * libm::cos(0.05 * f64::from(row))];
    let motion = RigMotion { dt_s: 0.01, rows: (0..=200).map(row).collect() };
    let fitted = fit(&lip, &limits, &motion, FitSettings::default()).unwrap();
    exceeds_nothing(&lip, &limits, &fitted.motion);
    let [(joint, change)] = &fitted.clamped[..] else { panic!("{:?}", fitted.clamped) };
    assert!(joint == "lip" && *change > 0.001, "{change}");
    let far = fitted.motion.rows.iter().map(|row| row[0]).fold(0.0, f64::max);
    // The margin is 2 % of its range.
    assert!(far > 0.0078, "{far}");
}

#[test]
fn a_ball_stays_within_its_turn_and_two_joints_within_what_joins_them() {
    let mut arm = arm(20.0);
    arm.bodies[2].joint = JointModel::Spherical;
    arm.bodies[2].ranges = vec![[0.0, 0.6]];
    arm.bodies[2].home = vec![0.0, 0.0, 0.0, 1.0];
    let limits = Limits::of(&arm, &Servos::default());
    let row = |row: i32| {
        let turn = DVec3::new(1.0, 0.3, 0.0) * libm::sin(0.02 * f64::from(row));
        [&[-0.7][..], &DQuat::from_scaled_axis(turn).to_array()].concat()
    };
    let motion = RigMotion { dt_s: 0.01, rows: (0..=400).map(row).collect() };
    let fitted = fit(&arm, &limits, &motion, FitSettings::default()).unwrap();
    exceeds_nothing(&arm, &limits, &fitted.motion);
    assert!(fitted.clamped.iter().any(|(joint, _)| joint == "elbow"), "{:?}", fitted.clamped);

    let mut lids = self::arm(20.0);
    let joined =
        LinkedRange { body: 2, other: 1, factor: 1.0, other_factor: 1.0, range: [-1.2, -0.2] };
    lids.linked.push(joined);
    let (limits, motion) = swing(&lids, 0.6, 0.3);
    let fitted = fit(&lids, &limits, &motion, FitSettings::default()).unwrap();
    exceeds_nothing(&lids, &limits, &fitted.motion);
    assert!(fitted.clamped.iter().any(|(joint, _)| joint == "elbow"), "{:?}", fitted.clamped);
}

#[test]
fn a_hot_drive_is_drawn_towards_home() {
    let arm = arm(5.0);
    let (mut limits, motion) = swing(&arm, 0.5, 0.2);
    // It holds 0.3 N m continuously; its motor has a time constant of 1 s.
    limits.dofs[0].heat = Some(Heat { continuous: 0.3, time_s: 1.0 });
    let fitted = fit(&arm, &limits, &motion, FitSettings::default()).unwrap();
    exceeds_nothing(&arm, &limits, &fitted.motion);
    assert!(fitted.lowered.iter().any(|lowered| lowered.joint == "shoulder"));
}

#[test]
fn what_was_exceeded_is_what_becomes_tighter() {
    let arm = arm(1.0);
    let (mut limits, _) = swing(&arm, 0.1, 0.1);
    limits.dofs[1].heat = Some(Heat { continuous: 0.5, time_s: 60.0 });
    let excess = |kind, value, limit| Excess {
        dof: 1,
        kind,
        from_s: 0.0,
        to_s: 0.0,
        worst_s: 0.0,
        value,
        limit,
    };
    let report = |excess| Report { duration_s: 1.0, peaks: vec![], excesses: vec![excess] };
    let tight = |kind, value, limit| limits.tightened(&report(excess(kind, value, limit)));
    assert!(tight(Kind::Speed, 5.0, 4.0).dofs[1].speed < 4.0);
    assert!(tight(Kind::Heat, 0.6, 0.5).dofs[1].heat.unwrap().continuous < 0.5);
    assert!(tight(Kind::Heat, 0.6, 0.5).dofs[1].effort >= 1.0);
    assert!(tight(Kind::Range, 1.6, 1.5).dofs[1].range[1] < 1.5);
    assert_eq!(tight(Kind::Range, 1.6, 1.5).dofs[0], limits.dofs[0]);
}

#[test]
fn numbers_that_no_rig_has_are_refused() {
    let arm = arm(1.0);
    let (_, mut motion) = swing(&arm, 0.2, 0.2);
    motion.rows[7][1] = f64::NAN;
    assert!(
        matches!(motion.check(&arm), Err(MotionError::Number { row: 7, joint, .. }) if joint == "elbow")
    );
    motion.rows[7].pop();
    assert!(matches!(motion.check(&arm), Err(MotionError::Count { row: 7, .. })));
}

proptest! {
    /// Speeds and accelerations of a body with rotation and translation are the derivatives of its pose.
    #[test]
    fn a_curve_has_exact_derivatives(
        turns in prop::collection::vec(prop::array::uniform3(-0.4..0.4), 6),
        row in 1..4_u8, part in 0.001..0.999,
    ) {
        // Not within h of a row: the jerk has a step there, which differences would mix.
        let at = 0.1 * (f64::from(row) + part);
        let base = Link { joint_name: "base".to_owned(), ..Link::on(None, JointModel::Free, DVec3::ZERO) };
        let mechanism = Mechanism { bodies: vec![base], linked: vec![] };
        let mut turned = DQuat::IDENTITY;
        let rows = turns
            .iter()
            .map(|turn| {
                turned *= DQuat::from_scaled_axis(DVec3::from_array(*turn));
                [&turned.to_array()[..], turn].concat()
            })
            .collect();
        let curve = Curve::new(&mechanism, &RigMotion { dt_s: 0.1, rows }).unwrap();
        let pose = |time_s: f64| {
            let mut instant = Instant::default();
            curve.at(time_s, &mut instant);
            instant
        };
        let h = 1e-5;
        let [before, now, after] = [at - h, at, at + h].map(pose);
        let rotation = |i: &Instant| DQuat::from_slice(&i.q);
        let v = |numbers: &[f64]| DVec3::from_slice(numbers);
        let speed = (rotation(&before).conjugate() * rotation(&after)).to_scaled_axis() / (2.0 * h);
        // Differences of rotations have rounding errors of 1e-16 / h, and chord errors of h².
        prop_assert!((speed - v(&now.qd)).length() < 1e-6 * (1.0 + speed.length()));
        let acceleration = (v(&after.qd) - v(&before.qd)) / (2.0 * h);
        prop_assert!((acceleration - v(&now.qdd)).length() < 1e-5 * (1.0 + acceleration.length()));
        let way = (v(&after.q[4..]) - v(&before.q[4..])) / (2.0 * h);
        prop_assert!((rotation(&now) * v(&now.qd[3..]) - way).length() < 1e-6);
    }
}
