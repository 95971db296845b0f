//! A motion of 20 servos like a performer's. It is always the same, so that the cost of decoding its show can be
//! compared. Its show has as many bytes per second as a show of recorded fights (`docs/show-format.md`): 355.

use std::f64::consts::TAU;

use sinew_show::write::Motion;
use sinew_show::{Joint, Rate};

const JOINTS: usize = 20;
const SECONDS: u32 = 12;
const RATE: Rate = Rate { samples: 120, seconds: 1 };

/// Highest frequency of the sines, Hz: recordings after a low-pass filter of 6 Hz are hardly faster.
const HIGHEST_HZ: f64 = 4.8;

/// Number of slow sines in a joint's angle, and of sines that appear in bursts.
const SINES: usize = 12;

/// Calls a function with the motion.
pub(crate) fn with_motion<T>(take: impl FnOnce(&Motion<'_>) -> T) -> T {
    let mut numbers = Numbers(1);
    let angles: [Angle; JOINTS] = std::array::from_fn(|_| Angle::new(&mut numbers));
    let q: Vec<f64> = (0..=SECONDS * RATE.samples)
        .map(|sample| f64::from(sample) / f64::from(RATE.samples))
        .flat_map(|time_s| angles.iter().map(move |angle| angle.at(time_s)))
        .collect();
    take(&Motion {
        joints: &[Joint::Revolute; JOINTS],
        q: &q,
        rate: RATE,
        is_loop: false,
        rig: 0,
        cues: &[],
        time_code: None,
        course: &[],
    })
}

/// A joint's angle: slow sines all the time, fast sines in bursts.
struct Angle {
    slow: [Sine; SINES],
    quick: [(Sine, Burst); SINES],
}

struct Sine {
    amplitude_rad: f64,
    frequency_hz: f64,
    turns: f64,
}

/// A bell-shaped burst: time of its maximum, and its rise time, s.
struct Burst {
    time_s: f64,
    rise_s: f64,
}

impl Angle {
    fn new(numbers: &mut Numbers) -> Self {
        Self {
            slow: std::array::from_fn(|_| Sine::new(numbers, 0.1, 2.5)),
            quick: std::array::from_fn(|_| {
                let sine = Sine::new(numbers, 1.5, HIGHEST_HZ);
                let (time_s, rise_s) =
                    (f64::from(SECONDS) * numbers.next(), 0.3 + 0.4 * numbers.next());
                (sine, Burst { time_s, rise_s })
            }),
        }
    }

    /// Returns the angle at a time, rad.
    fn at(&self, time_s: f64) -> f64 {
        let slow: f64 = self.slow.iter().map(|sine| sine.at(time_s)).sum();
        let quick = self.quick.iter().map(|(sine, burst)| sine.at(time_s) * burst.at(time_s));
        slow + quick.sum::<f64>()
    }
}

impl Sine {
    /// Creates a sine whose amplitude falls with its frequency, as in joint angles.
    fn new(numbers: &mut Numbers, least_hz: f64, most_hz: f64) -> Self {
        let frequency_hz = least_hz + (most_hz - least_hz) * numbers.next();
        let amplitude_rad = 0.7 * numbers.next() / (1.0 + frequency_hz);
        Self { amplitude_rad, frequency_hz, turns: numbers.next() }
    }

    fn at(&self, time_s: f64) -> f64 {
        self.amplitude_rad * libm::sin(TAU * (self.turns + self.frequency_hz * time_s))
    }
}

impl Burst {
    fn at(&self, time_s: f64) -> f64 {
        let rises = (time_s - self.time_s) / self.rise_s;
        libm::exp(-rises * rises)
    }
}

/// Numbers in [0, 1), the same in every run (`SplitMix64`).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}
