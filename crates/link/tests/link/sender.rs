//! A host does not wait forever.

use sinew_link::message::*;
use sinew_link::{Next, Sender};

/// Simulates a controller that answers `Working` for a time, then done, and a host that polls every 10 ms. Returns
/// what the host receives, and when.
fn after(command: Command, works_ms: u32, starts_ms: u32) -> (Option<Outcome>, u32) {
    let done = Outcome::Applied(Applied::Done);
    let mut sender = Sender::new(1);
    let mut sent = Some(sender.send(command, starts_ms).expect("nothing waits"));
    for passed_ms in (0..100_000).step_by(10) {
        let now_ms = starts_ms.wrapping_add(passed_ms);
        match sender.poll(now_ms) {
            Next::Send(command) => sent = Some(command),
            Next::GaveUp(command) => {
                assert_eq!((command.seq, sender.poll(now_ms)), (0, Next::Idle));
                return (None, passed_ms);
            }
            Next::Wait | Next::Idle => {}
        }
        if let Some(Numbered { session, seq, .. }) = sent.take() {
            let item = if passed_ms < works_ms { Outcome::Working } else { done.clone() };
            if let Some(outcome) = sender.take(&Numbered { session, seq, item }) {
                return (Some(outcome), passed_ms);
            }
        }
    }
    (None, u32::MAX)
}

#[test]
fn work_that_never_ends_is_given_up() {
    let done = Some(Outcome::Applied(Applied::Done));
    // Also when the clock wraps to 0.
    for starts_ms in [0, u32::MAX - 30_000] {
        assert_eq!(after(Command::EndUpload, 0, starts_ms), (done.clone(), 0));
        assert_eq!(after(Command::EndUpload, 59_000, starts_ms), (done.clone(), 59_000));
        assert_eq!(after(Command::EndUpload, u32::MAX, starts_ms), (None, 60_000));
        // An e-stop is repeated until it is answered.
        assert_eq!(after(Command::EStop, 90_000, starts_ms), (done.clone(), 90_000));
    }
}

#[test]
fn silence_is_given_up_after_ten_tries() {
    let mut sender = Sender::new(1);
    sender.send(Command::Hold, 0).expect("nothing waits");
    let sent = (0..).step_by(10).map(|now_ms| (now_ms, sender.poll(now_ms)));
    let mut asked = sent.filter(|(_, next)| *next != Next::Wait).take(10);
    for index in 1..10 {
        assert!(matches!(asked.next(), Some((now_ms, Next::Send(_))) if now_ms == index * 100));
    }
    assert!(matches!(asked.next(), Some((1000, Next::GaveUp(_)))));
}
