use std::f64::consts::FRAC_PI_2;

use sinew_figure::plant::MassProperties;
use sinew_figure::plant::{PlantKind, link};
use sinew_rig::mechanism::LinkedRange;

use super::axis::{ACCELERATION, SPEED};
use super::*;
use crate::{Errors, Evaluation, MethodName, Protocol, evaluate, report};

/// Returns an arm on `base`: turntable, shoulder, elbow, a slide, a wrist of two axes and a ball joint.
fn arm(base: DQuat) -> Mechanism {
    let mass = |mass_kg: f64, length_m: f64| MassProperties {
        mass_kg,
        center_of_mass_m: DVec3::Y * (0.5 * length_m),
        rotational_kg_m2: glam::DMat3::from_diagonal(
            DVec3::new(1.0, 0.3, 1.0) * (mass_kg * length_m * length_m / 12.0),
        ),
    };
    let joints = [
        (JointModel::Fixed, 1.0, 0.1),
        (JointModel::Revolute(DVec3::Y), 0.5, 0.1),
        (JointModel::Revolute(DVec3::X), 0.4, 0.2),
        (JointModel::Revolute(DVec3::X), 0.3, 0.2),
        (JointModel::Prismatic(DVec3::Y), 0.2, 0.1),
        (JointModel::Universal([DVec3::X, DVec3::Z]), 0.1, 0.08),
        (JointModel::Spherical, 0.1, 0.08),
    ];
    let mut bodies: Vec<Link> = Vec::new();
    for (index, (joint, mass_kg, length_m)) in joints.into_iter().enumerate() {
        let parent = index.checked_sub(1);
        let up = bodies.last().map_or(0.0, |below| 2.0 * below.center_of_mass_m.y);
        let mut body = link(parent, joint, DVec3::Y * up, &mass(mass_kg, length_m));
        body.joint_name = format!("joint_{index}");
        body.name = format!("body_{index}");
        if parent.is_none() {
            body.rotation = base;
        } else {
            // Slightly rotated in its parent, like real joints.
            body.rotation = DQuat::from_rotation_z(0.2);
        }
        match joint {
            JointModel::Revolute(_) => {
                body.ranges = vec![[-1.5, 1.0]];
                (body.speed, body.acceleration) = (6.0, 60.0);
            }
            JointModel::Prismatic(_) => {
                body.ranges = vec![[0.0, 0.05]];
                (body.speed, body.acceleration) = (0.2, 3.0);
            }
            JointModel::Universal(_) => body.ranges = vec![[-0.5, 0.5], [-0.3, 0.7]],
            _ => {}
        }
        bodies.push(body);
    }
    Mechanism { bodies, linked: Vec::new() }
}

fn evaluated(mechanism: &Mechanism, change: impl FnOnce(&mut Protocol)) -> Evaluation {
    let settings = ExerciseSettings { seconds: 2.0, ..ExerciseSettings::default() };
    let exercises = make_exercises("arm", mechanism, &settings).unwrap();
    let mut protocol = Protocol { scales: vec![1.0], ..Protocol::default() };
    protocol.setup.plant.kind = PlantKind::Articulated;
    change(&mut protocol);
    evaluate(&exercises, &protocol, |_| ()).unwrap()
}

fn totals(evaluation: &Evaluation) -> impl Iterator<Item = (MethodName, &Errors)> {
    let methods = evaluation.figures.iter().flat_map(|figure| &figure.methods);
    methods.map(|result| (result.method, &result.total))
}

#[test]
fn a_true_model_is_followed_by_every_method_however_it_stands() {
    let quarter = DQuat::from_rotation_z(FRAC_PI_2);
    for base in [DQuat::IDENTITY, quarter, quarter * quarter] {
        let methods = MethodName::ALL.into_iter().filter(|one| *one != MethodName::Accumulated);
        let evaluation = evaluated(&arm(base), |protocol| protocol.methods = methods.collect());
        for (method, errors) in totals(&evaluation) {
            assert!(errors.all.n > 10_000);
            // The accuracy that is required of rigs.
            let mean_deg = errors.all.angular_mean_deg();
            assert!(mean_deg < 0.1 && mean_deg > 0.0, "{method}: {mean_deg}");
            assert!(errors.all.linear_mean_cm() < 0.05, "{method}");
        }
    }
}

#[test]
fn wrong_masses_are_learnt() {
    let evaluation = evaluated(&arm(DQuat::IDENTITY), |protocol| {
        protocol.methods = vec![MethodName::Recommended];
        protocol.setup.disturbance.masses = 0.15;
    });
    let (_, errors) = totals(&evaluation).next().unwrap();
    assert!(errors.all.angular_mean_deg() < 0.1, "{}", errors.all.angular_mean_deg());
}

#[test]
fn axes_stay_in_their_ranges_and_below_their_limits_and_are_smooth() {
    let mechanism = arm(DQuat::IDENTITY);
    for exercise in make_exercises("arm", &mechanism, &ExerciseSettings::default()).unwrap() {
        let share = if exercise.name.ends_with("20") { 0.2 } else { 0.6 };
        for (link, profiles) in mechanism.bodies.iter().zip(&exercise.profiles) {
            for (index, profile) in profiles.iter().enumerate() {
                let h = exercise.dt_s;
                let at: Vec<f64> = (0..exercise.frames).map(|f| profile.at(f as f64 * h)).collect();
                if let Some([least, most]) = link.ranges.get(index) {
                    assert!(at.iter().all(|at| (*least..=*most).contains(at)), "{}", link.name);
                }
                assert!(
                    at.iter().any(|there| (there - at[0]).abs() > 0.01),
                    "{}: it moves",
                    link.name
                );
                let limit =
                    |limit: f64, without: f64| if limit.is_finite() { limit } else { without };
                let speed = share * limit(link.speed, SPEED[0]);
                let acceleration = share * limit(link.acceleration, ACCELERATION[0]);
                let mut before = 0.0;
                for three in at.windows(3) {
                    assert!((three[1] - three[0]).abs() / h <= speed * (1.0 + 1e-9));
                    let now = (three[0] - 2.0 * three[1] + three[2]) / (h * h);
                    // Rounding of differences of numbers near 1, divided by h².
                    assert!(now.abs() <= acceleration + 1e-9 / h, "{}: {now}", link.name);
                    // The maximum jerk is at the ends, 60 distance / T³. With T as in `duration_s` that is 60 /
                    // 5.77^1.5 times a^1.5 / distance^0.5, here for distances of a degree or more. A jump of
                    // acceleration would not depend on the step.
                    assert!(
                        (now - before).abs() < 0.5 * acceleration,
                        "{}: {before} {now}",
                        link.name
                    );
                    before = now;
                }
            }
        }
    }
}

#[test]
fn the_same_seed_moves_the_same_way() {
    let mechanism = arm(DQuat::IDENTITY);
    let poses = |seed| {
        let settings = ExerciseSettings { seed, ..ExerciseSettings::default() };
        let together = make_exercises("arm", &mechanism, &settings).unwrap().swap_remove(1);
        assert_eq!(together.name(), "together_20");
        let mut poses = Vec::new();
        together.joint_poses(&Setup::default(), 1000, &mut poses);
        poses
    };
    assert_eq!(poses(1), poses(1));
    assert_ne!(poses(1), poses(2));
}

#[test]
fn tables_are_of_the_rig_and_not_beside_the_papers() {
    let evaluation = evaluated(&arm(DQuat::IDENTITY), |_| ());
    let text = report::tables(&evaluation);
    assert!(text.contains("Rig arm: errors divided by Local's"), "{text}");
    assert!(!text.contains("paper") && !text.contains("Table 1"), "{text}");
}

#[test]
fn what_cannot_be_moved_is_refused_in_words() {
    let refused = |mechanism: &Mechanism, settings: &ExerciseSettings| {
        make_exercises("arm", mechanism, settings).unwrap_err().to_string()
    };
    let good = arm(DQuat::IDENTITY);
    for shares in [vec![0.0], vec![0.2, 1.5], vec![f64::NAN]] {
        let message = refused(&good, &ExerciseSettings { shares, ..ExerciseSettings::default() });
        assert!(message.starts_with("shares: expected shares from 0.01 to 1"), "{message}");
    }
    let message =
        refused(&good, &ExerciseSettings { rate_hz: f64::INFINITY, ..ExerciseSettings::default() });
    assert!(message.starts_with("rate_hz"), "{message}");
    let mut bad = good.clone();
    bad.bodies[1].ranges = vec![[0.5, f64::NAN]];
    assert!(refused(&bad, &ExerciseSettings::default()).starts_with("body 1, ranges"));
    let mut bad = good.clone();
    bad.bodies[2].home = vec![];
    assert!(refused(&bad, &ExerciseSettings::default()).starts_with("joint joint_2: expected 1"));
    let mut tied = good.clone();
    tied.bodies.truncate(3);
    tied.linked = vec![between(1, 2, 1.0, [0.0, 0.0]), between(1, 2, -1.0, [0.0, 0.0])];
    assert!(refused(&tied, &ExerciseSettings::default()).contains("no joint that can move"));
    let stiff = Mechanism { bodies: vec![good.bodies[0].clone()], linked: Vec::new() };
    assert!(refused(&stiff, &ExerciseSettings::default()).contains("no joint that can move"));
}

fn between(body: usize, other: usize, factor: f64, range: [f64; 2]) -> LinkedRange {
    LinkedRange { body, other, factor: 1.0, other_factor: factor, range }
}

#[test]
fn a_joint_may_be_tied_to_two() {
    let mut mechanism = arm(DQuat::IDENTITY);
    mechanism.linked = vec![between(1, 2, -1.0, [0.0, 0.0]), between(1, 3, -2.0, [0.0, 0.0])];
    let together =
        make_exercises("arm", &mechanism, &ExerciseSettings::default()).unwrap().swap_remove(1);
    let mut largest: f64 = 0.0;
    for frame in 0..together.frames {
        let at = |body: usize| together.profiles[body][0].at(frame as f64 * together.dt_s);
        assert!((at(1) - at(2)).abs() < 1e-12 && (at(1) - 2.0 * at(3)).abs() < 1e-12);
        largest = largest.max(at(1).abs());
    }
    assert!(largest > 0.3, "they move: {largest}");
}

#[test]
fn limits_that_join_two_joints_hold_all_the_time() {
    let mut mechanism = arm(DQuat::IDENTITY);
    let between = |body, other, factor, range| LinkedRange {
        body,
        other,
        factor: 1.0,
        other_factor: factor,
        range,
    };
    mechanism.linked = vec![
        // The elbow is tied to the turntable at half its angle, and the shoulder to the elbow with the opposite
        // sign.
        between(2, 3, 1.0, [0.1, 0.1]),
        between(3, 1, -0.5, [0.05, 0.05]),
        // The angles of elbow and turntable stay near each other.
        between(3, 1, -1.0, [-0.4, 0.3]),
    ];
    let mut sums = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for exercise in make_exercises("arm", &mechanism, &ExerciseSettings::default()).unwrap() {
        for frame in 0..exercise.frames {
            let at = |body: usize| exercise.profiles[body][0].at(frame as f64 * exercise.dt_s);
            for (one, [least, most]) in mechanism.linked.iter().zip(&mut sums) {
                let sum = at(one.body) * one.factor + at(one.other) * one.other_factor;
                (*least, *most) = (least.min(sum), most.max(sum));
            }
        }
    }
    for (one, [least, most]) in mechanism.linked.iter().zip(sums) {
        assert!(least >= one.range[0] - 1e-12 && most <= one.range[1] + 1e-12, "{least} {most}");
    }
    // The exercise uses the range that remains.
    assert!(sums[2][1] - sums[2][0] > 0.5, "{sums:?}");
}

#[test]
fn friction_that_the_drives_know_costs_no_accuracy() {
    let mut mechanism = arm(DQuat::IDENTITY);
    for link in mechanism.bodies.iter_mut().skip(1) {
        (link.friction, link.damping) = (0.05, 0.1);
    }
    let evaluation = evaluated(&mechanism, |protocol| protocol.methods = vec![MethodName::World]);
    let (_, errors) = totals(&evaluation).next().unwrap();
    assert!(errors.all.angular_mean_deg() < 0.1, "{}", errors.all.angular_mean_deg());
}

#[test]
fn a_rig_without_mass_is_shown_another_way() {
    let mut face = arm(DQuat::IDENTITY);
    for link in &mut face.bodies {
        (link.mass_kg, link.inertia_kg_m2) = (0.0, glam::DMat3::ZERO);
    }
    let message =
        make_exercises("face", &face, &ExerciseSettings::default()).unwrap_err().to_string();
    assert!(message.contains("sinew rig view"), "{message}");
}
