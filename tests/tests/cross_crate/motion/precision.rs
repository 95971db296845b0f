//! The error of f32: the core's inverse dynamics compared with f64, over ten thousand random states of each kind of
//! rig, up to 64 bodies in a row.

use proptest::prelude::*;
use sinew_core::dynamics::inverse_dynamics;
use sinew_core::glam::Vec3;
use sinew_core::{Twist, Wrench, dynamics::BodyMotion};
use sinew_test_support::newton_euler;
use sinew_test_support::property;
use sinew_test_support::reference;
use sinew_test_support::rig::{Joints, Rig, Shape, build, rigs};

const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// Number of states of each kind.
const STATES: usize = 10_000;

/// Largest error of a torque, relative to the largest torque of its state.
const MOST: f64 = 1e-5;

/// Largest error at impossible speeds: 64 joints that all turn one way at 20 rad/s, or slide on each other at 20 m/s,
/// so that the outer ones move at 1000 rad/s and more. A rounding error at the root then has the lever of all of
/// them.
const MOST_OF_NO_MACHINE: f64 = 2e-5;

/// Numbers from -1 to 1, the same in every run (Steele, Lea & Flood's `SplitMix64`, 2014).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn number(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 8_388_608.0 - 1.0
    }

    #[expect(clippy::cast_possible_truncation, reason = "random bits")]
    fn rig(&mut self, shape: Shape, joints: Joints, count: usize) -> Rig {
        let body = |random: &mut Self| {
            let pick = random.bits() as u16;
            let kind = (random.bits() % 6) as usize;
            (pick, kind, (0..48).map(|_| random.number()).collect())
        };
        let bodies: Vec<_> = (0..count).map(|_| body(self)).collect();
        build(shape, joints, &bodies)
    }
}

/// Choice of the speeds of a state.
#[derive(Debug, Clone, Copy)]
enum Speeds {
    /// Independent speeds of the joints, up to 3 rad/s about each axis.
    Own,
    /// Independent speeds up to 20 rad/s, as in a punch, and accelerations up to 500 rad/s².
    Fast,
    /// All joints turn one way, up to 20 rad/s each, so that the speeds add up from body to body.
    Whip,
}

impl Speeds {
    fn set(self, rig: &mut Rig) {
        let first = rig.motions[0].speed;
        for motion in &mut rig.motions {
            let factor = match self {
                Self::Own => continue,
                Self::Fast | Self::Whip => 20.0 / 3.0,
            };
            let speed = if matches!(self, Self::Whip) { first } else { motion.speed };
            motion.speed = speed.map(|speed| speed * factor);
            motion.acceleration = motion.acceleration.map(|a| a * 25.0);
        }
    }
}

fn in_f32(rig: &Rig, accelerations: &[Twist]) -> Vec<Wrench> {
    let mut scratch = vec![BodyMotion::default(); rig.tree.len()];
    let mut out = vec![Wrench::ZERO; rig.tree.len()];
    let (bodies, states) = (rig.tree.bodies(), rig.states());
    let joints = states.as_slice();
    inverse_dynamics(bodies, joints, accelerations, GRAVITY, &[], &mut scratch, &mut out);
    out
}

/// Returns the largest error of a joint's moment and of its force, relative to the largest value of the state.
fn error(rig: &Rig) -> f64 {
    let accelerations = rig.accelerations();
    let got = in_f32(rig, &accelerations);
    let (bodies, states) = (rig.tree.bodies(), rig.states());
    let gravity = GRAVITY.as_dvec3();
    let expected =
        newton_euler::inverse_dynamics(bodies, states.as_slice(), &accelerations, gravity);
    let (mut off, mut largest) = ([0.0f64; 2], [f64::MIN_POSITIVE; 2]);
    for (got, expected) in got.iter().zip(&expected) {
        let pairs = [(got.moment_nm, expected.moment_nm), (got.force_n, expected.force_n)];
        for (part, (got, expected)) in pairs.into_iter().enumerate() {
            off[part] = off[part].max((got.as_dvec3() - expected).length());
            largest[part] = largest[part].max(expected.length());
        }
    }
    f64::max(off[0] / largest[0], off[1] / largest[1])
}

#[test]
fn f32_is_within_1e_5_of_the_largest_torque() {
    use Joints::{Figure, Mixed};
    use Shape::{Chain, Random as Any, Star};
    let kinds = [
        ("figure, 18 bodies", Any, Figure, 18, Speeds::Own, MOST),
        ("figure, 18 bodies, fast", Any, Figure, 18, Speeds::Fast, MOST),
        ("any tree, 32 bodies", Any, Mixed, 32, Speeds::Own, MOST),
        ("any tree, 64 bodies, fast", Any, Mixed, 64, Speeds::Fast, MOST),
        ("star, 64 bodies, fast", Star, Mixed, 64, Speeds::Fast, MOST),
        ("chain, 64 balls", Chain, Figure, 64, Speeds::Own, MOST),
        ("chain, 64 balls, fast", Chain, Figure, 64, Speeds::Fast, MOST),
        ("chain, 64 of any joint", Chain, Mixed, 64, Speeds::Own, MOST),
        ("chain, 64 of any joint, fast", Chain, Mixed, 64, Speeds::Fast, MOST_OF_NO_MACHINE),
        ("chain, 64 balls, whip", Chain, Figure, 64, Speeds::Whip, MOST_OF_NO_MACHINE),
    ];
    println!("{:30} {:>9} {:>9}", "relative error of f32", "median", "worst");
    let mut over = Vec::new();
    for (name, shape, joints, count, speeds, most) in kinds {
        let mut random = Random(20_261_121);
        let mut errors: Vec<f64> = (0..STATES)
            .map(|_| {
                let mut rig = random.rig(shape, joints, count);
                speeds.set(&mut rig);
                error(&rig)
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        let (median, worst) = (errors[STATES / 2], errors[STATES - 1]);
        println!("{name:30} {median:9.1e} {worst:9.1e}");
        if worst > most {
            over.push(name);
        }
    }
    assert!(over.is_empty(), "beyond the limit: {over:?}");
}

proptest! {
    #![proptest_config(property(100))]

    /// The f64 reference agrees with results that are derived only from poses.
    #[test]
    fn f64_is_what_newton_and_euler_ask(rig in rigs(24, Joints::Mixed)) {
        let (bodies, states) = (rig.tree.bodies(), rig.states());
        let accelerations = rig.accelerations();
        let gravity = GRAVITY.as_dvec3();
        let got = newton_euler::inverse_dynamics(bodies, states.as_slice(), &accelerations, gravity);
        let poses = reference::poses(&rig, 0.0);
        let expected = reference::joint_wrenches(&rig, gravity);
        let largest = expected.iter().map(|w| w.moment_nm.length().max(w.force_n.length()));
        let largest = largest.fold(1.0, f64::max);
        for ((got, expected), pose) in got.iter().zip(&expected).zip(&poses) {
            let moment = (pose.rotation * got.moment_nm - expected.moment_nm).length();
            let force = (pose.rotation * got.force_n - expected.force_n).length();
            // The states are the coordinates rounded to f32: a few roundings of 6e-8 for each of up to 24 joints.
            prop_assert!(moment.max(force) < 2e-6 * largest, "{moment} {force} of {largest}");
        }
    }
}
