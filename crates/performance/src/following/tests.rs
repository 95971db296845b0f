use sinew_firmware::supervisor::Fault;
use sinew_retarget::feasibility::{Kind, Limits, Report, RigMotion, check};
use sinew_rig::description::Supply;
use sinew_rig::new::arm;
use sinew_rig::review::{Loop, Servos, Severity};
use sinew_rig::{Description, Mechanism};
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_show::write::Settings;

use super::*;
use crate::play::{Director, Drive, Ended, Memory, Options, RigParts, SimulatedRig};
use crate::rig::{LoadedRig, review};
use crate::{
    Baker, CHECK_HZ, MotionChoices, RetargetedClip, RigPerformance, ShowChoices, ShowMarks,
    ShowPlayback, rig_hash,
};

/// Returns the starter arm of three joints on STS3215, which are always driven by position, without limits of its own
/// for speed and acceleration.
fn arm_by_position() -> (Description, Mechanism) {
    let mut rig = arm(3).unwrap();
    for servo in &mut rig.servos {
        "STS3215-7.4V".clone_into(&mut servo.model);
    }
    for joint in &mut rig.joints {
        (joint.speed_rad_s, joint.acceleration_rad_s2) = (None, None);
    }
    let mechanism = rig.mechanism().unwrap();
    (rig, mechanism)
}

/// A show and its check.
struct Checked {
    show: Vec<u8>,
    report: Report,
}

/// Bakes a show of [`turning`].
fn turn(rig: &Description, mechanism: &Mechanism, speed_rad_s: f64) -> Checked {
    checked(rig, mechanism, &turning(mechanism, speed_rad_s))
}

/// Returns a motion in which the first joint turns from -2 to 2 rad with at most a speed, after a second at rest. It
/// accelerates evenly for 0.2 s.
fn turning(mechanism: &Mechanism, speed_rad_s: f64) -> RigMotion {
    const DT_S: f64 = 0.01;
    let (mut at, mut speed) = (-2.0_f64, 0.0_f64);
    let change = speed_rad_s / 0.2 * DT_S;
    let mut rows = Vec::new();
    for row in 0..600 {
        let mut q = mechanism.home();
        q[0] = at;
        rows.push(q);
        if row >= 100 {
            // Brakes in time.
            let brakes = (2.0 * change / DT_S * (2.0 - at).max(0.0)).sqrt();
            speed = (speed + change).min(speed_rad_s).min(brakes);
            at = (at + speed * DT_S).min(2.0);
        }
    }
    RigMotion { dt_s: DT_S, rows }
}

fn checked(rig: &Description, mechanism: &Mechanism, motion: &RigMotion) -> Checked {
    let (rig_crc, _) = rig_hash(rig, mechanism);
    let baker = Baker { mechanism, rig: rig_crc, settings: Settings::default() };
    let show = baker.bake(motion, &ShowMarks::default()).unwrap().written.bytes;
    let limits = Limits::of(mechanism, &Servos::of(rig, mechanism).unwrap());
    let played = ShowPlayback::new(&show).unwrap();
    let report = check(mechanism, &limits, &played, CHECK_HZ).unwrap();
    Checked { show, report }
}

fn prepared(rig: &Description, mechanism: &Mechanism, options: Options) -> Option<FollowingCheck> {
    let (rig_crc, _) = rig_hash(rig, mechanism);
    FollowingCheck::new(rig, mechanism, options, rig_crc).unwrap()
}

/// Returns whether the supervisor ends a show with a following error, on the simulated rig with all its faults.
fn faults(rig: &Description, mechanism: &Mechanism, show: &[u8]) -> bool {
    let parts = RigParts::new(rig, mechanism, Options::default()).unwrap();
    let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
    let plant = parts.plant(rig, mechanism).unwrap();
    let mut sim = SimulatedRig::new(&parts, Some(show), &mut memories, plant).unwrap();
    let mut director = Director::default();
    let ended = (0..60 * parts.rate_hz).find_map(|_| director.tick(&mut sim, false));
    match ended.expect("it ends") {
        Ended::Done => false,
        Ended::Faults(faults) => faults.contains(Fault::FollowingError),
        other => panic!("{other:?}"),
    }
}

/// Halving finds the speed from which a turn ends in a following error. At the lower of two speeds that differ by 0.5 %
/// the prediction and the supervisor both find nothing, at the higher one both find the fault. The speed of the linear
/// model is that of a motion that lasts, so it is below that of this turn of a second.
#[test]
fn the_prediction_is_true_on_both_sides_of_the_limit() {
    let (rig, mechanism) = arm_by_position();
    let prepared = prepared(&rig, &mechanism, Options::default()).unwrap();
    let predicted = |speed_rad_s: f64| {
        let Checked { show, report } = turn(&rig, &mechanism, speed_rad_s);
        let predicted = prepared.of(&show, &report, Allowance::Supervisor).unwrap();
        assert_eq!(predicted.stopped, None);
        assert!(predicted.excesses.iter().all(|excess| excess.kind == Kind::Following));
        (show, predicted)
    };
    let is_found = |speed_rad_s| !predicted(speed_rad_s).1.excesses.is_empty();
    let [mut low, mut high] = [2.0_f64, 8.0];
    assert!(!is_found(low) && is_found(high));
    while high > 1.005 * low {
        let middle = 0.5 * (low + high);
        if is_found(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    let ((slow, _), (fast, found)) = (predicted(low), predicted(high));
    assert!(!faults(&rig, &mechanism, &slow), "{low}");
    assert!(faults(&rig, &mechanism, &fast), "{high}");
    let excess = &found.excesses[0];
    assert_eq!(excess.dof, 0);
    assert!(excess.value > excess.limit && excess.to_s - excess.from_s >= 0.19, "{excess:?}");

    let speeds = followed(rig, mechanism);
    let most = speeds[0].most;
    println!("limit {low:.3} to {high:.3} rad/s, by the model {most:.3} rad/s");
    assert!((0.7 * high..high).contains(&most), "{most} {high}");
}

fn loaded(description: Description, mechanism: Mechanism) -> LoadedRig {
    let (world, notes, doubts) = (None, Vec::new(), Vec::new());
    LoadedRig { description, mechanism, world, notes, doubts }
}

fn followed(description: Description, mechanism: Mechanism) -> Vec<FollowedSpeed> {
    let loaded = loaded(description, mechanism);
    let control = Loop { rate_hz: 500.0, latency_ticks: 1, bandwidth_rad_s: None };
    let review = review(&loaded, control).unwrap();
    FollowedSpeed::each(&loaded, &review, Options::default()).unwrap()
}

/// Bakes a show in which the first joint swings at a frequency. The swing grows and fades over a second.
fn swing(rig: &Description, mechanism: &Mechanism, amplitude: f64, rad_s: f64) -> Checked {
    const DT_S: f64 = 0.01;
    let row = |row: u32| {
        let time_s = f64::from(row) * DT_S;
        let fade = (time_s.min(5.0 - time_s)).clamp(0.0, 1.0);
        let mut q = mechanism.home();
        q[0] += amplitude * fade * fade * (3.0 - 2.0 * fade) * (rad_s * time_s).sin();
        q
    };
    checked(rig, mechanism, &RigMotion { dt_s: DT_S, rows: (0..=500).map(row).collect() })
}

/// A show whose servos have a bound is not played. The error of a play is below the bound, also if the joint swings at
/// the frequency of its servo's loop.
#[test]
fn a_play_stays_within_the_bound() {
    let (rig, mechanism) = arm_by_position();
    let prepared = prepared(&rig, &mechanism, Options::default()).unwrap();
    let parts = RigParts::new(&rig, &mechanism, Options::default()).unwrap();
    let lag = servo_lags(&parts).unwrap()[0];
    let rotor = parts.servos[0].own.kind.rotor_inertia_kg_m2;
    let own_rad_s = (lag.stiffness / (rotor + parts.load_inertias_kg_m2[0])).sqrt();
    let turns = [0.3, 0.8, 1.6].map(|speed_rad_s| turn(&rig, &mechanism, speed_rad_s));
    let swings = [0.005, 0.02].map(|amplitude| swing(&rig, &mechanism, amplitude, own_rad_s));
    let bound = |shows: &[Checked]| {
        let mut bounds = 0;
        for Checked { show, report } in shows {
            let Some(bound) = prepared.bound(report) else { continue };
            bounds += 1;
            let limit = sinew_firmware::supervisor::detect::FollowingSettings::default();
            let played = prepared.played(show, limit).unwrap();
            let [played, bound] = [played.largest.error, bound.error].map(f64::to_degrees);
            println!("{own_rad_s:.1} rad/s: {played:.2} deg, bound {bound:.2} deg");
            assert!(played <= bound, "{played} {bound}");
        }
        bounds
    };
    assert!(bound(&turns) > 0 && bound(&swings) > 0);
}

/// The worst load changes its sign with each half swing of the loop. It nearly reaches the peak gain: 40 half swings
/// with a damping of 0.05 leave `e^-6.3` of the sum, steps of a ten-thousandth of a swing change less.
#[test]
fn a_load_in_time_with_the_loop_reaches_the_peak_gain() {
    for damping_ratio in [0.05_f64, 0.25, 0.7] {
        // A loop with the frequency 1 rad/s and the stiffness 1.
        let half_s = std::f64::consts::PI / (1.0 - damping_ratio * damping_ratio).sqrt();
        let (steps, half_swings) = (5000, 40);
        let dt_s = half_s / f64::from(steps);
        let (mut error, mut speed, mut largest) = (0.0_f64, 0.0_f64, 0.0_f64);
        for step in 0..half_swings * steps {
            let load = if step / steps % 2 == 0 { 1.0 } else { -1.0 };
            speed += dt_s * (load - 2.0 * damping_ratio * speed - error);
            error += dt_s * speed;
            largest = largest.max(error.abs());
        }
        let gain = lag::peak_gain(damping_ratio);
        println!("damping {damping_ratio}: {largest:.3} of {gain:.3}");
        assert!((0.99 * gain..1.001 * gain).contains(&largest), "{largest} {gain}");
    }
    assert!((lag::peak_gain(0.25) - 2.6).abs() < 0.01);
    assert!(lag::peak_gain(0.0).is_infinite() && lag::peak_gain(f64::INFINITY) < 1.0 + 1e-9);
}

/// Nothing is known about a fitted show after the simulated rig stops. A supply of 4.1 V is below the 4.2 V at which
/// the supervisor faults, so the rig cannot be armed.
#[test]
fn a_fit_that_stops_the_simulated_rig_is_refused() {
    let fitted = |voltage_v| {
        let (mut description, mechanism) = arm_by_position();
        description.supply = Some(Supply { voltage_v, current_a: 20.0 });
        let clip = RetargetedClip::own(turning(&mechanism, 2.8));
        let rig = loaded(description, mechanism);
        let choices = MotionChoices { fit: true, ..MotionChoices::default() };
        let mut performance = RigPerformance::new(&rig, "turn", 0.0, clip, choices).unwrap();
        performance.bake(&rig.mechanism, &ShowChoices::default()).map(|_| performance.predicted)
    };
    let whole = fitted(7.4).unwrap().unwrap();
    assert!(whole.stopped.is_none() && whole.largest.at_s.is_some(), "{whole:?}");
    let told = format!("{:#}", fitted(4.1).unwrap_err());
    assert!(
        told.ends_with("does not play to its end on the simulated rig: the rig cannot be armed"),
        "{told}"
    );
}

/// An error that is not a number is no excess, and is named by its dof.
#[test]
fn an_error_that_is_not_finite_is_no_excess() {
    let limit =
        sinew_firmware::supervisor::detect::FollowingSettings { most_rad: 0.2, time_s: 0.0 };
    for lost in [f32::NAN, f32::INFINITY] {
        let mut detectors = prediction::Detectors::new(limit, 0.002, [3, 5].into_iter()).unwrap();
        assert_eq!(detectors.note(0.0, |_| 0.1), None);
        assert_eq!(detectors.note(0.002, |dof| if dof == 5 { lost } else { 1.0 }), Some(5));
        let (largest, excesses) = detectors.result();
        assert!(excesses.is_empty() && largest.dof == 5 && largest.error < 0.11, "{largest:?}");
    }
}

#[test]
fn only_servos_that_close_their_own_loop_are_predicted() {
    let rig = arm(3).unwrap();
    let mechanism = rig.mechanism().unwrap();
    assert!(prepared(&rig, &mechanism, Options::default()).is_none());
    let by_position = Options { drive: Some(Drive::Position), ..Options::default() };
    assert!(prepared(&rig, &mechanism, by_position).is_some());
    // Servos on pulses report nothing: no supervisor sees their error.
    let face = sinew_rig::new::face();
    assert!(prepared(&face, &face.mechanism().unwrap(), Options::default()).is_none());
}

/// Links of 5 kg each ask for more than the servos have.
#[test]
fn an_arm_that_its_servos_do_not_carry_is_named() {
    let (light, mechanism) = arm_by_position();
    assert!(followed(light.clone(), mechanism).iter().all(|speed| speed.finding().is_none()));
    let mut heavy = light;
    for body in &mut heavy.bodies[1..] {
        body.mass_kg *= 200.0;
    }
    let mechanism = heavy.mechanism().unwrap();
    let speeds = followed(heavy, mechanism);
    let bend = &speeds[1];
    let finding = bend.finding().unwrap();
    assert!(bend.most < 1e-9 && finding.about == "joint bend2", "{bend:?}");
    assert!(finding.severity <= Severity::Warning && finding.text.contains("sags by more than 15"));
}
