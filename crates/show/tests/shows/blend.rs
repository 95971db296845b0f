//! A blend starts and ends in the given states, in position, speed and acceleration, and its speeds match its motion.

use crate::examples::{any_example, example};
use proptest::prelude::*;
use sinew_core::tracker::{Frame, FrameSource};
use sinew_show::write::Settings;
use sinew_show::{Blend, BlendError, Joint, Player, Position, Rate, Show, ShowFrames, State};

const COORDS: usize = 32;

#[derive(Clone, PartialEq, Debug)]
struct Numbers {
    q: Vec<f32>,
    qd: Vec<f32>,
    qdd: Vec<f32>,
}

impl Numbers {
    fn of(show: &Show<'_>) -> Self {
        let nv = show.dof_count();
        Self { q: vec![0.0; show.channel_count()], qd: vec![0.0; nv], qdd: vec![0.0; nv] }
    }

    fn state(&self) -> State<'_> {
        State { q: &self.q, qd: &self.qd, qdd: &self.qdd }
    }
}

fn at(blend: &Blend<'_, COORDS>, show: &Show<'_>, time_s: f32) -> Numbers {
    let mut n = Numbers::of(show);
    blend.state_at(time_s, &mut n.q, &mut n.qd, &mut n.qdd);
    n
}

/// Returns the largest difference of positions (a quaternion may have the opposite sign), and of speeds and
/// accelerations.
fn apart(show: &Show<'_>, a: &Numbers, b: &Numbers) -> [f32; 3] {
    let most =
        |a: &[f32], b: &[f32]| a.iter().zip(b).fold(0.0f32, |m, (a, b)| m.max((a - b).abs()));
    let mut q = 0.0f32;
    let mut first = 0;
    for joint in show.joints() {
        let next = first + joint.coordinate_count();
        let (of_a, of_b) = (&a.q[first..next], &b.q[first..next]);
        let along: f32 = of_a.iter().zip(of_b).take(4).map(|(a, b)| a * b).sum();
        let sign = if joint.turns_freely() && along < 0.0 { -1.0 } else { 1.0 };
        let turned: Vec<f32> =
            of_b.iter().enumerate().map(|(k, x)| if k < 4 { x * sign } else { *x }).collect();
        q = q.max(most(of_a, &turned));
        first = next;
    }
    [q, most(&a.qd, &b.qd), most(&a.qdd, &b.qdd)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn both_ends_are_met(example in any_example(COORDS), from in 0u32..100, to in 0u32..100, duration_s in 0.3f32..1.0) {
        let bytes = example.write(&Settings::default()).bytes;
        let show = Show::open(&bytes).expect("a show");
        let mut player = Player::<COORDS>::new(show).expect("room");
        let [from, to] = [from, to].map(|share| {
            let mut n = Numbers::of(&show);
            let position = Position::from_samples(show.length() * share / 100);
            player.state_at(position, &mut n.q, &mut n.qd, &mut n.qdd).expect("whole");
            n
        });
        let blend = match Blend::<COORDS>::new(show, from.state(), to.state(), duration_s) {
            Ok(blend) => blend,
            Err(error) => {
                prop_assert!(matches!(error, BlendError::Turns { .. }), "{error}");
                return Ok(());
            }
        };
        for (time_s, wanted) in [(0.0, &from), (-1.0, &from), (duration_s, &to), (9.0, &to)] {
            let [q, qd, qdd] = apart(&show, &at(&blend, &show, time_s), wanted);
            // Tolerance: f32 rounding, through the chart and back.
            let size = |numbers: &[f32]| 1.0 + numbers.iter().fold(0.0f32, |m, x| m.max(x.abs()));
            let (v, a) = (size(&wanted.qd), size(&wanted.qdd));
            prop_assert!(q < 1e-6 && qd < 1e-6 * v && qdd < 1e-6 * (a + v * v), "{q} {qd} {qdd} at {time_s}");
        }
        // No jump: from step to step the position changes by the speed, up to the effect of the acceleration.
        let mut last = at(&blend, &show, 0.0);
        for look in 1..=200u8 {
            let now = at(&blend, &show, duration_s * f32::from(look) / 200.0);
            let [q, ..] = apart(&show, &now, &last);
            let fastest = now.qd.iter().chain(&last.qd).fold(0.0f32, |m, x| m.max(x.abs()));
            let most = now.qdd.iter().chain(&last.qdd).fold(0.0f32, |m, x| m.max(x.abs()));
            let dt_s = duration_s / 200.0;
            // In a free joint, three speeds may act on one coordinate.
            prop_assert!(q <= 1.8 * (fastest + most * dt_s) * dt_s + 1e-5, "{q} {fastest} {most}");
            last = now;
        }
    }
}

#[test]
fn wrong_states_are_refused() {
    let example = example(
        vec![Joint::Spherical, Joint::Revolute],
        60,
        Rate { samples: 30, seconds: 1 },
        false,
        3,
    );
    let bytes = example.write(&Settings::default()).bytes;
    let show = Show::open(&bytes).expect("a show");
    let rest = [0.0, 0.0, 0.0, 1.0, 0.0];
    let good = State { q: &rest, qd: &[0.0; 4], qdd: &[0.0; 4] };
    let refused = |from, duration_s| {
        Blend::<8>::new(show, from, good, duration_s).expect_err("wrong").to_string()
    };
    let nan = [0.0, f32::NAN, 0.0, 0.0];
    assert_eq!(
        refused(State { qd: &nan, ..good }, 1.0),
        "qd[1] is NaN; it must be a number from -1e6 to 1e6"
    );
    assert_eq!(
        refused(State { q: &rest[1..], ..good }, 1.0),
        "q must have 5 numbers for this show, not 4"
    );
    assert_eq!(refused(good, f32::NAN), "the blend takes NaN s; it must take from 0.001 to 1000 s");
    let zero = [0.0; 5];
    assert!(matches!(
        Blend::<8>::new(show, State { q: &zero, ..good }, good, 1.0),
        Err(BlendError::NotUnit { index: 0, .. })
    ));
    assert!(matches!(
        Blend::<4>::new(show, good, good, 1.0),
        Err(BlendError::Capacity { found: 5, holds: 4 })
    ));
}

#[test]
fn frames_rest_before_and_behind() {
    let rate = Rate { samples: 60, seconds: 1 };
    let example = example(vec![Joint::Revolute, Joint::Spherical], 121, rate, false, 3);
    let bytes = example.write(&Settings::default()).bytes;
    let mut frames =
        ShowFrames::<8>::new(Show::open(&bytes).expect("a show"), 0.01).expect("whole");
    let mut numbers = |index| match frames.frame(index) {
        Frame::Coordinates { q, qd, qdd } => (q.to_vec(), qd.to_vec(), qdd.to_vec()),
        Frame::Poses(_) => panic!("a show of coordinates"),
    };
    let (first, before, last, behind) = (numbers(0), numbers(-3), numbers(200), numbers(1000));
    assert_eq!((first.0.len(), first.1.len(), first.2.len()), (5, 4, 4));
    assert!(first.1.iter().any(|x| *x != 0.0));
    assert_eq!(before, (first.0, vec![0.0; 4], vec![0.0; 4]));
    assert_eq!(behind.1, vec![0.0; 4]);
    // 200 ticks of 0.01 s in f32 are the end, within rounding.
    assert!(last.0.iter().zip(&behind.0).all(|(a, b)| (a - b).abs() < 1e-5));
    let mut broken = bytes.clone();
    *broken.last_mut().expect("bytes") ^= 1;
    let refused = ShowFrames::<8>::new(Show::open(&broken).expect("a head"), 0.01);
    assert!(
        refused
            .expect_err("a block is damaged")
            .to_string()
            .starts_with("block 0 of the show is damaged")
    );
}
