//! The onset of oscillation of a joint on a soft gear: computed from the poles of the linear loop, and simulated with
//! the core's tracker and the simulated gear.

use std::collections::VecDeque;

use glam::Vec3;
use rayon::prelude::*;
use sinew_core::tracker::{
    Differences, Frame, FrameSource, Measured, ObserverChoice, Settings, Timing, Tracker,
};
use sinew_core::{Body, Inertia, JointKind, RotationalInertia, Transform, Tree};
use sinew_rig::review::{ControlLoop, FlexibleJoint};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::{Gear, Parameters};

/// Steps of the simulated gear in a tick: with this number its numerical damping is negligible.
const STEPS: u32 = 30;
/// Windup of the gear by a load, rad, so that its teeth touch. The load is applied at once; this push starts the
/// oscillation.
const WINDUP_RAD: f64 = 1e-3;
/// Initial distance of a joint without a load from its target, rad.
const AWAY_RAD: f64 = 2e-4;
/// A smaller oscillation is noise of f32, rad.
const NOISE_RAD: f64 = 2e-6;
/// A larger oscillation may have reached the largest amplitude that the limits allow, rad.
const LARGE_RAD: f64 = 5e-4;
/// Largest relative difference of the two onsets.
const CLOSE: f64 = 0.15;

#[derive(Debug, Clone, Copy)]
struct Case {
    kind: &'static str,
    /// Inertia of the load, in multiples of the rotor's.
    load: f64,
    /// Remaining shares of the gear's stiffness and damping.
    left: [f64; 2],
    rate_hz: u32,
    latency_ticks: usize,
}

/// Returns thirty cases: kinds, loads, gears, rates and latencies in turn.
fn cases() -> Vec<Case> {
    let kinds = ["XL330-M288-T", "XM430-W350-T", "MX-64", "MX-28"];
    let loads = [1.0, 3.0, 10.0, 0.5, 30.0];
    let left =
        [[1.0, 1.0], [0.5, 1.0], [1.0, 0.33], [0.5, 0.33], [0.2, 0.6], [0.3, 1.0], [0.7, 0.1]];
    let timings =
        [(500, 1), (400, 1), (500, 2), (1000, 2), (333, 1), (1000, 1), (500, 0), (250, 1)];
    (0..30)
        .map(|case| {
            let (rate_hz, latency_ticks) = timings[case % timings.len()];
            Case {
                // Without the second term, the cycles of kinds and timings, with lengths four and eight, would
                // coincide.
                kind: kinds[(case + case / timings.len()) % kinds.len()],
                load: loads[case % loads.len()],
                left: left[case % left.len()],
                rate_hz,
                latency_ticks,
            }
        })
        .collect()
}

/// A target that stands still.
struct Stand([Transform; 1]);

impl FrameSource for Stand {
    fn frame(&mut self, _: i32) -> Frame<'_> {
        Frame::Poses(&self.0)
    }
}

impl Case {
    fn parameters(&self) -> Parameters {
        let kind = Parameters::built_in(self.kind).unwrap();
        let [stiffness, damping] = self.left;
        Parameters {
            friction_nm: 0.0,
            stribeck_nm: 0.0,
            load_friction: 0.0,
            backlash_rad: 0.0,
            gear_stiffness_nm_rad: stiffness * kind.gear_stiffness_nm_rad,
            gear_damping_nm_s: damping * kind.gear_damping_nm_s,
            ..kind
        }
    }

    fn joint(&self) -> FlexibleJoint {
        let kind = self.parameters();
        FlexibleJoint {
            rotor_inertia: kind.rotor_inertia_kg_m2,
            load_inertia: self.load * kind.rotor_inertia_kg_m2,
            stiffness: kind.gear_stiffness_nm_rad,
            gear_damping: kind.gear_damping_nm_s,
            damping: kind.damping_nm_s,
        }
    }

    fn control(&self, bandwidth_rad_s: f64, torque_share: f64) -> ControlLoop {
        ControlLoop {
            dt_s: 1.0 / f64::from(self.rate_hz),
            latency_ticks: self.latency_ticks,
            late_s: 0.0,
            bandwidth_rad_s,
            kp_per_s2: 200.0,
            torque_share,
        }
    }

    /// Returns the bandwidth by the rule, rad/s.
    fn by_rule(&self) -> f64 {
        let joint = self.joint();
        let both = 1.0 + 1.0 / self.load.max(1.0);
        (0.3 * joint.resonance_rad_s() * both.sqrt()).min(150.0)
    }

    /// Returns whether an oscillation grows, with the tracker and the simulated gear. Teeth without a load separate
    /// in each swing and then have no damping: no linear model contains that.
    #[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
    fn swings(&self, bandwidth_rad_s: f64, torque_share: f64, is_loaded: bool) -> bool {
        let joint = self.joint();
        let dt_s = 1.0 / f64::from(self.rate_hz);
        let body = Body {
            parent: None,
            joint: JointKind::Revolute { axis: Vec3::Y },
            placement: Transform::IDENTITY,
            inertia: Inertia {
                mass_kg: 1e-3,
                center_of_mass_m: Vec3::ZERO,
                rotational_kg_m2: RotationalInertia::diagonal(
                    joint.load_inertia as f32,
                    joint.load_inertia as f32,
                    joint.load_inertia as f32,
                ),
            },
            rotor_inertia: joint.rotor_inertia as f32,
        };
        let settings: Settings = Settings {
            observer: ObserverChoice {
                bandwidth_rad_s: bandwidth_rad_s as f32,
                cancel: true,
                predict: true,
            },
            differences: Differences::Aligned,
            implicit: true,
            ..Settings::default()
        };
        let timing = Timing { dt_s: dt_s as f32, latency_ticks: self.latency_ticks };
        let tree = Tree::<1>::from_bodies(&[body]).unwrap();
        let mut tracker = Tracker::<1, 8>::new(tree, &settings, timing).unwrap();
        let mut gear = Gear::new(&self.parameters());
        gear.place(if is_loaded { 0.0 } else { AWAY_RAD });
        let arm = Arm {
            inertia_kg_m2: joint.load_inertia,
            torque_nm: if is_loaded { WINDUP_RAD * joint.stiffness } else { 0.0 },
            ..Arm::default()
        };
        let mut due: VecDeque<f64> = std::iter::repeat_n(0.0, self.latency_ticks).collect();
        let mut stand = Stand([Transform::IDENTITY]);
        let mut largest = [0.0_f64; 3];
        // Three times 0.8 s: in the first part everything except the slowest component decays.
        let span = self.rate_hz * 4 / 5;
        for tick in 0..3 * span {
            let q = [gear.shaft.position_rad as f32];
            let mut efforts_nm = [0.0];
            tracker
                .step(&mut stand, tick.try_into().unwrap(), Measured::Positions { q: &q })
                .unwrap()
                .efforts(&mut efforts_nm)
                .unwrap();
            due.push_back(torque_share * f64::from(efforts_nm[0]));
            let torque_nm = due.pop_front().unwrap();
            let slot = &mut largest[usize::try_from(tick / span).unwrap()];
            for _ in 0..STEPS {
                gear.step_under(dt_s / f64::from(STEPS), torque_nm, &arm);
                *slot = slot.max(gear.shaft.position_rad.abs());
            }
        }
        // A fast oscillation soon reaches the largest amplitude that the observer's limits allow, and then grows no
        // more.
        let is_at_limits = largest[2] > LARGE_RAD && largest[2] > 0.9 * largest[1];
        largest[2] > NOISE_RAD && largest[2] > largest[1] || is_at_limits
    }
}

/// Returns the smallest number from `from` to `to` at which an oscillation grows, or `None` if there is none. The
/// search first goes in steps of a fifth, then refines the result to a percent.
fn onset([from, to]: [f64; 2], grows: impl Fn(f64) -> bool) -> Option<f64> {
    let (mut low, mut high) = (from, from);
    while !grows(high) {
        (low, high) = (high, high * 1.2);
        if high > to {
            return None;
        }
    }
    while high / low > 1.01 {
        let middle = (low * high).sqrt();
        if grows(middle) { high = middle } else { low = middle }
    }
    Some((low * high).sqrt())
}

#[test]
fn a_joint_begins_to_swing_where_its_poles_say() {
    let all = cases();
    let rows: Vec<_> = all
        .par_iter()
        .map(|case| {
            let joint = case.joint();
            let grows = |bandwidth_rad_s, share| {
                case.control(bandwidth_rad_s, share).growth_per_s(&joint) > 0.0
            };
            let rule = case.by_rule();
            // Factors on the torque, at the rule's bandwidth; and bandwidths, up to the tick rate.
            let factors = [1.0, 20.0];
            let bandwidths = [0.5 * rule, f64::from(case.rate_hz)];
            let factor = [
                onset(factors, |share| grows(rule, share)),
                onset(factors, |share| case.swings(rule, share, true)),
                onset(factors, |share| case.swings(rule, share, false)),
            ];
            let bandwidth = [
                onset(bandwidths, |bandwidth| grows(bandwidth, 1.0)),
                onset(bandwidths, |bandwidth| case.swings(bandwidth, 1.0, true)),
                onset(bandwidths, |bandwidth| case.swings(bandwidth, 1.0, false)),
            ];
            (rule, factor, bandwidth)
        })
        .collect();
    println!(
        "| servo | load | gear | Hz | late | rule | factor computed | loaded | not loaded | rad/s computed | loaded | \
         not loaded |"
    );
    println!("|---|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    let text = |onset: &Option<f64>| onset.map_or_else(|| "none".to_owned(), |x| format!("{x:.2}"));
    let mut compared = [0, 0];
    let mut worst = [[0.0_f64; 2]; 2];
    for (case, (rule, factor, bandwidth)) in all.iter().zip(&rows) {
        let Case { kind, load, left, rate_hz, latency_ticks } = case;
        let onsets: Vec<String> = factor.iter().chain(bandwidth).map(text).collect();
        println!(
            "| {kind} | {load} | {left:?} | {rate_hz} | {latency_ticks} | {rule:.0} | {} |",
            onsets.join(" | ")
        );
        for (place, [computed, simulated @ ..]) in [factor, bandwidth].into_iter().enumerate() {
            compared[place] += usize::from(computed.is_some());
            for (worst, simulated) in worst[place].iter_mut().zip(simulated) {
                if let (Some(computed), Some(simulated)) = (computed, simulated) {
                    *worst = worst.max((computed / simulated - 1.0).abs());
                }
            }
        }
    }
    println!(
        "compared {compared:?}, apart by at most {worst:.3?}: factor, bandwidth; loaded, not loaded"
    );
    for (case, (_, factor, bandwidth)) in all.iter().zip(&rows) {
        for [computed, loaded, not_loaded] in [factor, bandwidth] {
            // An onset that only one search finds is beyond the end of the other search.
            assert_eq!(computed.is_some(), loaded.is_some(), "{case:?}");
            if let (Some(computed), Some(loaded)) = (computed, loaded) {
                let apart = (computed / loaded - 1.0).abs();
                assert!(apart < CLOSE, "{case:?}: {computed:.2} computed, {loaded:.2} simulated");
            }
            if let (Some(computed), Some(not_loaded)) = (computed, not_loaded) {
                // Without a load there is less damping: the onset is never later, and at most a third earlier.
                let share = not_loaded / computed;
                assert!((0.67..1.05).contains(&share), "{case:?}: {computed:.2}, {not_loaded:.2}");
            }
        }
    }
    assert_eq!(compared[0], all.len(), "every loop has a margin of gain");
}
