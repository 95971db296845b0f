//! A joint that follows another one has its curve.

use proptest::prelude::*;
use sinew_show::write::{Motion, Settings, ShowTie, Writer};
use sinew_show::{Joint, Player, Position, Rate, Show};

const SAMPLES: usize = 400;

/// Returns the leader's position at a sample: a sum of three waves.
fn leader(sample: usize) -> f64 {
    let wave = |period: f64, size: f64| size * (sample as f64 / period).sin();
    wave(60.0, 0.6) + wave(23.0, 0.2) + wave(9.0, 0.03)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// The follower is where its leader puts it, up to rounding, and both keep the error bound.
    #[test]
    fn a_follower_has_the_curve_of_its_leader(
        factor in prop_oneof![-4.0..-0.01_f64, 0.01..4.0_f64],
        offset in -1.0..1.0_f64,
        is_first in any::<bool>(),
    ) {
        let (own, of) = if is_first { (0, 1) } else { (1, 0) };
        let mut q = vec![0.0; 2 * SAMPLES];
        for sample in 0..SAMPLES {
            q[2 * sample + of] = leader(sample);
            q[2 * sample + own] = factor * leader(sample) + offset;
        }
        let motion = Motion {
            joints: &[Joint::Revolute; 2],
            q: &q,
            rate: Rate { samples: 100, seconds: 1 },
            is_loop: false,
            rig: 0,
            cues: &[],
            time_code: None,
            course: &[],
        };
        let settings = Settings::default();
        let mut writer = Writer::new(motion, settings).expect("a motion that can be");
        writer.tie([ShowTie { joint: own, leader: of, factor, offset }]);
        let written = writer.write().expect("a show");
        prop_assert!(written.angles.largest <= settings.angle_rad);
        let mut player = Player::<2>::new(Show::open(&written.bytes).expect("a show")).expect("room");
        // Half a step of the follower, a quarter of what its leader may be off, and f32.
        let tolerance = 0.25 * settings.angle_rad * factor.abs().min(0.8) + 1e-5;
        for sample in (0_u32..).take(SAMPLES) {
            let (mut at, mut qd, mut qdd) = ([0.0; 2], [0.0; 2], [0.0; 2]);
            let position = Position::from_samples(sample);
            player.state_at(position, &mut at, &mut qd, &mut qdd).expect("a whole show");
            let off = f64::from(at[own]) - factor * f64::from(at[of]) - offset;
            prop_assert!(off.abs() < tolerance, "{sample}: {off}");
            let off = f64::from(qd[own]) - factor * f64::from(qd[of]);
            prop_assert!(off.abs() < 1e-3, "{sample}: speed {off}");
        }
    }
}
