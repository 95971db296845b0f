//! A console in this program, on a simulated board whose commands are recorded.

use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use sinew_board_client::{Board, Line, nonce};
use sinew_console::local::{Reply, Request};
use sinew_console::{
    BeginRecord, Console, Ended, NewRecord, Options, OwnShow, OwnShows, RECORD_HZ, Records, Scene,
    Source, execute,
};
use sinew_link::message::{
    Answer, Command, LiveFrame, Numbered, Outcome, Refusal, Stream, ToController, ToHost,
};
use sinew_link::{Decoder, FRAME_MAX, encode};
use sinew_performance::play::{
    Chip, Drive, HostEnd, Memory, Options as Driven, Recorder, RigParts, SimulatedBoard, pipe,
};
use sinew_rig::{Description, new, toml_file};
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::plant::RigPlant;
use sinew_show::write::{Motion, Settings, write};
use sinew_show::{Joint, Rate};

const STACK_BYTES: usize = 64 << 20;
/// Name of the thread of a simulated board with its servos.
pub(crate) const BOARD: &str = "board";

/// Messages that a board has received: commands, speeds of jogs, and poses.
#[derive(Debug, Default)]
pub(crate) struct Told {
    pub(crate) commands: Vec<Command>,
    pub(crate) jogs: Vec<f32>,
    pub(crate) poses: Vec<Vec<f32>>,
}

/// A line that records the messages of the host.
pub(crate) struct Tapped<L> {
    line: L,
    decoder: Decoder<ToController>,
    told: Arc<Mutex<Told>>,
    /// Whether the board is too busy to arm: the line then answers in its place.
    is_busy: Arc<AtomicBool>,
    answers: Vec<u8>,
    /// Whether the board gets the first of all poses again and again.
    is_stuck: Arc<AtomicBool>,
    stuck_at: Option<LiveFrame>,
}

impl<L> Tapped<L> {
    /// Taps a line. The messages are stored in `told`.
    pub(crate) fn new(line: L, told: &Arc<Mutex<Told>>) -> Self {
        Self {
            line,
            decoder: Decoder::new(),
            told: Arc::clone(told),
            is_busy: Arc::default(),
            answers: Vec::new(),
            is_stuck: Arc::default(),
            stuck_at: None,
        }
    }
}

impl<L: Line> Line for Tapped<L> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut told = self.told.lock().unwrap();
        let (is_busy, answers) = (self.is_busy.load(Ordering::Relaxed), &mut self.answers);
        let (before, mut stuck) = (answers.len(), None);
        self.decoder.feed(bytes, |message| match message {
            ToController::Command(command) => {
                if is_busy && command.item == Command::Arm {
                    let (session, seq) = (command.session, command.seq);
                    let outcome = Outcome::Refused(Refusal::Busy);
                    let answer = ToHost::Answer(Answer { session, seq, item: outcome });
                    answers.extend(encode(&answer, &mut [0; FRAME_MAX]).unwrap());
                }
                told.commands.push(command.item);
            }
            ToController::Stream(stream) => match stream.item {
                Stream::Jog { velocity, .. } => told.jogs.push(velocity),
                Stream::Live(mut frame) => {
                    told.poses.push(frame.q.to_vec());
                    if self.is_stuck.load(Ordering::Relaxed) {
                        let first = self.stuck_at.get_or_insert_with(|| frame.clone());
                        frame.q.clone_from(&first.q);
                        let (session, seq, item) =
                            (stream.session, stream.seq, Stream::Live(frame));
                        let stream = ToController::Stream(Numbered { session, seq, item });
                        let bytes = encode(&stream, &mut [0; FRAME_MAX]).unwrap().to_vec();
                        stuck = Some(bytes);
                    }
                }
                _ => {}
            },
            ToController::Hello(_) => {}
        });
        drop(told);
        if self.answers.len() > before {
            return Ok(());
        }
        self.line.send(stuck.as_deref().unwrap_or(bytes))
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let count = self.answers.len().min(into.len());
        if count == 0 {
            return self.line.receive(into, wait);
        }
        for (to, from) in into.iter_mut().zip(self.answers.drain(..count)) {
            *to = from;
        }
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.line.now()
    }
}

/// Register of an XL330's goal position, and number of counts per turn.
const GOAL_POSITION: u16 = 116;
const TURN_COUNTS: f64 = 4096.0;
/// Register of an XL330 that switches torque.
const TORQUE_ENABLE: u16 = 64;

/// Goals and speeds of the first servo.
#[derive(Debug, Default)]
pub(crate) struct AtServo {
    /// Time of the last tick: that of this machine, or of an emulated chip.
    pub(crate) now: Duration,
    /// Goal in the last tick, deg; `None` if torque was off.
    pub(crate) goal_deg: Option<f64>,
    /// Times at which the goal last decreased, and last increased.
    pub(crate) changed: [Duration; 2],
    /// Largest step of the goal between two ticks with torque, deg; and largest speed of the shaft, deg/s.
    pub(crate) step_deg: f64,
    pub(crate) speed_deg_s: f64,
    /// Sum of all absolute changes of the goal, deg.
    pub(crate) way_deg: f64,
}

impl AtServo {
    pub(crate) fn look(&mut self, servo: &Servo<'_>, now: Duration) {
        let has_torque = servo.get(TORQUE_ENABLE) != 0;
        let goal_deg = f64::from(servo.get(GOAL_POSITION)) * 360.0 / TURN_COUNTS;
        let goal_deg = has_torque.then_some(goal_deg);
        if let (Some(before), Some(goal)) = (self.goal_deg, goal_deg) {
            self.step_deg = self.step_deg.max((goal - before).abs());
            self.way_deg += (goal - before).abs();
            let speed = servo.shaft().velocity_rad_s.to_degrees().abs();
            self.speed_deg_s = self.speed_deg_s.max(speed);
            if (goal - before).abs() > 0.0 {
                self.changed[usize::from(goal > before)] = now;
            }
        }
        (self.goal_deg, self.now) = (goal_deg, now);
    }
}

/// A console that serves pages until it is dropped.
pub(crate) struct OtherSide {
    /// Address of the page, without the token.
    pub(crate) host: String,
    /// Name by which other commands find the console.
    pub(crate) name: String,
    pub(crate) token: String,
    pub(crate) told: Arc<Mutex<Told>>,
    pub(crate) servo: Arc<Mutex<AtServo>>,
    pub(crate) is_busy: Arc<AtomicBool>,
    pub(crate) is_stuck: Arc<AtomicBool>,
    /// Start of this machine's time; `None` if the board has the time of an emulated chip.
    start: Option<Instant>,
    stops: Arc<AtomicU32>,
    hub: Option<JoinHandle<Ended>>,
    board: Option<JoinHandle<()>>,
}

impl OtherSide {
    /// Starts a console for an arm of one joint, which turns about the vertical. `with_show`: whether a show of 0.6 s
    /// is on the board.
    pub(crate) fn start(with_show: bool) -> Self {
        Self::start_on(new::arm(1).unwrap(), None, with_show)
    }

    /// Starts an arm of one joint with its servo in position mode, in which goals are positions.
    pub(crate) fn start_on_positions() -> Self {
        Self::start_on(new::arm(1).unwrap(), Some(Drive::Position), false)
    }

    /// Starts a simulated board with this rig, and a console on it. `drive`: drive of all servos, instead of the
    /// default.
    pub(crate) fn start_on(arm: Description, drive: Option<Drive>, with_show: bool) -> Self {
        Self::start_in(None, arm, drive, with_show)
    }

    /// Starts a console whose pages record into `session.parquet` in a folder; without a folder, they cannot record.
    pub(crate) fn start_in(
        folder: Option<PathBuf>,
        arm: Description,
        drive: Option<Drive>,
        with_show: bool,
    ) -> Self {
        let toml = toml_file::write(&arm);
        let Prepared { parts, scene, line, told, is_busy, servo, start, board } =
            Prepared::new(arm, drive);
        let is_stuck = Arc::clone(&line.is_stuck);
        let rig = parts.rig_crc();
        let own = if with_show {
            OwnShows { shows: vec![nod(rig)], idle: Some(sway(rig)) }
        } else {
            OwnShows::default()
        };
        let hub = move |served: Served<'_>| {
            let mut board = Board::connect(line, nonce(), Duration::from_secs(20)).unwrap();
            let begin = folder.map(|folder| -> BeginRecord<'_> {
                Box::new(move || {
                    let file = folder.join("session.parquet");
                    let recorder = Recorder::new(&file, (&parts, RECORD_HZ), &toml, &[]);
                    let recorder = recorder.map_err(|error| error.to_string())?;
                    Ok(NewRecord { recorder, file: file.display().to_string() })
                })
            });
            served.run(&mut board, &scene, own, Records { first: None, begin })
        };
        let mut console = Self::serve(hub, told, servo);
        (console.is_busy, console.is_stuck) = (is_busy, is_stuck);
        (console.start, console.board) = (Some(start), Some(board));
        console
    }

    /// Starts a console in a thread of its own. `hub` connects to a board, and runs the console that it is given.
    pub(crate) fn serve(
        hub: impl FnOnce(Served<'_>) -> Ended + Send + 'static,
        told: Arc<Mutex<Told>>,
        servo: Arc<Mutex<AtServo>>,
    ) -> Self {
        let console = Console::open(Options::default()).unwrap();
        let address = console.addresses().remove(0);
        let (host, token) = address.strip_prefix("http://").unwrap().split_once("/#").unwrap();
        let (host, token) = (host.to_owned(), token.to_owned());
        let stops = Arc::new(AtomicU32::new(0));
        let counted = Arc::clone(&stops);
        let name = format!("test-{}-{}", std::process::id(), host.replace([':', '.'], "-"));
        let own_name = name.clone();
        let builder = thread::Builder::new().stack_size(STACK_BYTES);
        let run = move || hub(Served { console, name: &own_name, stops: &counted });
        Self {
            host,
            name,
            token,
            told,
            servo,
            is_busy: Arc::default(),
            is_stuck: Arc::default(),
            start: None,
            stops,
            hub: Some(builder.spawn(run).unwrap()),
            board: None,
        }
    }

    /// Returns the time of the board's clock, as [`AtServo`] has it.
    pub(crate) fn now(&self) -> Duration {
        self.start.map_or_else(|| self.servo.lock().unwrap().now, |start| start.elapsed())
    }

    /// Returns whether the board got a command.
    pub(crate) fn was_told(&self, command: &Command) -> bool {
        self.told.lock().unwrap().commands.contains(command)
    }

    /// Ends the console with a signal, and returns how it ended.
    pub(crate) fn end(mut self) -> Ended {
        self.stops.store(1, Ordering::Relaxed);
        self.hub.take().unwrap().join().unwrap()
    }
}

/// An open console that has no board yet.
pub(crate) struct Served<'a> {
    console: Console,
    name: &'a str,
    stops: &'a AtomicU32,
}

impl Served<'_> {
    pub(crate) fn run<L: Line>(
        self,
        board: &mut Board<L>,
        scene: &Scene,
        own: OwnShows,
        records: Records<'_>,
    ) -> Ended {
        let stops = || self.stops.load(Ordering::Relaxed);
        self.console.run(board, scene, (self.name, own, records), &stops).unwrap()
    }
}

/// A simulated board that waits for its host.
pub(crate) struct Prepared {
    parts: Arc<RigParts>,
    scene: Scene,
    line: Tapped<HostEnd>,
    pub(crate) told: Arc<Mutex<Told>>,
    pub(crate) is_busy: Arc<AtomicBool>,
    servo: Arc<Mutex<AtServo>>,
    start: Instant,
    board: JoinHandle<()>,
}

impl Prepared {
    pub(crate) fn new(arm: Description, drive: Option<Drive>) -> Self {
        let mechanism = arm.mechanism().unwrap();
        let driven = Driven { is_of_board: true, drive, ..Driven::default() };
        let parts = Arc::new(RigParts::new(&arm, &mechanism, driven).unwrap());
        let scene = Scene::new(&arm.name, &mechanism, &parts, Source::Simulated);
        let (line, end) = pipe();
        let servo: Arc<Mutex<AtServo>> = Arc::default();
        let (seen, start) = (Arc::clone(&servo), Instant::now());
        let look = move |board: &mut SimulatedBoard<'_, RigPlant>| {
            let now = start.elapsed();
            board.look_at_servos(|servos| seen.lock().unwrap().look(&servos[0], now));
        };
        let own = Arc::clone(&parts);
        let simulate = move || {
            let parts = own;
            let chip = Chip::blank();
            SimulatedBoard::<RigPlant>::store_rig(&parts, &chip).unwrap();
            let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
            let plant = parts.plant(&arm, &mechanism).unwrap();
            let mut board = SimulatedBoard::new(&parts, &mut memories, plant, chip).unwrap();
            // It ends when its host is gone.
            let _ = board.serve(end, &AtomicBool::new(false), look);
        };
        let builder = thread::Builder::new().name(BOARD.to_owned()).stack_size(STACK_BYTES);
        let board = builder.spawn(simulate).unwrap();
        let told = Arc::default();
        let line = Tapped::new(line, &told);
        let is_busy = Arc::clone(&line.is_busy);
        Self { parts, scene, line, told, is_busy, servo, start, board }
    }

    /// Executes a command of another terminal on a board without a console.
    pub(crate) fn execute(self, name: &str, request: &Request) -> Reply {
        let mut board = Board::connect(self.line, nonce(), Duration::from_secs(20)).unwrap();
        let reply = execute(&mut board, &self.scene, (name, request), &|| 0).unwrap();
        drop(board);
        self.board.join().unwrap();
        reply
    }
}

impl Drop for OtherSide {
    fn drop(&mut self) {
        self.stops.store(2, Ordering::Relaxed);
        let joined = self.hub.take().map(JoinHandle::join);
        let simulated = self.board.take().map(JoinHandle::join);
        if !thread::panicking() {
            assert!(joined.is_none_or(|joined| joined.is_ok()));
            assert!(simulated.is_none_or(|joined| joined.is_ok()));
        }
    }
}

/// Writes a show in which the joint turns by 0.1 rad and back.
fn nod(rig: u32) -> OwnShow {
    let q = (0..=60).map(|k| 0.05 - 0.05 * (0.104_719_755 * f64::from(k)).cos());
    show("nod", &q.collect::<Vec<_>>(), rig, false)
}

/// Writes a loop of 8 s in which the joint swings by 0.06 rad about -0.1 rad.
fn sway(rig: u32) -> OwnShow {
    let q = (0..=800).map(|k| -0.1 + 0.06 * (std::f64::consts::TAU * f64::from(k) / 800.0).sin());
    show("sway", &q.collect::<Vec<_>>(), rig, true)
}

fn show(name: &str, q: &[f64], rig: u32, is_loop: bool) -> OwnShow {
    let motion = Motion {
        joints: &[Joint::Fixed, Joint::Revolute],
        q,
        rate: Rate { samples: 100, seconds: 1 },
        is_loop,
        rig,
        cues: if is_loop { &[] } else { &[(30, "far")] },
        time_code: None,
        course: &[],
    };
    let written = write(&motion, &Settings::default()).unwrap();
    OwnShow { name: name.to_owned(), bytes: written.bytes.into(), sound: None }
}
