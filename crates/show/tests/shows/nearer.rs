//! A show is brought closer to its motion in some places, and is unchanged elsewhere.

use sinew_show::write::{Settings, Writer};
use sinew_show::{Joint, Player, Position, Rate, Show};

use crate::examples::example;

const COORDS: usize = 2;

/// Returns the positions of both joints at all samples.
fn played(bytes: &[u8]) -> Vec<[f32; COORDS]> {
    let show = Show::open(bytes).expect("a show");
    let mut player = Player::<COORDS>::new(show).expect("room");
    let at = |sample| {
        let (mut q, mut qd, mut qdd) = ([0.0; COORDS], [0.0; COORDS], [0.0; COORDS]);
        let position = Position::from_samples(sample);
        player.state_at(position, &mut q, &mut qd, &mut qdd).expect("a whole show");
        q
    };
    (0..=show.length()).map(at).collect()
}

#[test]
fn a_show_is_nearer_where_it_is_asked_to_be_and_the_same_elsewhere() {
    const SAMPLES: usize = 1200;
    let rate = Rate { samples: 120, seconds: 1 };
    let example = example(vec![Joint::Revolute; COORDS], SAMPLES, rate, false, 4);
    let settings = Settings::default();
    let mut writer = Writer::new(example.motion(), settings).expect("a motion that can be");
    let write = |writer: &mut Writer<'_>| writer.write().expect("a show");
    let first = write(&mut writer);
    assert_eq!(first.bytes, example.write(&settings).bytes);

    let (samples, beside, share) = (600..640, 40, 1.0 / 16.0);
    assert!(writer.bring_nearer(1, samples.clone(), beside, [share, share]));
    assert!(
        !writer.bring_nearer(1, samples.clone(), beside, [share, share]),
        "it is as near as that"
    );
    assert!(
        !writer.bring_nearer(1, SAMPLES + 5..SAMPLES + 9, beside, [share, share]),
        "behind the end"
    );
    assert!(!writer.bring_nearer(COORDS, samples.clone(), beside, [share, share]), "no such joint");
    let nearer = write(&mut writer);
    let [before, after] = [&first, &nearer].map(|show| played(&show.bytes));
    let worst = |played: &[[f32; COORDS]], samples: std::ops::Range<usize>| {
        let error =
            |sample: usize| (f64::from(played[sample][1]) - example.q[COORDS * sample + 1]).abs();
        samples.map(error).fold(0.0, f64::max)
    };
    assert!(worst(&before, samples.clone()) > share * settings.angle_rad);
    assert!(worst(&after, samples) <= share * settings.angle_rad);
    assert!(worst(&after, 0..SAMPLES) <= settings.angle_rad);
    assert!(nearer.knots > first.knots && nearer.knots < first.knots + 100);
    // The curve of the other joint stays the same.
    assert!(
        before.iter().zip(&after).all(|(before, after)| before[0].to_bits() == after[0].to_bits())
    );
}
