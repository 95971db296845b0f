//! OP3 walks on the emulated NUCLEO. Each packet on its bus is compared with the packet of the controller in this
//! process.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use sinew_board_client::{Board, Line};
use sinew_firmware::supervisor;
use sinew_link::Decoder;
use sinew_link::message::{Command, Feed, SnapshotPart, State, TelemetryParts, ToHost};
use sinew_nucleo::Burst;

use crate::in_process::{Exchange, InProcess};
use crate::test_rig::{Emulated, Rig, SECOND, TORQUE_OFF, arm_it, load, ready, until};

/// Duration of arming, s: the default of `arming_s`.
const ARMING_S: u32 = 1;
/// Additional delay, us, with which the chip may read its clock. Any short time would work.
const LATE_US: u64 = 10;

/// The packets of one tick of the chip.
#[derive(Default)]
struct Tick {
    /// Times at which the board began to send the tick's packets, ns.
    begins_ns: Vec<u64>,
    exchanges: Vec<Exchange>,
}

impl Tick {
    /// Returns the tick's packets, with the times at which they began to leave.
    fn leaves(&self) -> impl Iterator<Item = (u64, Option<&[u8]>)> {
        let sent = self.exchanges.iter().map(|exchange| Some(exchange.sent.as_slice()));
        self.begins_ns.iter().copied().zip(sent)
    }
}

/// Returns whether two packets are position goals (profile velocity and position, from register 112 on) that differ by
/// at most one count. Commands and answers are equal; only the clock differs, which the chip reads some us after the
/// start of its tick. The place where the clock changes a goal was not traced.
fn differ_by_a_count(own: &[u8], chip: &[u8]) -> bool {
    const HEAD: [u8; 5] = [0x83, 112, 0, 8, 0];
    let count = usize::from(u16::from_le_bytes([own[5], own[6]]) - 7) / 9;
    let goals = |packet: &[u8]| -> Vec<[u32; 2]> {
        let each = packet[12..].chunks_exact(9).take(count);
        let word = |part: &[u8]| u32::from_le_bytes(part.try_into().expect("four bytes"));
        each.map(|goal| [word(&goal[1..5]), word(&goal[5..9])]).collect()
    };
    let is_near = |(a, b): (&[u32; 2], &[u32; 2])| (0..2).all(|at| a[at].abs_diff(b[at]) <= 1);
    own.len() == chip.len()
        && [own, chip].iter().all(|packet| packet[7..12] == HEAD)
        && goals(own).iter().zip(&goals(chip)).all(is_near)
}

/// A board whose reported states are recorded, with the number of the tick.
struct Watched {
    board: Emulated,
    decoder: Decoder<ToHost>,
    states: Vec<(u32, State)>,
}

impl Line for Watched {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.board.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let len = self.board.receive(into, wait)?;
        self.decoder.feed(&into[..len], |message| {
            if let ToHost::Telemetry(telemetry) = message
                && let SnapshotPart::Summary(summary) = telemetry.part
            {
                self.states.push((telemetry.tick, summary.state));
            }
        });
        Ok(len)
    }

    fn now(&self) -> Duration {
        self.board.now()
    }
}

/// The chip's packets leave after it has computed them, not at the beginning of the tick. Servos therefore measure some
/// 100 us later than in this process, and a reading may differ in a digit. This test gives the controller in this
/// process the chip's times, and whether arming took one more tick, but nothing else from the chip. Then its packets
/// equal the chip's, and its servos answer with equal bytes. The only remaining difference is that of
/// [`differ_by_a_count`].
#[test]
#[ignore = "needs the emulator and SINEW_DATA: `cargo xtask emulate`"]
fn emulated_nucleo_walks_with_the_packets_of_the_controller_in_process() {
    let data: PathBuf = std::env::var_os("SINEW_DATA").expect("SINEW_DATA").into();
    let rig = Rig::walking_op3(&data);
    let flash = ready(&rig).line_mut().servos.machine.flash().unwrap();
    let board = rig.power_on(Some(&flash));
    let board = Watched { board, decoder: Decoder::new(), states: Vec::new() };
    let mut board = Board::connect(board, 1, 5 * SECOND).unwrap();
    perform(&mut board, &rig);
    assert!(board.log.faults.is_empty(), "{:?}", board.log.faults);
    assert_eq!(board.log.summary.unwrap().overruns, 0);
    let Watched { board, states, .. } = board.line_mut();
    let ticks = ticks(&rig, std::mem::take(&mut board.bus));

    // The time of lowering is measured with the clock, which the chip reads some us after its tick: it may take one
    // more tick.
    let limp = states.iter().rposition(|(_, state)| *state == State::Lowering).unwrap();
    let lowered = &ticks[..states[limp].0 as usize];
    // Likewise for the second of arming: if it took one more tick, the clock was read later at its start than at its
    // end.
    let began = |state| states.iter().find(|(_, of)| *of == state).expect("it was told").0;
    let (arming, holding) = (began(State::Arming), began(State::Holding));
    let is_longer = holding - arming > ARMING_S * rig.parts.rate_hz;
    let late_us = |number| if number == arming && is_longer { LATE_US } else { 0 };

    let (mut twin, mut rounded) = (InProcess::new(&rig), 0);
    for (number, tick) in (0..).zip(lowered) {
        let ours = twin.tick(command(states, number), late_us(number), &mut tick.leaves());
        assert_eq!(ours.len(), tick.exchanges.len(), "tick {number}");
        for (own, chip) in ours.iter().zip(&tick.exchanges) {
            assert_eq!(own.answered, chip.answered, "tick {number}");
            if own.sent != chip.sent {
                assert!(
                    differ_by_a_count(&own.sent, &chip.sent),
                    "tick {number}: {own:?}, {chip:?}"
                );
                rounded += 1;
            }
        }
    }
    for tick in &ticks[lowered.len()..lowered.len() + 2] {
        twin.tick(None, 0, &mut tick.leaves());
    }
    assert!(!twin.has_torque(), "the chip is limp");
    // At 0.5 rad/s, 330 counts a second, 10 us are 0.003 counts. With 20 goals in a tick, 6 % of the ticks have a goal
    // that is rounded differently.
    assert!(rounded < lowered.len() * 7 / 100, "{rounded} of {} ticks", lowered.len());

    let mut twin = InProcess::new(&rig);
    let [mut count, mut same, mut same_answers] = [0; 3];
    for (number, tick) in (0..).zip(lowered) {
        let begin_ns = ticks[0].begins_ns[0] + u64::from(number) * rig.tick_ns();
        let leaves = &mut std::iter::once((begin_ns, None));
        let ours = twin.tick(command(states, number), late_us(number), leaves);
        assert_eq!(ours.len(), tick.exchanges.len(), "tick {number}");
        count += ours.len();
        for (own, chip) in ours.iter().zip(&tick.exchanges) {
            same += usize::from(own.sent == chip.sent);
            same_answers += usize::from(own.answered == chip.answered);
        }
    }
    println!(
        "{} ticks of {} Hz, {count} packets: with the chip's times {} are the same, and all answers; with times of its own \
         {same}, and {same_answers} answers",
        lowered.len(),
        rig.parts.rate_hz,
        count - rounded
    );
}

/// Arms the rig as soon as possible, plays, and stops; returns when torque is off.
fn perform(board: &mut Board<Watched>, rig: &Rig) {
    load(board, rig);
    // Telemetry is sent in every tick.
    board.telemetry(f32::MAX, TelemetryParts::SUMMARY).unwrap();
    until(board, State::Limp, 5);
    arm_it(board);
    board.ask(Command::Play(Feed::Show)).unwrap();
    until(board, State::Playing, 1);
    until(board, State::Holding, 20);
    board.ask(Command::Stop).unwrap();
    // The way to rest takes 10 s at most, lowering 18 s.
    until(board, State::Limp, 30);
}

/// Returns the command that a tick executed, if its state differs from the state of the previous tick.
fn command(states: &[(u32, State)], number: u32) -> Option<supervisor::Command> {
    let at = states.iter().position(|(of, _)| *of == number)?;
    let [before, now] = [states.get(at.checked_sub(1)?)?, &states[at]];
    if before.1 == now.1 {
        return None;
    }
    assert_eq!(before.0 + 1, now.0, "nobody knows in which tick {:?} began", now.1);
    match now.1 {
        State::Arming => Some(supervisor::Command::Arm),
        State::Playing => Some(supervisor::Command::Play(supervisor::Feed::Show)),
        State::Stopping => Some(supervisor::Command::Stop),
        _ => None,
    }
}

/// Sorts the packets into ticks since the first, by their times.
fn ticks(rig: &Rig, bus: Vec<Burst>) -> Vec<Tick> {
    let (mut ticks, mut first_ns) = (Vec::<Tick>::new(), None);
    // Before the loop starts, the board sends torque off, twice at each of two rates.
    for Burst { is_own, end_ns, bytes } in bus.into_iter().skip(2 * 2 * TORQUE_OFF.len()) {
        if !is_own {
            let asked = ticks.last_mut().and_then(|tick| tick.exchanges.last_mut());
            asked.expect("servos answer").answered.extend(bytes);
            continue;
        }
        let begin_ns = end_ns - bytes.len() as u64 * 10_000_000_000 / u64::from(rig.baud());
        let first_ns = *first_ns.get_or_insert(begin_ns);
        // The first packet of a tick may leave up to a quarter of a tick earlier than in the first tick.
        let number = usize::try_from((begin_ns + rig.tick_ns() / 4 - first_ns) / rig.tick_ns());
        ticks.resize_with(ticks.len().max(number.expect("a test is short") + 1), Tick::default);
        let tick = ticks.last_mut().expect("there is one");
        tick.begins_ns.push(begin_ns);
        tick.exchanges.push(Exchange { sent: bytes, answered: Vec::new() });
    }
    ticks
}
