use std::collections::VecDeque;

use proptest::prelude::*;

use super::*;

/// The XL330 of the starter arm, with a load inertia equal to that of its rotor.
fn small() -> FlexibleJoint {
    FlexibleJoint {
        rotor_inertia: 0.00181,
        load_inertia: 0.00181,
        stiffness: 29.7,
        gear_damping: 0.0328,
        damping: 0.0037,
    }
}

fn control(bandwidth_rad_s: f64) -> ControlLoop {
    ControlLoop {
        dt_s: 0.002,
        latency_ticks: 1,
        late_s: 0.0,
        bandwidth_rad_s,
        kp_per_s2: 200.0,
        torque_share: 1.0,
    }
}

/// Simulates the loop: commands wait in a queue, and the joint is integrated in small steps of fourth order.
/// Returns the growth rate of a disturbance, 1/s, from the largest angles of two time spans.
fn simulated_growth_per_s(joint: &FlexibleJoint, control: &ControlLoop) -> f64 {
    let dt_s = control.dt_s;
    let span = 400;
    let root = control.kp_per_s2.sqrt();
    let soft = 1.0 + 2.0 * root * dt_s + control.kp_per_s2 * dt_s * dt_s;
    let kp = control.kp_per_s2 / soft;
    let kd = (2.0 * root + control.kp_per_s2 * dt_s) / soft;
    let decay = (-control.bandwidth_rad_s * dt_s).exp();
    let (mut x, mut v, mut d) = (0.0_f64, 0.0, 0.0);
    let delay_s = control.latency_ticks as f64 * dt_s + control.late_s;
    // Pairs of start time and torque, the next one first.
    let mut due = VecDeque::from([(f64::NEG_INFINITY, 0.0)]);
    let mut sent: VecDeque<f64> = std::iter::repeat_n(0.0, control.latency_ticks + 1).collect();
    let mut state = [1e-3, 0.0, 1e-3, 0.0];
    let acceleration = |[angle, speed, rotor, rotor_speed]: [f64; 4], torque: f64| {
        let gear = joint.stiffness * (rotor - angle) + joint.gear_damping * (rotor_speed - speed);
        let rubs = joint.damping * rotor_speed;
        [
            speed,
            gear / joint.load_inertia,
            rotor_speed,
            (torque - gear - rubs) / joint.rotor_inertia,
        ]
    };
    let mut largest = [0.0_f64; 3];
    for tick in 0..3 * span {
        let off = state[0] - (x + (v + (sent[0] + d) * dt_s) * dt_s);
        v += (sent[0] + d) * dt_s;
        x += v * dt_s + (1.0 - decay.powi(3)) * off;
        v += (1.0 - decay).powi(2) * (1.0 + 2.0 * decay) / dt_s * off;
        d += (1.0 - decay).powi(3) / dt_s.powi(2) * off;
        let (mut ahead, mut speed) = (x, v);
        for asked in sent.iter().skip(1) {
            speed += (asked + d) * dt_s;
            ahead += speed * dt_s;
        }
        let asked = -kp * ahead - kd * speed - d;
        sent.pop_front();
        sent.push_back(asked);
        due.push_back((
            tick as f64 * dt_s + delay_s,
            asked * joint.inertia() * control.torque_share,
        ));
        let steps = 100;
        let h = dt_s / f64::from(steps);
        for step in 0..steps {
            let middle_s = tick as f64 * dt_s + (f64::from(step) + 0.5) * h;
            while due.get(1).is_some_and(|(from_s, _)| *from_s <= middle_s) {
                due.pop_front();
            }
            let torque = due[0].1;
            let at = |k: &[f64; 4], by: f64| std::array::from_fn(|i| state[i] + by * k[i]);
            let a = acceleration(state, torque);
            let b = acceleration(at(&a, 0.5 * h), torque);
            let c = acceleration(at(&b, 0.5 * h), torque);
            let e = acceleration(at(&c, h), torque);
            for (i, x) in state.iter_mut().enumerate() {
                *x += h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + e[i]);
            }
        }
        largest[tick / span] = largest[tick / span].max(state[0].abs());
    }
    (largest[2] / largest[1]).ln() / (span as f64 * dt_s)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn poles_say_what_the_loop_does(
        rotor_inertia in 0.001..0.02_f64,
        load in 0.3..20.0_f64,
        resonance in 60.0..450.0_f64,
        ratio in 0.02..0.4_f64,
        friction in 0.0..3.0_f64,
        bandwidth in 10.0..200.0_f64,
        (dt_s, latency_ticks, late) in (0.001..0.004_f64, 0..4_usize, 0.0..1.5_f64),
        kp_per_s2 in 50.0..400.0_f64,
        torque_share in 0.5..1.5_f64,
    ) {
        let stiffness = rotor_inertia * resonance * resonance;
        let joint = FlexibleJoint {
            rotor_inertia,
            load_inertia: load * rotor_inertia,
            stiffness,
            gear_damping: 2.0 * ratio * (stiffness * rotor_inertia).sqrt(),
            damping: friction * rotor_inertia,
        };
        let control = ControlLoop {
            dt_s,
            latency_ticks,
            late_s: late * dt_s,
            bandwidth_rad_s: bandwidth.min(1.0 / dt_s),
            kp_per_s2,
            torque_share,
        };
        let growth = control.growth_per_s(&joint);
        let simulated = simulated_growth_per_s(&joint, &control);
        // A growth too slow for the simulated time cannot be distinguished.
        prop_assume!(growth.abs() > 1.0);
        prop_assert_eq!(growth > 0.0, simulated > 0.0, "{} by poles, {} simulated", growth, simulated);
        if growth > 0.0 {
            prop_assert!((growth - simulated).abs() < 0.1 * growth + 1.0, "{growth} {simulated}");
        }
    }

    /// At the limit of each margin a pole is on the unit circle: 1 % inside the margin, the loop is stable; 1 %
    /// outside, an oscillation grows.
    #[test]
    fn a_margin_that_is_used_up_leaves_a_swing(
        load in 0.5..20.0_f64,
        share in 0.4..4.0_f64,
        ratio in 0.03..0.4_f64,
        bandwidth in 10.0..120.0_f64,
        (dt_s, latency_ticks) in (0.001..0.004_f64, 0..3_usize),
    ) {
        let small = small();
        let stiffness = small.stiffness * share;
        let joint = FlexibleJoint {
            load_inertia: load * small.rotor_inertia,
            stiffness,
            gear_damping: 2.0 * ratio * (stiffness * small.rotor_inertia).sqrt(),
            ..small
        };
        let control = ControlLoop { dt_s, latency_ticks, ..control(bandwidth) };
        let stability = control.stability(&joint);
        let Some(margins) = stability.margins else {
            return Err(TestCaseError::reject("it has no margin"));
        };
        let grows = |control: ControlLoop| control.growth_per_s(&joint) > 0.0;
        for factor in [margins.gain, margins.gain_down].into_iter().flatten() {
            let with = |beyond: f64| {
                let torque_share = 1.0 + (factor - 1.0) * beyond;
                grows(ControlLoop { torque_share, ..control })
            };
            prop_assert!(!with(0.99) && with(1.01), "{margins:?}");
        }
        if let Some(delay_s) = margins.delay_s {
            let with = |beyond: f64| grows(ControlLoop { late_s: delay_s * beyond, ..control });
            prop_assert!(!with(0.99) && with(1.01), "{margins:?}");
        }
        prop_assert!((0.0..=180.0).contains(&margins.phase_deg), "{margins:?}");
    }
}

/// A load of 20 times the rotor's inertia: the loop is unstable with an observer bandwidth of 100 rad/s, and stable
/// with the bandwidth of the rule. Without play and at full stiffness, the gain margin is a factor of two.
#[test]
fn less_bandwidth_calms_a_soft_gear() {
    let joint = FlexibleJoint { load_inertia: 20.0 * small().rotor_inertia, ..small() };
    assert!(control(100.0).growth_per_s(&joint) > 0.0);
    let margins = control(0.3 * joint.resonance_rad_s()).stability(&joint).margins.unwrap();
    assert!(margins.phase_deg > 30.0 && margins.gain.unwrap() > 2.0, "{margins:?}");
    assert!(margins.gain_down.unwrap() < 0.5 && margins.delay_s.unwrap() > 0.015, "{margins:?}");
}

#[test]
fn play_softens_by_what_of_the_swing_it_takes() {
    let joint = small();
    let softened = |half_play: f64| joint.with_play(half_play, 1.0).stiffness / joint.stiffness;
    assert!((softened(0.0) - 1.0).abs() < 1e-12);
    assert!(softened(1.0).abs() < 1e-12 && softened(3.0).abs() < 1e-12);
    // Numerical integral of the torque's fundamental over a period.
    let (steps, half_play) = (100_000, 0.3);
    let sum: f64 = (0..steps)
        .map(|step| {
            let sin = (std::f64::consts::TAU * (f64::from(step) + 0.5) / f64::from(steps)).sin();
            (sin - sin.clamp(-half_play, half_play)) * sin
        })
        .sum();
    assert!((softened(half_play) - 2.0 * sum / f64::from(steps)).abs() < 1e-6);
}
