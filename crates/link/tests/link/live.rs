//! A live source with jitter and loss: the targets never jump, and they follow.

#![expect(clippy::cast_possible_truncation, reason = "counts and times are small")]

use proptest::prelude::*;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::math;
use sinew_link::message::LiveFrame;
use sinew_link::{
    Coordinate, Following, LiveBuffer, LiveRefusal, LiveSettings, LiveSetupError, LiveTarget,
};

use crate::common::Random;

const SPEED: f32 = 3.0;
const JOINTS: [Coordinate; 3] = [
    Coordinate::Scalar { speed: SPEED },
    Coordinate::Rotation { speed: SPEED },
    Coordinate::Scalar { speed: 0.5 },
];
type Buffer = LiveBuffer<8, 16>;

fn buffer() -> Buffer {
    Buffer::new(&JOINTS, LiveSettings::DEFAULT).expect("the settings can be")
}

/// Returns the performer's pose at a time in s: speeds up to 1.5 rad/s.
fn pose(time: f64) -> [f32; 6] {
    let swing = (1.0 * (1.5 * time).sin()) as f32;
    let turn = math::exp(Vec3::new(0.3, 0.6, -0.2) * (2.0 * time).sin() as f32);
    [swing, turn.x, turn.y, turn.z, turn.w, 0.1 * time.cos() as f32]
}

fn frame(sent_us: u32, q: &[f32]) -> LiveFrame {
    LiveFrame { sent_us, q: q.iter().copied().collect() }
}

/// Returns the distance of two poses, joint by joint.
fn distance(a: &[f32], b: &[f32]) -> [f32; 3] {
    let quat = |q: &[f32]| Quat::from_xyzw(q[1], q[2], q[3], q[4]);
    let turn = math::length(math::log(quat(a).conjugate() * quat(b)));
    [(a[0] - b[0]).abs(), turn, (a[5] - b[5]).abs()]
}

/// Checks that no joint exceeds its speed limit, within f32 rounding (of numbers near 1, and of a rotation's
/// logarithm).
fn assert_slow(before: &[f32], after: &[f32]) {
    let tick = LiveSettings::DEFAULT.tick_s;
    for (step, joint) in distance(before, after).into_iter().zip([SPEED, SPEED, 0.5]) {
        assert!(step <= joint * tick + 1e-6, "{step} of {before:?} to {after:?}");
    }
}

struct Run {
    /// Largest distance of each joint's target from the pose due at that time, after the buffer has begun to follow.
    worst: [f32; 3],
    stale: u32,
    held: u32,
    ticks: u32,
    /// Longest time between two new frames.
    longest_us: u64,
}

/// Simulates a minute: 60 frames per second, each up to `jitter_us` late and lost with probability `loss`, and 500
/// ticks per second.
fn run(seed: u64, jitter_us: usize, loss: f64, drift: f64, clock: u32) -> Run {
    let mut random = Random(seed);
    let mut under_way: Vec<(u64, LiveFrame)> = (0..3600_u64)
        .filter_map(|index| {
            let sent_us = index * 1_000_000 / 60;
            let q = pose(sent_us as f64 * 1e-6);
            let stamp = clock.wrapping_add_signed((sent_us as f64 * (1.0 + drift)) as i32);
            let arrives = 5_000_000 + sent_us + 2_000 + random.below(jitter_us + 1) as u64;
            (!random.chance(loss)).then(|| (arrives, frame(stamp, &q)))
        })
        .collect();
    under_way.sort_by_key(|(arrives, _)| *arrives);

    let mut buffer = buffer();
    buffer.start(&pose(0.0)).expect("it is a pose");
    let mut before = pose(0.0).to_vec();
    let mut run = Run { worst: [0.0; 3], stale: 0, held: 0, ticks: 0, longest_us: 0 };
    let (mut next, mut newest, mut newest_at) = (0, None, None);
    for tick in 0..30_000_u64 {
        let now = 5_000_000 + tick * 2_000;
        while let Some((arrives, frame)) = under_way.get(next).filter(|(at, _)| *at <= now) {
            let _ = buffer.push(frame, *arrives);
            let age = frame.sent_us.wrapping_sub(clock);
            if newest < Some(age) {
                run.longest_us = run.longest_us.max(newest_at.map_or(0, |at| arrives - at));
                (newest, newest_at) = (Some(age), Some(*arrives));
            }
            next += 1;
        }
        let LiveTarget { q, following, .. } = buffer.step(now);
        assert_slow(&before, q);
        before = q.to_vec();
        run.ticks += 1;
        match following {
            Following::Stale => run.stale += 1,
            Following::Held => run.held += 1,
            Following::Waiting => assert!(tick < 200, "it waits at tick {tick}"),
            Following::Interpolated => {}
        }
        // Only once the buffer follows, and the bound of the clock has settled.
        if tick > 1500 {
            let due = (now - 5_000_000 - 150_000 - 2_000) as f64 * 1e-6;
            for (worst, here) in run.worst.iter_mut().zip(distance(&pose(due), &before)) {
                *worst = worst.max(here);
            }
        }
    }
    run
}

#[test]
fn jitter_and_loss_do_not_show() {
    for (seed, jitter_us, loss, drift) in [
        (1, 0, 0.0, 0.0),
        (2, 30_000, 0.0, 0.0),
        (3, 100_000, 0.0, 0.0),
        (4, 100_000, 0.1, 0.0),
        (5, 100_000, 0.1, 2e-4),
        (6, 100_000, 0.1, -2e-4),
    ] {
        let run = run(seed, jitter_us, loss, drift, u32::MAX - 10_000_000);
        println!(
            "jitter {jitter_us} us, loss {loss}, drift {drift}: off by {:?}, {} of {} ticks held, {} stale, \
             longest gap {} us",
            run.worst, run.held, run.ticks, run.stale, run.longest_us
        );
        // Gaps below the time-out cause no stale source.
        assert!(run.longest_us < 200_000 && run.stale == 0);
        // Without jitter: the error of the chord between two frames, 2.8 rad/s² (1/60 s)² / 8. With jitter, the bound
        // of the clock is off by some ms, at 1.5 rad/s, and a chord may span three frames.
        let most = if jitter_us == 0 { 2e-4 } else { 0.012 };
        assert!(run.worst.iter().all(|&off| off < most), "{:?}", run.worst);
        assert!(f64::from(run.held) < 0.001 * f64::from(run.ticks));
    }
}

/// Sources of any rate, up to the capacity of a 1 Mbps line: 24 places are enough. Some have the default delay of 150
/// ms, others a longer one, or none.
#[test]
fn a_source_of_any_rate_is_followed() {
    for (hz, delay_us, most) in [
        (20, 150_000, 1e-3),
        (60, 150_000, 2e-4),
        (120, 150_000, 2e-4),
        (200, 150_000, 2e-4),
        (400, 150_000, 2e-4),
        (2_400, 150_000, 2e-4),
        (50, 500_000, 1e-3),
        (200, 2_000_000, 0.02),
        (200, 0, 0.02),
    ] {
        let settings = LiveSettings { delay_us, ..LiveSettings::DEFAULT };
        let mut buffer = LiveBuffer::<8, 24>::new(&JOINTS, settings).expect("the settings can be");
        buffer.start(&pose(0.0)).expect("it is a pose");
        let (mut sent, mut worst, mut held) = (0_u64, 0.0_f32, 0);
        for tick in 0..10_000_u64 {
            let now = tick * 2_000;
            while sent * 1_000_000 / hz <= now {
                let at = sent * 1_000_000 / hz;
                buffer.push(&frame(at as u32, &pose(at as f64 * 1e-6)), at).expect("in time");
                sent += 1;
            }
            let target = buffer.step(now);
            if tick > 2_000 {
                let is_fed = matches!(target.following, Following::Interpolated | Following::Held);
                assert!(is_fed, "{hz} Hz, {delay_us} us: {target:?}");
                held += u32::from(target.following == Following::Held);
                let due = (now - u64::from(delay_us)) as f64 * 1e-6;
                worst = distance(&pose(due), target.q).into_iter().fold(worst, f32::max);
            }
        }
        let thinned = buffer.counts().thinned;
        println!(
            "{hz} Hz, {delay_us} us: off by {worst}, {held} held, {thinned} of {sent} thinned"
        );
        assert!(worst < most && (held == 0 || delay_us == 0), "{hz} Hz: {worst}, {held} held");
    }
}

#[test]
fn a_source_that_ends_is_stale_in_time_and_begins_anew() {
    let mut buffer = buffer();
    buffer.start(&pose(0.0)).expect("it is a pose");
    assert_eq!(buffer.step(0).following, Following::Waiting);
    assert_eq!(buffer.step(0).age_us, None);
    for index in 0..30_u32 {
        let sent = index * 16_667;
        buffer.push(&frame(sent, &pose(f64::from(sent) * 1e-6)), sent.into()).expect("in time");
        buffer.step(sent.into());
    }
    let last = 29 * 16_667;
    assert_eq!(buffer.step(last + 199_999).following, Following::Held);
    let held = buffer.step(last + 199_999).q.to_vec();
    let stale = buffer.step(last + 200_000);
    assert_eq!((stale.following, stale.age_us), (Following::Stale, Some(200_000)));
    assert_eq!(buffer.step(last + 9_000_000).following, Following::Stale);
    assert_eq!(buffer.step(last + 9_000_000).q, held);
    // Repeating the same frame does not prevent staleness; a new time stamp does.
    buffer.push(&frame(77, &pose(3.0)), 20_000_000).expect("a new beginning");
    assert_eq!(buffer.push(&frame(77, &pose(3.0)), 20_100_000), Err(LiveRefusal::Twice));
    assert_eq!(buffer.step(20_100_000).following, Following::Waiting);
    assert_eq!(buffer.step(20_200_000).following, Following::Stale);
}

#[test]
fn wrong_frames_are_refused() {
    let mut buffer = buffer();
    let good = pose(0.3);
    let mut push = |q: &[f32], sent| buffer.push(&frame(sent, q), 1_000_000);
    assert_eq!(push(&good[..5], 0), Err(LiveRefusal::Count { rig: 6, frame: 5 }));
    let with = |place: usize, number| {
        let mut q = good;
        q[place] = number;
        q
    };
    assert_eq!(push(&with(0, f32::NAN), 0), Err(LiveRefusal::Number { coordinate: 0 }));
    assert_eq!(push(&with(5, 2e6), 0), Err(LiveRefusal::Number { coordinate: 5 }));
    assert_eq!(push(&with(4, 3.0), 0), Err(LiveRefusal::NotUnit { coordinate: 1 }));
    assert_eq!(push(&good, 500), Ok(()));
    assert_eq!(push(&good, 500), Err(LiveRefusal::Twice));
    assert_eq!(push(&good, 2_000_000), Err(LiveRefusal::Time));
    assert_eq!(buffer.counts().refused, 6);

    let setup = |joints: &[Coordinate], settings| LiveBuffer::<4, 4>::new(joints, settings).err();
    let scalar = |speed| Coordinate::Scalar { speed };
    let settings = LiveSettings::DEFAULT;
    let capacity = Some(LiveSetupError::Capacity { room: 4, needs: 6 });
    assert_eq!(setup(&JOINTS, settings), capacity);
    for speed in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e7] {
        assert_eq!(setup(&[scalar(speed)], settings), Some(LiveSetupError::Speed { joint: 0 }));
    }
    for tick_s in [0.0, f32::NAN, 2.0] {
        let settings = LiveSettings { tick_s, ..settings };
        assert_eq!(setup(&[scalar(1.0)], settings), Some(LiveSetupError::Tick));
    }
    for (delay_us, stale_us) in [(3_000_000, 1), (1, 3_000_000), (1, 0)] {
        let settings = LiveSettings { delay_us, stale_us, ..settings };
        assert_eq!(setup(&[scalar(1.0)], settings), Some(LiveSetupError::Time));
    }
}

proptest! {
    /// A hostile source with any time stamps, poses and pauses. Steps stay within the limits, and rotations stay
    /// unit.
    #[test]
    fn whatever_comes_nothing_jumps(seed: u64) {
        let mut random = Random(seed);
        let mut buffer = buffer();
        let mut before = buffer.step(0).q.to_vec();
        let mut now = 0_u64;
        for _ in 0..2000 {
            now += if random.chance(0.01) { u64::from(random.bits()) } else { 2_000 };
            if random.chance(0.3) {
                let stamp = if random.chance(0.5) { now as u32 } else { random.bits() };
                let mut q = pose(random.unit() * 1e3);
                q[0] = if random.chance(0.5) { random.finite() } else { q[0] * 1e6 };
                q[3] = if random.chance(0.1) { random.finite() } else { q[3] };
                let _ = buffer.push(&frame(stamp, &q), now);
            }
            let q = buffer.step(now).q;
            let turn = Quat::from_xyzw(q[1], q[2], q[3], q[4]);
            prop_assert!(q.iter().all(|number| number.is_finite()));
            prop_assert!((turn.length() - 1.0).abs() < 1e-5);
            assert_slow(&before, q);
            before = q.to_vec();
        }
    }
}
