//! Bytes that a host sends to servos: the loop waits while they leave, so their number is limited by the line's rate.

use sinew_link::message::{Applied, Command, Outcome, PASS_MAX, PASS_WAIT_US, Pass, Refusal};

use super::line::Trouble;
use super::stored::show;
use super::test_rig::Kind;
use super::world::World;

fn pass(baud: u32, bytes: &[u8]) -> Command {
    let bytes = bytes.try_into().unwrap();
    Command::PassOn(Pass { line: 0, baud, wait_us: PASS_WAIT_US, bytes })
}

#[test]
fn what_would_keep_the_loop_too_long_is_refused_before_anything_is_sent() {
    let mut world =
        World::ready(Kind::Current, Trouble::default(), 51, &show(Kind::Current, 1, false));
    world.run(0.5);
    let mark = [0xA5; PASS_MAX];
    // 128 bytes take 20 ms at 64,000 bit/s; 19 bytes take 19.8 ms at 9,600 bit/s; a line may have any rate.
    for (baud, len) in [(63_999, 128), (9_600, 128), (9_600, 20), (9_599, 1), (300, 0), (1, 1)] {
        let outcome = world.ask(pass(baud, &mark[..len]));
        assert_eq!(outcome, Outcome::Refused(Refusal::Value), "{len} bytes at {baud} bit/s");
    }
    // The simulated line has only one rate, and reports that it lacks other rates that are fast enough.
    for (baud, len) in [(64_000, 128), (9_600, 19), (9_600, 0)] {
        let outcome = world.ask(pass(baud, &mark[..len]));
        assert_eq!(outcome, Outcome::Refused(Refusal::Unsupported), "{len} bytes at {baud} bit/s");
    }
    assert!(matches!(world.ask(pass(0, &mark)), Outcome::Applied(Applied::Passed(_))));

    // The limit also applies to the line's own rate.
    world.bench.baud = 57_600;
    assert_eq!(world.ask(pass(0, &mark)), Outcome::Refused(Refusal::Value));
}

#[test]
fn servos_are_waited_for_from_the_last_byte_out() {
    let mut world =
        World::ready(Kind::Current, Trouble::default(), 52, &show(Kind::Current, 1, false));
    world.run(0.5);
    // A ping of servo 1 after noise: all bytes take 1.3 ms at 1 Mbit/s, longer than the wait.
    let mut bytes = [0xA5; PASS_MAX];
    bytes[PASS_MAX - 10..].copy_from_slice(&[0xFF, 0xFF, 0xFD, 0, 1, 3, 0, 1, 0x19, 0x4E]);
    let bytes = bytes.as_slice().try_into().unwrap();
    let wait_us = 1000;
    let outcome = world.ask(Command::PassOn(Pass { line: 0, baud: 0, wait_us, bytes }));
    let Outcome::Applied(Applied::Passed(passed)) = outcome else { panic!("{outcome:?}") };
    assert_eq!((passed.count, &passed.bytes[..5]), (14, &[0xFF, 0xFF, 0xFD, 0, 1][..]));
    assert!(passed.took_us > wait_us, "{} us", passed.took_us);
}
