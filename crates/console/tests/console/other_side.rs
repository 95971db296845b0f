//! A console in this program, on a simulated board whose commands are recorded.

use std::io;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use sinew_board_client::{Board, Line, nonce};
use sinew_console::{Console, Ended, Options, OwnShow, Scene, Source};
use sinew_link::Decoder;
use sinew_link::message::{Command, Stream, ToController};
use sinew_performance::play::{
    Chip, HostEnd, Memory, Options as Driven, RigParts, SimulatedBoard, pipe,
};
use sinew_rig::{Description, new};
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;
use sinew_show::write::{Motion, Settings, write};
use sinew_show::{Joint, Rate};

const STACK_BYTES: usize = 64 << 20;

/// All that a board got: commands, speeds of jogs, and poses.
#[derive(Debug, Default)]
pub(crate) struct Told {
    pub(crate) commands: Vec<Command>,
    pub(crate) jogs: Vec<f32>,
    pub(crate) poses: Vec<Vec<f32>>,
}

/// A line that records the messages of the host.
struct Tapped {
    line: HostEnd,
    decoder: Decoder<ToController>,
    told: Arc<Mutex<Told>>,
}

impl Line for Tapped {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut told = self.told.lock().unwrap();
        self.decoder.feed(bytes, |message| match message {
            ToController::Command(command) => told.commands.push(command.item),
            ToController::Stream(stream) => match stream.item {
                Stream::Jog { velocity, .. } => told.jogs.push(velocity),
                Stream::Live(frame) => told.poses.push(frame.q.to_vec()),
                _ => {}
            },
            ToController::Hello(_) => {}
        });
        drop(told);
        self.line.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        self.line.receive(into, wait)
    }

    fn now(&self) -> Duration {
        self.line.now()
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
    stops: Arc<AtomicU32>,
    hub: Option<JoinHandle<Ended>>,
    board: Option<JoinHandle<()>>,
}

impl OtherSide {
    /// Starts a console for an arm of one joint, which turns about the vertical. `with_show`: whether a show of 0.6 s
    /// is on the board.
    pub(crate) fn start(with_show: bool) -> Self {
        Self::start_rig(new::arm(1).unwrap(), with_show)
    }

    /// Starts a rig. A show is for a rig of one joint.
    pub(crate) fn start_rig(arm: Description, with_show: bool) -> Self {
        let mechanism = arm.mechanism().unwrap();
        let driven = Driven { is_of_board: true, ..Driven::default() };
        let parts = Arc::new(RigParts::new(&arm, &mechanism, driven).unwrap());
        let scene = Scene::new(&arm.name, &mechanism, &parts, Source::Simulated);
        let shows = if with_show { vec![nod(parts.rig_crc())] } else { Vec::new() };
        let (line, end) = pipe();
        let simulate = move || {
            let chip = Chip::blank();
            SimulatedBoard::<RigPlant>::store_rig(&parts, &chip).unwrap();
            let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
            let plant = parts.plant(&arm, &mechanism).unwrap();
            let mut board = SimulatedBoard::new(&parts, &mut memories, plant, chip).unwrap();
            // It ends when its host is gone.
            let _ = board.serve(end, &AtomicBool::new(false), |_| {});
        };
        let builder = thread::Builder::new().stack_size(STACK_BYTES);
        let board = builder.spawn(simulate).unwrap();
        let console = Console::open(Options::default()).unwrap();
        let address = console.addresses().remove(0);
        let (host, token) = address.strip_prefix("http://").unwrap().split_once("/#").unwrap();
        let (told, stops) = (Arc::new(Mutex::new(Told::default())), Arc::new(AtomicU32::new(0)));
        let line = Tapped { line, decoder: Decoder::new(), told: Arc::clone(&told) };
        let counted = Arc::clone(&stops);
        let name = format!("test-{}-{}", std::process::id(), host.replace([':', '.'], "-"));
        let own_name = name.clone();
        let hub = thread::spawn(move || {
            let mut board = Board::connect(line, nonce(), Duration::from_secs(20)).unwrap();
            let stops = || counted.load(Ordering::Relaxed);
            console.run(&mut board, &scene, (&name, shows), &stops).unwrap()
        });
        let (host, token) = (host.to_owned(), token.to_owned());
        Self { host, name: own_name, token, told, stops, hub: Some(hub), board: Some(board) }
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
    let q: Vec<f64> =
        (0..=60).map(|k| 0.05 - 0.05 * (0.104_719_755 * f64::from(k)).cos()).collect();
    let motion = Motion {
        joints: &[Joint::Fixed, Joint::Revolute],
        q: &q,
        rate: Rate { samples: 100, seconds: 1 },
        is_loop: false,
        rig,
        cues: &[(30, "far")],
        time_code: None,
        course: &[],
    };
    let written = write(&motion, &Settings::default()).unwrap();
    OwnShow { name: "nod".to_owned(), bytes: written.bytes.into(), sound: None }
}
