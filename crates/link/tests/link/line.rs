//! A million frames over a line that loses, duplicates, reorders and damages them.

#![expect(clippy::cast_possible_truncation, reason = "counts and times are small")]

use std::collections::VecDeque;

use sinew_link::message::*;
use sinew_link::{Decoder, Intake, Message, Next, Order, Sender, Session};

use crate::common;
use crate::common::Random;
use crate::common::wire::frame;

const ABOUT: About = About {
    protocol: Version::CURRENT,
    firmware: Release { major: 0, minor: 1, patch: 0 },
    rig: 0x1234_5678,
    capacities: Capacities {
        bodies: 32,
        coordinates: 64,
        dofs: 64,
        servos: 40,
        slots: 1,
        slot_bytes: 131_072,
    },
};

/// A line that delays frames, in any order.
struct Line {
    random: Random,
    under_way: Vec<Vec<u8>>,
    /// Fractions of all frames: lost, duplicated, damaged.
    bad: f64,
}

impl Line {
    fn new(seed: u64, bad: f64) -> Self {
        Self { random: Random(seed), under_way: Vec::new(), bad }
    }

    fn send(&mut self, frame: &[u8]) {
        let copies = match self.random.unit() {
            u if u < self.bad => 0,
            u if u < 2.0 * self.bad => 2,
            _ => 1,
        };
        for _ in 0..copies {
            let mut frame = frame.to_vec();
            if self.random.chance(self.bad) {
                for _ in 0..=self.random.below(6) {
                    let bit = self.random.below(frame.len() * 8);
                    frame[bit / 8] ^= 1 << (bit % 8);
                }
            }
            if self.random.chance(self.bad) {
                frame.truncate(self.random.below(frame.len()));
            }
            self.under_way.push(frame);
        }
    }

    /// Returns the arriving frames: most in order, some after up to eight later ones.
    fn receive(&mut self, flush: bool) -> Option<Vec<u8>> {
        if self.under_way.is_empty() || (!flush && self.under_way.len() < 8) {
            return None;
        }
        let place =
            if self.random.chance(self.bad) { self.random.below(self.under_way.len()) } else { 0 };
        Some(self.under_way.remove(place))
    }
}

fn hello(session: &mut Session, nonce: u32) -> Welcome {
    session.hello(Hello { protocol: Version::CURRENT, nonce }, ABOUT, false)
}

#[test]
fn what_comes_was_sent_and_is_executed_once_in_order() {
    const FRAMES: u32 = 1_000_000;
    let mut session = Session::new(1);
    let mut sender = Sender::new(hello(&mut session, 1).session);
    let id = session.id().expect("there was a greeting");
    let mut random = Random(10);
    let mut line = Line::new(11, 0.05);
    let mut decoder = Decoder::<ToController>::new();
    // Recently sent numbers, with the count of wraps of their sequence.
    let mut sent = VecDeque::new();
    let (mut commands, mut streams) = (0_u32, 0_u32);
    let (mut last_executed, mut last_fresh) = (None, None);
    let (mut executed, mut fresh, mut late) = (0, 0, 0);
    let (mut stops, mut late_stops) = (0, 0);

    for index in 0..FRAMES {
        let (count, message) = if random.chance(0.5) {
            let item = common::messages::command(&mut random);
            let command = Numbered { session: id, seq: commands as u16, item };
            commands += 1;
            (commands, ToController::Command(command))
        } else {
            let stream = sender.stream(common::messages::stream(&mut random));
            streams += 1;
            (streams, ToController::Stream(stream))
        };
        line.send(&frame(&message));
        sent.push_back((count, message));
        // A frame is sometimes delayed by up to eight others; by 2000 never.
        if sent.len() > 2000 {
            sent.pop_front();
        }
        while let Some(bytes) = line.receive(index + 1 == FRAMES) {
            decoder.feed(&bytes, |message| {
                let found = sent.iter().rev().find(|(_, sent)| *sent == message);
                let count = Some(found.expect("it was sent").0);
                match message {
                    ToController::Command(command) => match session.command(&command) {
                        Intake::Execute if command.item == Command::EStop => stops += 1,
                        Intake::Execute
                            if command.item == Command::Stop && count < last_executed =>
                        {
                            late_stops += 1;
                        }
                        Intake::Execute => {
                            assert!(count > last_executed, "{count:?} after {last_executed:?}");
                            last_executed = count;
                            executed += 1;
                            let done = Outcome::Applied(Applied::Done);
                            session.answer(id, command.seq, done);
                        }
                        Intake::Answer(answer) => {
                            assert_eq!((answer.session, answer.seq), (id, command.seq));
                        }
                    },
                    ToController::Stream(stream) => match session.stream(&stream) {
                        Some(Order::Fresh { .. }) => {
                            assert!(count > last_fresh);
                            last_fresh = count;
                            fresh += 1;
                        }
                        Some(Order::Late) => late += 1,
                        _ => {}
                    },
                    ToController::Hello(_) => unreachable!("none was sent"),
                }
            });
        }
    }
    let damage = decoder.damage();
    let (of_commands, of_streams) = session.counts();
    println!("{FRAMES} sent, {} came, {damage:?}", decoder.messages());
    println!(
        "{executed} executed, {stops} e-stops, {late_stops} late stops; {fresh} fresh, {late} late"
    );
    println!("commands {of_commands:?}\nstreams {of_streams:?}");
    // About 9 % of each half million are lost or damaged, and 7 % late.
    assert!(executed > 370_000 && fresh > 390_000 && late > 30_000 && stops > 17_000);
    assert!(damage.cut > 1000 && damage.crc > 1000 && damage.too_short > 0);
    // The window's count of lost numbers must equal the numbers that were sent and never arrived.
    let came = of_streams.fresh + of_streams.late;
    assert!(streams - came - of_streams.lost < 8, "{streams} sent, {came} came");
}

/// For any message, in both directions: only messages that were sent arrive.
#[test]
fn no_message_is_made_by_damage() {
    fn run<M: Message + PartialEq>(seed: u64, make: impl Fn(&mut Random) -> M) -> (u32, u32) {
        let mut random = Random(seed);
        let mut line = Line::new(seed + 1, 0.2);
        let mut decoder = Decoder::<M>::new();
        let mut sent = VecDeque::new();
        for _ in 0..100_000 {
            let message = make(&mut random);
            line.send(&frame(&message));
            sent.push_back(message);
            if sent.len() > 1000 {
                sent.pop_front();
            }
            while let Some(bytes) = line.receive(false) {
                // Frames follow each other without a gap: if the end of a frame is lost, the next one starts at once.
                decoder.feed(&bytes, |message| assert!(sent.contains(&message), "it was not sent"));
            }
        }
        (decoder.messages(), decoder.damage().total())
    }
    println!("{:?}", run(20, common::messages::to_controller));
    println!("{:?}", run(30, common::messages::to_host));
}

/// The host repeats a command until an answer arrives: every command is executed once, and gets its own answer.
#[test]
fn a_host_that_repeats_gets_each_command_done_once() {
    const COMMANDS: u32 = 30_000;
    let mut session = Session::new(9);
    let mut sender = Sender::new(hello(&mut session, 77).session);
    let (mut there, mut back) = (Line::new(40, 0.05), Line::new(41, 0.05));
    let mut controller = Decoder::<ToController>::new();
    let mut host = Decoder::<ToHost>::new();
    let mut executed = Vec::new();
    let (mut now_ms, mut repeats, mut gave_up) = (0_u32, 0, 0);

    for index in 0..COMMANDS {
        let value = Value::Count(index);
        let command = sender.send(Command::WriteSetting { key: 1, value }, now_ms);
        there.send(&frame(&ToController::Command(command.expect("the one before is answered"))));
        let mut outcome = None;
        while outcome.is_none() {
            now_ms += 10;
            match sender.poll(now_ms) {
                Next::Send(command) => {
                    repeats += 1;
                    there.send(&frame(&ToController::Command(command)));
                }
                Next::GaveUp(_) => {
                    gave_up += 1;
                    break;
                }
                Next::Wait | Next::Idle => {}
            }
            while let Some(bytes) = there.receive(true) {
                controller.feed(&bytes, |message| {
                    let ToController::Command(command) = message else { return };
                    let answer = match session.command(&command) {
                        Intake::Execute => {
                            let Command::WriteSetting { value, .. } = command.item else { return };
                            let Value::Count(count) = value else { return };
                            executed.push(count);
                            let done = Outcome::Applied(Applied::Setting(value));
                            session.answer(command.session, command.seq, done)
                        }
                        Intake::Answer(answer) => answer,
                    };
                    back.send(&frame(&ToHost::Answer(answer)));
                });
            }
            while let Some(bytes) = back.receive(true) {
                host.feed(&bytes, |message| {
                    let ToHost::Answer(answer) = message else { return };
                    outcome = sender.take(&answer).or(outcome.take());
                });
            }
        }
        if let Some(outcome) = outcome {
            assert_eq!(outcome, Outcome::Applied(Applied::Setting(Value::Count(index))));
        }
    }
    println!("{COMMANDS} commands, {repeats} repeats, {gave_up} without an answer");
    assert!(executed.is_sorted_by(|a, b| a < b), "each at most once, in order");
    assert!(executed.len() as u32 >= COMMANDS - gave_up && gave_up == 0 && repeats > 3000);
}

#[test]
fn a_stop_is_not_undone_by_a_late_play() {
    let mut session = Session::new(0);
    let id = hello(&mut session, 1).session;
    let numbered = |seq, item| Numbered { session: id, seq, item };
    let late = Outcome::Refused(Refusal::Late);
    assert_eq!(session.command(&numbered(1, Command::Stop)), Intake::Execute);
    let play = numbered(0, Command::Play(Feed::Live));
    for _ in 0..3 {
        assert_eq!(session.command(&play), Intake::Answer(numbered_answer(id, 0, late.clone())));
    }
    // During execution, and after it.
    let stop = numbered(1, Command::Stop);
    let working = numbered_answer(id, 1, Outcome::Working);
    assert_eq!(session.command(&stop), Intake::Answer(working));
    let done = session.answer(id, 1, Outcome::Applied(Applied::Done));
    assert_eq!(session.command(&stop), Intake::Answer(done));
}

/// An e-stop or a stop is always executed, for any session and any earlier command.
#[test]
fn a_stop_is_never_refused_for_its_number() {
    let mut session = Session::new(0);
    let id = hello(&mut session, 1).session;
    let numbered = |session, seq, item| Numbered { session, seq, item };
    assert_eq!(session.command(&numbered(id, 5000, Command::Hold)), Intake::Execute);
    for (session_of_it, seq) in [(id, 4999), (id, 3), (id ^ 1, 9), (0, 5000)] {
        for item in [Command::EStop, Command::Stop] {
            let stop = numbered(session_of_it, seq, item);
            assert_eq!(session.command(&stop), Intake::Execute, "{stop:?}");
            assert_eq!(Session::new(0).command(&stop), Intake::Execute);
        }
        // A hold of a foreign session would stiffen a rig that somebody guides by hand.
        let hold = numbered(session_of_it, seq, Command::Hold);
        assert!(matches!(session.command(&hold), Intake::Answer(_)), "{hold:?}");
    }
}

fn numbered_answer(session: u16, seq: u16, item: Outcome) -> Answer {
    Numbered { session, seq, item }
}

#[test]
fn sessions_are_told_apart() {
    let mut session = Session::new(3);
    let command = |id| Numbered { session: id, seq: 0, item: Command::Arm };
    let refused = |id| Intake::Answer(numbered_answer(id, 0, Outcome::Refused(Refusal::Session)));
    assert_eq!(session.command(&command(3)), refused(3), "nobody said hello");

    let first = hello(&mut session, 100);
    assert_eq!(session.command(&command(first.session)), Intake::Execute);
    // A repeated greeting continues the session.
    assert_eq!(hello(&mut session, 100), first);
    assert_ne!(session.command(&command(first.session)), Intake::Execute);
    // Another host, while the first host has the rig, and after it has gone.
    let other = Hello { protocol: Version::CURRENT, nonce: 200 };
    let busy = session.hello(other, ABOUT, true);
    // The refused host does not learn the number of the other session.
    assert_eq!((busy.verdict, busy.session), (Err(Misfit::Busy), 0));
    assert_eq!(session.id(), Some(first.session));
    let second = session.hello(other, ABOUT, false);
    assert_eq!(session.command(&command(first.session)), refused(first.session));
    assert_eq!(session.command(&command(second.session)), Intake::Execute);
    // A host with another version.
    let protocol = Version { major: 2, minor: 0 };
    let welcome = session.hello(Hello { protocol, nonce: 300 }, ABOUT, false);
    let misfit = Misfit::Version { controller: Version::CURRENT, host: protocol };
    assert_eq!(welcome.verdict, Err(misfit));
    assert_eq!(session.id(), Some(second.session));
    let heartbeat = Numbered { session: first.session, seq: 0, item: Stream::Heartbeat };
    assert_eq!(session.stream(&heartbeat), None);
}
