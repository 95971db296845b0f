//! Review of control loops through elastic gears.

use sinew_core::bandwidth::Bandwidth;
use sinew_core::tracker::Settings;

use super::flexible_joint::{ControlLoop, FlexibleJoint};
use super::results::{DofReview, Loop, LoopReview, SoftGear};
use crate::number::single;

/// Factor on the stiffness of a gear. The next constant is the factor on its play. Both give the worst gear with which
/// a loop is judged.
const SOFTER: f64 = 0.5;
const LOOSER: f64 = 2.0;

/// Amplitude of the angle between rotor and output at which the effect of play is judged, in multiples of the play
/// in the gear's data.
///
/// The smaller an oscillation, the softer the gear is for it. A loop that is stable at this amplitude is stable at
/// all larger ones, therefore no oscillation grows beyond it. Play then causes an oscillation of the output of at
/// most this amplitude times the rotor's share of the total inertia, in each direction: 0.5 deg for plastic gears
/// with a load as heavy as the rotor.
const AMPLITUDE_PLAYS: f64 = 2.0;

/// Minimum load that is assumed, as a share of the rotor's inertia: even a bare shaft has some inertia.
const LEAST_LOAD: f64 = 0.01;

/// Lower end of the search for a bandwidth, rad/s. The next constant is the number of bisection steps.
const LEAST_RAD_S: f64 = 1.0;
const HALVINGS: usize = 16;

/// Reviews the loop of each dof that has one. `inertias` contains the minimum and maximum inertia of each dof.
pub(super) fn review(by_dof: &mut [DofReview], inertias: &[[f64; 2]], control: Loop) {
    let dt_s = 1.0 / control.rate_hz;
    for (dof, inertias) in by_dof.iter_mut().zip(inertias) {
        let Some(gear) = dof.servo.as_ref().and_then(|servo| servo.gear) else { continue };
        let joints = inertias.map(|inertia| joint(gear, inertia - dof.rotor_inertia));
        // Invalid gears, such as those of servos without rotor data, have no loop.
        let Some(by_rule) = bandwidth_rad_s(&joints[1], dt_s) else { continue };
        let control = ControlLoop {
            dt_s,
            latency_ticks: control.latency_ticks,
            late_s: 0.0,
            // An observer cannot be faster than the control rate.
            bandwidth_rad_s: control.bandwidth_rad_s.unwrap_or(by_rule).min(control.rate_hz),
            kp_per_s2: f64::from(Settings::<usize>::default().kp),
            torque_share: 1.0,
        };
        dof.control = Some(of_joint(joints, gear, control));
    }
}

fn of_joint(joints: [FlexibleJoint; 2], gear: SoftGear, control: ControlLoop) -> LoopReview {
    let worst = joints.map(|joint| with_worst_gear(joint, gear.play));
    let stability = |joints: &[FlexibleJoint; 2]| {
        let [light, heavy] = joints.each_ref().map(|joint| control.stability(joint));
        light.least(heavy)
    };
    let [of_nominal, of_worst] = [&joints, &worst].map(stability);
    let grows = of_nominal.margins.is_none() || of_worst.margins.is_none();
    let braked = |joint: &FlexibleJoint| FlexibleJoint {
        damping: joint.damping + gear.winding_damping,
        ..*joint
    };
    let all = [joints, worst].concat();
    let decays = |joint: &FlexibleJoint| control.growth_per_s(joint) < 0.0;
    LoopReview {
        resonance_hz: joints[0].resonance_rad_s() / std::f64::consts::TAU,
        load_inertia: joints.map(|joint| joint.load_inertia),
        bandwidth_rad_s: control.bandwidth_rad_s,
        nominal: of_nominal,
        worst: of_worst,
        bearable_rad_s: grows.then(|| bearable_rad_s(&all, control)),
        light_bears: [&joints[0], &worst[0]].into_iter().all(decays),
        voltage_bears: all.iter().map(braked).all(|joint| decays(&joint)),
    }
}

/// Returns the joint with half its gear's stiffness and twice its play, the worst gear with which a loop is judged.
pub(crate) fn with_worst_gear(joint: FlexibleJoint, play: f64) -> FlexibleJoint {
    let softer = joint.softened(SOFTER);
    if play > 0.0 { softer.with_play(LOOSER * 0.5 * play, AMPLITUDE_PLAYS * play) } else { softer }
}

/// Returns the model of a joint with this gear.
fn joint(gear: SoftGear, load_inertia: f64) -> FlexibleJoint {
    let SoftGear { rotor_inertia, stiffness, gear_damping, damping, .. } = gear;
    let load_inertia = load_inertia.max(LEAST_LOAD * rotor_inertia);
    FlexibleJoint { rotor_inertia, load_inertia, stiffness, gear_damping, damping }
}

/// Returns the bandwidth of a joint's observer by the rule of [`Bandwidth::of_loaded_gear`], rad/s; `None` if the
/// rule refuses the gear.
fn bandwidth_rad_s(heaviest: &FlexibleJoint, dt_s: f64) -> Option<f64> {
    let FlexibleJoint { rotor_inertia, load_inertia, stiffness, .. } = *heaviest;
    let [stiffness, rotor, load, dt_s] = [stiffness, rotor_inertia, load_inertia, dt_s].map(single);
    let bandwidth = Bandwidth::of_loaded_gear(stiffness, rotor, load, dt_s).ok()?;
    Some(f64::from(bandwidth.rad_s))
}

/// Returns the largest observer bandwidth that keeps the loop stable and does not exceed the loop's current
/// bandwidth, rad/s; 0 if there is none.
fn bearable_rad_s(joints: &[FlexibleJoint], control: ControlLoop) -> f64 {
    let decays = |bandwidth_rad_s: f64| {
        let control = ControlLoop { bandwidth_rad_s, ..control };
        joints.iter().all(|joint| control.growth_per_s(joint) < 0.0)
    };
    let (mut least, mut most) = (LEAST_RAD_S, control.bandwidth_rad_s);
    if !decays(least) {
        return 0.0;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (least + most);
        if decays(middle) {
            least = middle;
        } else {
            most = middle;
        }
    }
    least
}
