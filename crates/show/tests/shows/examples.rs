//! Random smooth motions of any joints, and shows of them.

#![expect(clippy::cast_possible_truncation, reason = "small numbers")]

use proptest::prelude::*;
use sinew_show::write::{Motion, Settings, Written, write};
use sinew_show::{Joint, Rate};

/// A motion: joints, and their coordinates by sample.
#[derive(Clone)]
pub(crate) struct Example {
    pub(crate) joints: Vec<Joint>,
    pub(crate) samples: usize,
    pub(crate) rate: Rate,
    pub(crate) is_loop: bool,
    pub(crate) q: Vec<f64>,
    pub(crate) seed: u64,
}

impl std::fmt::Debug for Example {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { joints, samples, rate, is_loop, seed, .. } = self;
        write!(f, "example(vec!{joints:?}, {samples}, {rate:?}, {is_loop}, {seed})")
    }
}

impl Example {
    pub(crate) fn nq(&self) -> usize {
        self.joints.iter().map(|joint| joint.coordinate_count()).sum()
    }

    pub(crate) fn motion(&self) -> Motion<'_> {
        Motion {
            joints: &self.joints,
            q: &self.q,
            rate: self.rate,
            is_loop: self.is_loop,
            rig: 0x1234_abcd,
            cues: &[],
            time_code: None,
            course: &[],
        }
    }

    pub(crate) fn write(&self, settings: &Settings) -> Written {
        write(&self.motion(), settings).expect("a motion that can be")
    }
}

/// Returns a sum of sines; in a loop, whole numbers of periods.
fn wave(seed: u64, sample: f64, samples: usize, rate_hz: f64, is_loop: bool) -> f64 {
    let share = |k: u64| {
        let mixed =
            (seed ^ k.wrapping_mul(0x9e37_79b9_7f4a_7c15)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((mixed ^ (mixed >> 29)).wrapping_mul(0x94d0_49bb_1331_11eb) >> 11) as f64
            / (1u64 << 53) as f64
    };
    (0..4)
        .map(|k| {
            let mut hz = 0.1 + 3.0 * share(3 * k);
            if is_loop {
                let period_s = samples as f64 / rate_hz;
                hz = (hz * period_s).round() / period_s;
            }
            let phase = share(3 * k + 1) + hz * sample / rate_hz;
            (share(3 * k + 2) - 0.5) * (phase * std::f64::consts::TAU).sin()
        })
        .sum()
}

/// Returns the motion of these joints for a seed.
pub(crate) fn example(
    joints: Vec<Joint>,
    samples: usize,
    rate: Rate,
    is_loop: bool,
    seed: u64,
) -> Example {
    let rate_hz = f64::from(rate.samples) / f64::from(rate.seconds);
    let mut q = Vec::new();
    for sample in 0..samples {
        for (index, joint) in joints.iter().enumerate() {
            let at = |k: u64| {
                wave(seed + 31 * index as u64 + 7 * k, sample as f64, samples, rate_hz, is_loop)
            };
            if joint.turns_freely() {
                // A few turns about a swaying axis.
                let turns = if is_loop { f64::from(index as u32 % 3) / 2.0 } else { 0.9 };
                let half = std::f64::consts::TAU * turns * sample as f64 / samples as f64;
                let spin = [0.0, 0.0, half.sin(), half.cos()];
                let sway = [at(0) * 0.5, at(1) * 0.5, at(2) * 0.5, 1.0];
                let length = sway.iter().map(|x| x * x).sum::<f64>().sqrt();
                let [x, y, z, w] = sway.map(|x| x / length);
                let [a, b, c, d] = spin;
                q.extend([
                    w * a + x * d + y * c - z * b,
                    w * b - x * c + y * d + z * a,
                    w * c + x * b - y * a + z * d,
                    w * d - x * a - y * b - z * c,
                ]);
                if *joint == Joint::Free {
                    q.extend([at(3), at(4), at(5)]);
                }
            } else {
                q.extend((0..joint.coordinate_count() as u64).map(at));
            }
        }
    }
    Example { joints, samples, rate, is_loop, q, seed }
}

/// Generates any motion of at most `most` coordinates.
pub(crate) fn any_example(most: usize) -> impl Strategy<Value = Example> {
    let joint = prop_oneof![
        Just(Joint::Fixed),
        Just(Joint::Revolute),
        Just(Joint::Prismatic),
        Just(Joint::Universal),
        Just(Joint::Spherical),
        Just(Joint::Free),
    ];
    let rate = prop_oneof![
        Just(Rate { samples: 30, seconds: 1 }),
        Just(Rate { samples: 120, seconds: 1 }),
        Just(Rate { samples: 60_000, seconds: 1001 }),
    ];
    (prop::collection::vec(joint, 1..12), rate, 8usize..700, any::<bool>(), any::<u32>()).prop_map(
        move |(mut joints, rate, samples, is_loop, seed)| {
            let count =
                |joints: &[Joint]| -> usize { joints.iter().map(|j| j.coordinate_count()).sum() };
            while count(&joints) > most {
                joints.pop();
            }
            if count(&joints) == 0 {
                joints.push(Joint::Revolute);
            }
            // With an even seed the example has exactly the maximum number of coordinates.
            while seed.is_multiple_of(2) && count(&joints) < most {
                joints.push(Joint::Revolute);
            }
            example(joints, samples, rate, is_loop, u64::from(seed))
        },
    )
}

/// Returns the angle between two rotations, rad.
pub(crate) fn angle_between(a: &[f32], b: &[f64]) -> f64 {
    let length = a.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
    let a: Vec<f64> = a.iter().map(|x| f64::from(*x) / length).collect();
    let along: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let apart: f64 =
        a.iter().zip(b).map(|(a, b)| (a - along.signum() * b).powi(2)).sum::<f64>().sqrt();
    4.0 * (apart / 2.0).min(1.0).asin()
}
