//! Tests of the client with a whole board, in simulated time.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;
use std::{fmt, io};

use sinew_board_client::{Board, BoardServos, ClientError, Line, item};
use sinew_firmware::node::{RIG_SCHEMA, SHOW_SCHEMA};
use sinew_firmware::supervisor::State as Of;
use sinew_link::message::{
    Applied, Command, Feed, Hello, Kind, Misfit, Numbered, Refusal, State, Stream, TelemetryParts,
    ToController, ToHost, Version,
};
use sinew_link::{Decoder, FRAME_MAX, encode};
use sinew_retarget::feasibility::RigMotion;
use sinew_rig::Description;
use sinew_rig::new::{arm, face};
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;
use sinew_servo_tools::{Client, Protocol, ServiceError, Settings};
use sinew_show::write::Settings as ShowSettings;

use super::{Chip, SimulatedBoard};
use crate::play::{Drive, Memory, Options, RigParts};
use crate::{Baker, ShowMarks};

const SECOND: Duration = Duration::from_secs(1);

/// A board that its client and the test share; the link may be cut.
struct Shared<'a> {
    board: Rc<RefCell<SimulatedBoard<'a, RigPlant>>>,
    is_cut: Rc<RefCell<bool>>,
    /// Whether the wire from the board is cut.
    is_deaf: Rc<RefCell<bool>>,
}

impl fmt::Debug for Shared<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Shared").field("is_cut", &self.is_cut).finish_non_exhaustive()
    }
}

impl Shared<'_> {
    fn check(&self) -> io::Result<()> {
        if *self.is_cut.borrow() { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(()) }
    }
}

impl Line for Shared<'_> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.check()?;
        self.board.borrow_mut().send(bytes)
    }
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        self.check()?;
        let count = self.board.borrow_mut().receive(into, wait)?;
        Ok(if *self.is_deaf.borrow() { 0 } else { count })
    }
    fn now(&self) -> Duration {
        self.board.borrow().now()
    }
}

struct Desk<'a> {
    client: Board<Shared<'a>>,
    board: Rc<RefCell<SimulatedBoard<'a, RigPlant>>>,
    is_cut: Rc<RefCell<bool>>,
    is_deaf: Rc<RefCell<bool>>,
    parts: &'a RigParts,
    /// A show of one second.
    show: Vec<u8>,
}

/// Gives a test an arm of three servos on a board, with its rig stored or blank.
fn on_desk(is_blank: bool, test: impl FnOnce(Desk<'_>) + Send) {
    rig_on_desk(&arm(3).unwrap(), Options::default(), is_blank, test);
}

fn rig_on_desk(
    rig: &Description,
    options: Options,
    is_blank: bool,
    test: impl FnOnce(Desk<'_>) + Send,
) {
    let run = || {
        let mechanism = rig.mechanism().unwrap();
        let parts = RigParts::new(rig, &mechanism, options).unwrap();
        let motion = RigMotion { dt_s: 0.1, rows: vec![mechanism.home(); 11] };
        let (rig_crc, settings) = (parts.rig_crc(), ShowSettings::default());
        let baker = Baker { mechanism: &mechanism, rig: rig_crc, settings };
        let show = baker.bake(&motion, &ShowMarks::default());
        let show = show.unwrap().written.bytes;
        let chip = Chip::blank();
        if !is_blank {
            SimulatedBoard::<RigPlant>::store_rig(&parts, &chip).unwrap();
        }
        let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
        let plant = parts.plant(rig, &mechanism).unwrap();
        let board = SimulatedBoard::new(&parts, &mut memories, plant, chip).unwrap();
        let board = Rc::new(RefCell::new(board));
        let is_cut = Rc::new(RefCell::new(false));
        let is_deaf = Rc::new(RefCell::new(false));
        let line = Shared {
            board: Rc::clone(&board),
            is_cut: Rc::clone(&is_cut),
            is_deaf: Rc::clone(&is_deaf),
        };
        let client = Board::connect(line, 7, SECOND).unwrap();
        test(Desk { client, board, is_cut, is_deaf, parts: &parts, show });
    };
    std::thread::scope(|scope| {
        let builder = std::thread::Builder::new().stack_size(64 << 20);
        builder.spawn_scoped(scope, run).unwrap().join().unwrap();
    });
}

impl Desk<'_> {
    fn until(&mut self, state: State) {
        let end = self.client.now() + 30 * SECOND;
        while self.client.now() < end {
            if self.client.fresh_state(SECOND).unwrap() == state {
                return;
            }
        }
        panic!("{state} does not come: {:?}", self.client.log);
    }

    /// Uploads the desk's show, arms, and plays it.
    fn begin_show(&mut self) {
        let show = self.show.clone();
        let of_show = item(Kind::Show, SHOW_SCHEMA, &show, self.parts.rig_crc(), "Ada").unwrap();
        self.client.upload(&of_show, &show, &mut |_| ()).unwrap();
        self.client.ask(Command::LoadShow { slot: 0 }).unwrap();
        self.arm();
        self.client.ask(Command::Play(Feed::Show)).unwrap();
        self.until(State::Playing);
    }

    /// Returns the states of a board without a host until it is limp or faulted, each with its start time, ms.
    fn states(&self) -> Vec<(Of, u64)> {
        let mut board = self.board.borrow_mut();
        let begun_us = board.now_us();
        let mut came = Vec::new();
        while board.now_us() < begun_us + 20_000_000
            && !matches!(board.state(), Some(Of::Faulted | Of::Limp))
        {
            board.tick();
            let state = board.state().unwrap();
            if came.last().is_none_or(|(last, _)| *last != state) {
                came.push((state, (board.now_us() - begun_us) / 1000));
            }
        }
        came
    }

    /// Uploads the desk's show, which the board does not have, arms, and plays it to its end.
    fn play_show(&mut self) {
        let of_show =
            item(Kind::Show, SHOW_SCHEMA, &self.show, self.parts.rig_crc(), "Ada").unwrap();
        assert_eq!(self.client.slot_of(&of_show).unwrap(), None);
        self.client.upload(&of_show, &self.show, &mut |_| ()).unwrap();
        let slot = self.client.slot_of(&of_show).unwrap().unwrap();
        self.client.ask(Command::LoadShow { slot }).unwrap();
        self.arm();
        self.client.ask(Command::Play(Feed::Show)).unwrap();
        self.until(State::Playing);
        self.until(State::Holding);
    }

    fn arm(&mut self) {
        self.client.telemetry(20.0, TelemetryParts::SUMMARY).unwrap();
        self.until(State::Limp);
        let end = self.client.now() + 10 * SECOND;
        while self.client.now() < end {
            match self.client.ask(Command::Arm) {
                Ok(_) => return self.until(State::Holding),
                Err(ClientError::Refused(_)) => self.client.run(SECOND / 10).unwrap(),
                Err(error) => panic!("{error}"),
            }
        }
        panic!("it cannot be armed");
    }
}

#[test]
fn a_blank_board_takes_a_rig_and_a_show_and_plays_it() {
    on_desk(true, |mut desk| {
        assert_eq!(desk.client.about().rig, 0);
        let rig = desk.parts.board_rig().unwrap();
        let of_rig = item(Kind::Rig, RIG_SCHEMA, &rig, 0, "Ada").unwrap();
        let mut seen = Vec::new();
        desk.client.upload(&of_rig, &rig, &mut |next| seen.push(next)).unwrap();
        assert!(seen.is_sorted() && seen.last() == Some(&of_rig.length), "{seen:?}");
        assert_eq!(desk.client.about().rig, desk.parts.rig_crc());
        assert_eq!(desk.board.borrow().starts(), 2);
        desk.play_show();
        // Nothing is stored while the rig is armed.
        let refused = desk.client.set_setting(6, 3.0).unwrap_err();
        assert!(matches!(refused, ClientError::Refused(Refusal::State(State::Holding))));
        desk.client.ask(Command::Stop).unwrap();
        desk.until(State::Limp);
        assert!(desk.client.log.faults.is_empty(), "{:?}", desk.client.log.faults);
        desk.client.set_setting(6, 3.0).unwrap();
        desk.client.reconnect(SECOND).unwrap();
        assert!((desk.client.setting(6).unwrap() - 3.0).abs() < 1e-6);
        // Its own supply was checked while torque was on: the counter belongs to one start.
        assert!(matches!(desk.client.ask(Command::ReadHealth), Ok(Applied::Health(_))));
    });
}

/// Servos without a current sensor. A board closes their loop by their PWM.
#[test]
fn a_board_drives_by_voltage_what_a_wiring_says_so_of() {
    let mut rig = arm(3).unwrap();
    rig.servos.iter_mut().for_each(|servo| "XL430-W250-T".clone_into(&mut servo.model));
    rig.supply = None;
    let options = Options { drive: Some(Drive::Voltage), ..Options::of_board() };
    rig_on_desk(&rig, options, false, |mut desk| {
        desk.play_show();
        desk.client.ask(Command::Stop).unwrap();
        desk.until(State::Limp);
        assert!(desk.client.log.faults.is_empty(), "{:?}", desk.client.log.faults);
    });
}

#[test]
fn versions_that_do_not_fit_are_both_named() {
    on_desk(false, |desk| {
        let Desk { client, board, is_cut, is_deaf, .. } = desk;
        drop(client);
        let board = Rc::into_inner(board).unwrap().into_inner();
        let newer = Version { major: 2, minor: 3 };
        let board = Rc::new(RefCell::new(board.speaking(newer).unwrap()));
        let error = Board::connect(Shared { board, is_cut, is_deaf }, 8, SECOND).unwrap_err();
        assert!(matches!(error, ClientError::Misfit(Misfit::Version { .. })), "{error}");
        let text = error.to_string();
        assert!(text.contains("2.3") && text.contains(&Version::CURRENT.to_string()), "{text}");
    });
}

/// Only the wire from the board is cut. The host sends `Stop` and then nothing. A host that continued to send would
/// keep the rig armed.
#[test]
fn a_host_that_hears_nothing_stops_the_rig_and_is_silent() {
    on_desk(false, |mut desk| {
        desk.begin_show();
        *desk.is_deaf.borrow_mut() = true;
        let begun = desk.client.now();
        let error = loop {
            match desk.client.step(SECOND / 20) {
                Ok(()) => assert!(desk.client.now() < begun + 2 * SECOND, "it goes on"),
                Err(error) => break error,
            }
        };
        let text = error.to_string();
        assert!(matches!(error, ClientError::Deaf(silence) if silence == SECOND), "{text}");
        assert!(text.contains("for 1 s") && text.contains("wire"), "{text}");
        // The last message is less than one period of telemetry old.
        let ended = desk.client.now().saturating_sub(begun);
        assert!((SECOND * 19 / 20..SECOND * 6 / 5).contains(&ended), "{ended:?}");
        assert_eq!(desk.board.borrow().state(), Some(Of::Stopping));
        // Afterwards the client sends nothing, whatever the program asks for, except an emergency stop by a person.
        for error in [
            desk.client.step(SECOND).unwrap_err(),
            desk.client.ask(Command::Hold).unwrap_err(),
            desk.client.run(SECOND).unwrap_err(),
        ] {
            assert!(matches!(error, ClientError::Deaf(_)), "{error}");
        }
        let came = desk.states();
        // From the way to the rest pose, or from there, the rig is lowered, then limp. At last the link is lost.
        let names: Vec<Of> = came.iter().map(|(state, _)| *state).collect();
        assert!(names.starts_with(&[Of::Stopping, Of::Lowering]), "{came:?}");
        assert!(matches!(names.last(), Some(Of::Faulted | Of::Limp)), "{came:?}");
    });
}

/// A host that is older than the acknowledgement continues although it receives nothing: its heartbeats keep the rig
/// armed. If a host announces acknowledgements but sends none, the board ends its session.
#[test]
fn a_board_ends_the_session_of_a_host_that_acknowledges_nothing() {
    for (minor, ends) in [(1, false), (2, true)] {
        on_desk(false, |desk| {
            let Desk { client, board, is_cut, is_deaf, .. } = desk;
            drop((client, is_cut, is_deaf));
            let mut board = Rc::into_inner(board).unwrap().into_inner();
            let mut bytes = [0; FRAME_MAX];
            let mut say = |board: &mut SimulatedBoard<'_, RigPlant>, message: ToController| {
                board.give(encode(&message, &mut bytes).unwrap());
            };
            let protocol = Version { minor, ..Version::CURRENT };
            say(&mut board, ToController::Hello(Hello { protocol, nonce: 99 }));
            (0..4).for_each(|_| board.tick());
            let session = welcomed(&mut board);
            let (mut seq, begun_us) = (0, board.now_us());
            let mut came = Vec::new();
            while board.now_us() < begun_us + 20_000_000 {
                let beat = Numbered { session, seq, item: Stream::Heartbeat };
                say(&mut board, ToController::Stream(beat));
                if board.state() == Some(Of::Limp) && seq < 60 {
                    let arm = Numbered { session, seq, item: Command::Arm };
                    say(&mut board, ToController::Command(arm));
                }
                seq += 1;
                (0..20).for_each(|_| board.tick());
                let state = board.state().unwrap();
                if came.last().is_none_or(|(last, _)| *last != state) {
                    came.push((state, board.now_us() - begun_us));
                }
            }
            let at = |of| came.iter().find(|(state, _)| *state == of).map(|(_, us)| *us);
            assert!(at(Of::Holding).is_some(), "{came:?}");
            let [armed, stopped] = [Of::Arming, Of::Stopping].map(at);
            assert_eq!(stopped.is_some(), ends, "1.{minor}: {came:?}");
            assert_eq!(board.state(), Some(if ends { Of::Faulted } else { Of::Holding }));
            if let (Some(armed), Some(stopped)) = (armed, stopped) {
                let after_s = (stopped - armed) as f64 * 1e-6;
                assert!((1.9..2.4).contains(&after_s), "{came:?}");
            }
        });
    }
}

/// Returns the session in the last welcome of the board.
fn welcomed(board: &mut SimulatedBoard<'_, RigPlant>) -> u16 {
    let (mut decoder, mut bytes) = (Decoder::<ToHost>::new(), vec![0; 1 << 16]);
    let count = board.receive(&mut bytes, Duration::ZERO).unwrap();
    let mut session = None;
    decoder.feed(&bytes[..count], |message| {
        if let ToHost::Welcome(welcome) = message {
            session = Some(welcome.session);
        }
    });
    session.unwrap()
}

/// A board without its host holds, lowers the rig, and is limp.
#[test]
fn a_board_that_is_unplugged_holds_and_then_is_limp() {
    on_desk(false, |mut desk| {
        desk.begin_show();
        *desk.is_cut.borrow_mut() = true;
        let error = desk.client.step(SECOND).unwrap_err().to_string();
        assert!(error.contains("unplugged") && error.contains("torque is switched off"), "{error}");
        let came = desk.states();
        let at = |of: Of| came.iter().find(|(state, _)| *state == of).map(|(_, ms)| *ms);
        let [holds, lowers] = [Of::Holding, Of::Lowering].map(|of| at(of).unwrap());
        // There is a heartbeat every 50 ms, and the last may be that old.
        assert!((150..=210).contains(&holds), "{came:?}");
        assert!((1950..=2010).contains(&lowers), "{came:?}");
        // Torque is off, and the lost link is latched as a fault.
        assert!(at(Of::Faulted).is_some(), "{came:?}");
    });
}

#[test]
fn servos_are_reached_through_a_limp_board_alone() {
    on_desk(false, |mut desk| {
        desk.client.telemetry(20.0, TelemetryParts::SUMMARY).unwrap();
        desk.until(State::Limp);
        let baud = desk.parts.lines[0].baud;
        let settings = Settings { patience: Duration::from_millis(3), tries: 2 };
        let line = BoardServos::new(desk.client, 0).unwrap();
        let mut client = Client::new(line, Protocol::Dynamixel, baud, settings).unwrap();
        // The model number, and the time until the answer.
        assert_eq!(client.read_bytes(1, 0, 2).unwrap().0.len(), 2);
        let took = client.line_mut().took();
        assert!(took > Duration::ZERO && took < Duration::from_millis(2), "{took:?}");
        // More than fits into one message of the host link.
        assert_eq!(client.read_bytes(1, 0, 147).unwrap().0.len(), 147);
        assert!(matches!(client.read_bytes(77, 0, 2), Err(ServiceError::Silent { id: 77, .. })));
        // At another rate no servo answers; afterwards the line has its own rate again.
        client.set_baud(57_600).unwrap();
        assert!(client.read_bytes(1, 0, 2).is_err());
        let mut second = BoardServos::new(client.into_line().into_board(), 1).unwrap();
        let none =
            sinew_servo_tools::Exchange::set_baud(&mut second, baud).unwrap_err().to_string();
        assert!(none.contains("no such line"), "{none}");
        desk.client = second.into_board();
        desk.arm();
        let line = BoardServos::new(desk.client, 0).unwrap();
        let armed = Client::new(line, Protocol::Dynamixel, baud, settings).unwrap_err().to_string();
        assert!(armed.contains("the rig is holding"), "{armed}");
    });
}

/// A Dynamixel packet begins with 0xFF: the chip would interpret it as a write to its registers.
#[test]
fn no_packet_is_passed_on_to_a_chip_that_makes_pulses() {
    rig_on_desk(&face(), Options::default(), false, |mut desk| {
        desk.client.telemetry(20.0, TelemetryParts::SUMMARY).unwrap();
        desk.until(State::Limp);
        let mut chip = BoardServos::new(desk.client, 0).unwrap();
        let none =
            sinew_servo_tools::Exchange::set_baud(&mut chip, 1_000_000).unwrap_err().to_string();
        assert!(none.contains("no such line"), "{none}");
        desk.client = chip.into_board();
        desk.arm();
    });
}
