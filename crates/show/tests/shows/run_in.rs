//! A run-in starts at rest in the first frame, its speeds match its motion, and it ends in the show.

use sinew_core::tracker::{Frame, FrameSource};
use sinew_show::write::Settings;
use sinew_show::{Joint, Rate, Show, ShowFrames};

use crate::examples::example;

const COORDS: usize = 8;
/// Number of ticks of the run-in, and their period.
const TICKS: u32 = 400;
const DT_S: f32 = 1.0 / 400.0;

fn numbers(frame: Frame<'_>) -> [Vec<f64>; 3] {
    let Frame::Coordinates { q, qd, qdd } = frame else { panic!("a show has coordinates") };
    [q, qd, qdd].map(|numbers| numbers.iter().copied().map(f64::from).collect())
}

#[test]
fn it_moves_by_its_own_speeds_from_rest_into_the_show() {
    let joints = vec![Joint::Revolute, Joint::Universal, Joint::Prismatic];
    let bytes = example(joints, 300, Rate { samples: 100, seconds: 1 }, false, 9)
        .write(&Settings::default())
        .bytes;
    let show = Show::open(&bytes).expect("a show");
    let mut frames = ShowFrames::<COORDS>::new(show, DT_S).expect("it plays");
    let first = numbers(frames.frame(-1));
    let at_speed = numbers(frames.frame(0));
    assert!(at_speed[1].iter().any(|speed| speed.abs() > 0.5), "{at_speed:?}");
    let all: Vec<[Vec<f64>; 3]> =
        (0..=TICKS).map(|tick| numbers(frames.run_in(tick, TICKS))).collect();
    assert_eq!(all[0], [first[0].clone(), vec![0.0; 4], vec![0.0; 4]]);
    assert_eq!(all[TICKS as usize], numbers(frames.frame(TICKS.cast_signed() / 2)));
    // A difference over two ticks equals the derivative somewhere in them. It deviates from the derivative in their
    // middle by at most the largest change of the derivative in a tick, plus f32 rounding of positions and computed
    // speeds.
    let dt_s = f64::from(DT_S);
    for (order, rounding) in [2e-6, 2e-5].into_iter().enumerate() {
        for joint in 0..4 {
            let change =
                |two: &[[Vec<f64>; 3]]| (two[1][order + 1][joint] - two[0][order + 1][joint]).abs();
            let most = all.windows(2).map(change).fold(0.0, f64::max) + rounding / (2.0 * dt_s);
            for three in all.windows(3) {
                let way = three[2][order][joint] - three[0][order][joint];
                let (found, told) = (way / (2.0 * dt_s), three[1][order + 1][joint]);
                assert!(
                    (found - told).abs() <= most,
                    "{order} of {joint}: {found}, {told}, {most}"
                );
            }
        }
    }
}
