//! A live stream with up to 100 ms of jitter, in which one frame in ten is lost.

use sinew_firmware::supervisor::State;
use sinew_link::message::{Command, Feed, LiveFrame, Stream};

use super::line::Trouble;
use super::stored::show;
use super::test_rig::{Kind, figure};
use super::world::World;

const LIVE: Trouble = Trouble { lost: 100, twice: 20, flipped: 20, jitter_us: 100_000 };

/// A stream of any rate must be played. The buffer delays frames by 150 ms and has room for 24: at 200 frames per
/// second, the latest 24 are not due yet. A buffer that kept only these would cause `FeedSilent`.
#[test]
fn a_stream_of_any_rate_is_played() {
    let kind = Kind::Current;
    for hz in [20.0, 120.0, 200.0, 400.0] {
        let mut world = World::ready(kind, Trouble::default(), 11, &show(kind, 1, false));
        world.run(2.0);
        world.arm();
        world.until(State::Holding, 2.0);
        let home: Vec<f32> = figure(kind).home.iter().map(|home| *home as f32).collect();
        let (begin_us, mut sent, mut asked) = (world.now_us(), 0_u32, false);
        for tick in 0..(8.0 / (world.tick_us() as f64 * 1e-6)) as u64 {
            let now_us = world.now_us();
            let due = ((now_us - begin_us) as f64 * 1e-6 * hz) as u32;
            while sent < due {
                sent += 1;
                let sent_us = begin_us as u32 + (f64::from(sent) / hz * 1e6) as u32;
                let frame = LiveFrame { sent_us, q: home.iter().copied().collect() };
                world.host.stream(Stream::Live(frame), now_us);
            }
            if tick > 400 && !asked {
                world.host.ask(Command::Play(Feed::Live), now_us);
                asked = true;
            }
            world.tick();
            if tick > 420 {
                assert_eq!(
                    world.state(),
                    Some(State::Playing),
                    "{hz} Hz: {:?}",
                    world.host.outcome
                );
            }
        }
        assert!(world.host.faults.is_empty(), "{hz} Hz: {:?}", world.host.faults);
    }
}

#[test]
fn a_stream_with_jitter_and_loss_moves_smoothly() {
    let kind = Kind::Current;
    let mut world = World::ready(kind, LIVE, 11, &show(kind, 1, false));
    world.host.beats = false;
    let (figure, dt_s) = (figure(kind), world.tick_us() as f32 * 1e-6);
    let mut before: Option<(Vec<f32>, Vec<f32>)> = None;
    let (mut most_step, mut most_change, mut played) = (0.0_f32, 0.0_f32, 0);
    let (mut sent_us, begin_us) = (0, world.now_us());
    let mut asked = 0;
    for _ in 0..(25.0 / dt_s) as u32 {
        let now_us = world.now_us();
        if now_us >= sent_us && world.host.welcome.is_some() {
            sent_us = now_us + 16_667;
            let t = now_us as f64 * 1e-6;
            let q = figure.home.iter().map(|home| (home + 0.4 * (1.5 * t).sin()) as f32).collect();
            world.host.stream(Stream::Live(LiveFrame { sent_us: now_us as u32, q }), now_us);
            world.host.beat(now_us);
        }
        // Each command is sent as soon as it is possible.
        let next = match (asked, world.state()) {
            // Without torque the arm falls: it is armed after it has come to rest.
            (0, Some(State::Limp)) if world.now_us() > begin_us + 4_000_000 => Some(Command::Arm),
            (1, Some(State::Holding)) => Some(Command::Play(Feed::Live)),
            _ => None,
        };
        if let Some(command) = next {
            world.host.ask(command, now_us);
            asked += 1;
        }
        world.tick();
        let (control, _) = world.board.control.as_ref().unwrap();
        let (q, qd) = control.controller().commanded();
        let is_on = control.controller().permission().torque;
        if let (true, Some((q_before, qd_before))) = (is_on, &before) {
            for (joint, dof) in figure.board.dofs().iter().enumerate() {
                let step = (q[joint] - q_before[joint]).abs() / dt_s / dof.speed;
                let change = (qd[joint] - qd_before[joint]).abs() / dt_s / dof.acceleration;
                (most_step, most_change) = (most_step.max(step), most_change.max(change));
            }
        }
        before = is_on.then(|| (q.to_vec(), qd.to_vec()));
        played += u32::from(control.controller().permission().runs);
    }
    println!(
        "played {:.1} s; of the limits: speed {most_step:.3}, acceleration {most_change:.3}",
        played as f32 * dt_s
    );
    assert_eq!(world.state(), Some(State::Playing), "{:?}", world.host.faults);
    assert!(world.host.faults.is_empty(), "{:?}", world.host.faults);
    assert!(played as f32 * dt_s > 10.0);
    // The tolerance covers f32 differences of positions near 1 rad over 2.5 ms: 1e-7 / 0.0025 rad/s.
    assert!(most_step <= 1.001 && most_change <= 1.01);
}
