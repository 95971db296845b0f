//! Idle life with shows between, with a whole console and a simulated board, faster than real time. It is observed at
//! the servos: their goals keep all limits and never jump, no two windows of 10 s of idle life are alike, and CPU time
//! and memory do not grow.

use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use serde_json::json;
use sinew_board_client::{Board, Line, nonce};
use sinew_console::{Console, Options, OwnShow, OwnShows, Records, Scene, Source};
use sinew_life::idle::{IdleSettings, idle};
use sinew_performance::play::{Chip, Memory, Options as Driven, RigParts, SimulatedBoard};
use sinew_rig::Mechanism;
use sinew_rig::new::face;
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_servo_sim::plant::RigPlant;
use sinew_show::write::{Motion, Settings, write};
use sinew_show::{Joint, Rate};

use crate::alike::most_alike;
use crate::client::{HOLDING, Page};
use crate::many::{memory_kb, seconds};
use crate::pulsed_servos::{PulsedServos, RATE_HZ};

/// Environment variable with the simulated time, s.
const SECONDS: &str = "SINEW_IDLE_S";
/// Longest time between two shows, s; and duration of a show, s.
const BETWEEN_S: f64 = 300.0;
const SHOW_S: f64 = 6.0;
/// Time after a show in which the rig returns to the loop, s. It is not compared.
const BACK_S: f64 = 15.0;
/// Largest permitted correlation of two windows of 10 s.
const ALIKE_MAX: f64 = 0.95;
const STACK_BYTES: usize = 64 << 20;

/// A board in simulated time, whose servos are observed in each tick.
struct Observed<'a> {
    board: SimulatedBoard<'a, RigPlant>,
    servos: Arc<Mutex<PulsedServos>>,
}

impl std::fmt::Debug for Observed<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Observed").finish_non_exhaustive()
    }
}

impl Line for Observed<'_> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.board.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let end = self.now() + wait;
        loop {
            let count = self.board.receive(into, Duration::ZERO)?;
            if count > 0 || self.now() >= end {
                return Ok(count);
            }
            self.board.tick();
            let is_on = self.board.state().unwrap().is_on();
            self.board.look_at_servos(|servos| self.servos.lock().unwrap().look(is_on, servos));
        }
    }

    fn now(&self) -> Duration {
        self.board.now()
    }
}

fn show(name: &str, mechanism: &Mechanism, rows: &[Vec<f64>], is_loop: bool, rig: u32) -> OwnShow {
    let joints: Vec<Joint> = (mechanism.bodies.iter())
        .map(|link| if link.ranges.is_empty() { Joint::Fixed } else { Joint::Revolute })
        .collect();
    let q = rows.concat();
    let (rate, cues) = (Rate { samples: 100, seconds: 1 }, &[][..]);
    let (joints, q) = (&joints[..], &q[..]);
    let motion = Motion { joints, q, rate, is_loop, rig, cues, time_code: None, course: &[] };
    let bytes = write(&motion, &Settings::default()).unwrap().bytes;
    OwnShow { name: name.to_owned(), bytes: bytes.into(), sound: None }
}

/// Returns a show in which the head looks to the side, and the jaw speaks. It begins far from home.
fn talk(mechanism: &Mechanism, rig: u32) -> OwnShow {
    let place = |name: &str| {
        let body = mechanism.bodies.iter().position(|link| link.joint_name == name).unwrap();
        mechanism.coordinate_ranges()[body].start
    };
    let (turn, jaw) = (place("neck_turn"), place("jaw"));
    let row = |k: i32| {
        let (mut q, t) = (mechanism.home(), 0.01 * f64::from(k));
        let share = 0.5 - 0.5 * (std::f64::consts::TAU * t / SHOW_S).cos();
        q[turn] = 0.5 - 0.3 * share;
        q[jaw] = -0.2 * share * (0.5 - 0.5 * (12.0 * t).cos());
        q
    };
    let rows: Vec<Vec<f64>> = (0..=600).map(row).collect();
    show("talk", mechanism, &rows, false, rig)
}

/// A console with a face, in simulated time.
struct Stage {
    page: Page,
    servos: Arc<Mutex<PulsedServos>>,
    stops: Arc<AtomicU32>,
    hub: Option<thread::JoinHandle<()>>,
}

impl Stage {
    /// `loop_s`: duration of the loop of idle life.
    fn start(loop_s: f64) -> Self {
        let rig = face();
        let mechanism = rig.mechanism().unwrap();
        let driven = Driven { is_of_board: true, ..Driven::default() };
        let parts = RigParts::new(&rig, &mechanism, driven).unwrap();
        let settings = IdleSettings { seconds: loop_s, seed: 1, uses: Vec::new() };
        let rows = idle(&mechanism, &settings).unwrap().motion.rows;
        let crc = parts.rig_crc();
        let idle = Some(show("idle", &mechanism, &rows, true, crc));
        let own = OwnShows { shows: vec![talk(&mechanism, crc)], idle };
        let scene = Scene::new("face", &mechanism, &parts, Source::Simulated);
        let servos = Arc::new(Mutex::new(PulsedServos::new(&rig, &mechanism, parts.rate_hz)));
        let options = Options { unattended: true, ..Options::default() };
        let console = Console::open(options).unwrap();
        let address = console.addresses().remove(0);
        let (host, token) = address.strip_prefix("http://").unwrap().split_once("/#").unwrap();
        let (seen, stops) = (Arc::clone(&servos), Arc::new(AtomicU32::new(0)));
        let told = Arc::clone(&stops);
        let run = move || {
            let chip = Chip::blank();
            SimulatedBoard::<RigPlant>::store_rig(&parts, &chip).unwrap();
            let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
            let plant = parts.plant(&rig, &mechanism).unwrap();
            let board = SimulatedBoard::new(&parts, &mut memories, plant, chip).unwrap();
            let line = Observed { board, servos: seen };
            let mut board = Board::connect(line, nonce(), Duration::from_secs(1)).unwrap();
            let name = format!("idle-{}", std::process::id());
            console
                .run(&mut board, &scene, (&name, own, Records::default()), &|| {
                    told.load(Ordering::Relaxed)
                })
                .unwrap();
        };
        let hub = thread::Builder::new().stack_size(STACK_BYTES).spawn(run).unwrap();
        let page = Page::open_at(host, token);
        Self { page, servos, stops, hub: Some(hub) }
    }

    /// Returns the time on the board, s.
    fn now_s(&self) -> f64 {
        self.servos.lock().unwrap().time_s()
    }

    /// Receives messages until a time on the board.
    fn until_s(&mut self, end_s: f64) {
        while self.now_s() < end_s {
            self.page.hear().unwrap();
            self.page.texts.clear();
        }
    }

    /// Plays the show, and returns when it began and when it was over, s.
    fn play(&mut self) -> [f64; 2] {
        let begun_s = self.now_s();
        assert!(self.page.ask(json!({ "type": "play", "slot": 0 })).0);
        self.page.until("the show", |page| page.shown().flags & 2 != 0);
        self.page.until("its end", |page| page.shown().flags & 2 == 0);
        [begun_s, self.now_s()]
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.stops.store(2, Ordering::Relaxed);
        let joined = self.hub.take().map(thread::JoinHandle::join);
        assert!(thread::panicking() || joined.is_none_or(|joined| joined.is_ok()));
    }
}

#[test]
fn idle_life_with_shows_between_never_jumps_and_never_repeats_itself() {
    let seconds: f64 = std::env::var(SECONDS).map_or(90.0, |seconds| seconds.parse().unwrap());
    // A loop that is as long as the test is never played twice.
    let mut stage = Stage::start(seconds.max(20.0));
    stage.page.arm();
    stage.page.until_state(HOLDING);
    assert!(stage.page.ask(json!({ "type": "idle", "on": true })).0);
    let between_s = BETWEEN_S.min(seconds / 3.0);
    let (begun_s, mut shows) = (stage.now_s(), Vec::new());
    let (mut costs, mut before) = (Vec::new(), (begun_s, used()));
    let end_s = begun_s + seconds;
    loop {
        stage.until_s((stage.now_s() + between_s).min(end_s));
        let now = (stage.now_s(), used());
        costs.push(((now.1.0 - before.1.0) / (now.0 - before.0), now.1.1));
        before = now;
        if stage.now_s() >= end_s {
            break;
        }
        shows.push(stage.play());
    }
    let servos = stage.servos.lock().unwrap();
    println!(
        "{seconds} s with {} shows between; CPU time per simulated time and kB between two shows: {costs:?}",
        shows.len()
    );
    servos.print();
    servos.assert_limits();
    // Only idle life is compared: the show is the same each time.
    let is_idle = |time_s: f64| {
        let mut parts = shows.iter();
        time_s > begun_s + BACK_S && parts.all(|[from, to]| time_s < *from || time_s > to + BACK_S)
    };
    let rows = servos.rows();
    let kept: Vec<bool> = (0..rows.len()).map(|row| is_idle(row as f64 / RATE_HZ)).collect();
    let (most, at) = most_alike(rows, &kept);
    let at = at.map(|row| row as f64 / RATE_HZ);
    println!("{} rows; most alike windows of 10 s: {most:.3} at {at:?} s", rows.len());
    assert!(shows.len() >= 2 && most > 0.0 && most <= ALIKE_MAX, "{most} at {at:?}");
    let [(first_s, first_kb), .., (last_s, last_kb)] = costs[..] else { panic!("too short") };
    // The observer of the servos keeps 5 rows per second, 0.7 kB. CPU time that grew with the time would be ten times
    // as much at the end of an hour.
    let rows_kb = seconds;
    assert!((last_kb as f64) < first_kb as f64 + 4096.0 + rows_kb, "{costs:?}");
    assert!(seconds < 1000.0 || last_s < 2.0 * first_s, "{costs:?}");
}

/// Returns the processor time of this program, s, and its memory, kB.
fn used() -> (f64, u64) {
    (seconds(Path::new("/proc/self/stat")), memory_kb())
}
