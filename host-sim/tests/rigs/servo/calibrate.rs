//! `sinew servo calibrate`: a simulated hand moves the joint, and the test answers the prompts.
#![expect(
    clippy::cast_possible_truncation,
    reason = "positions go between threads as microradians"
)]

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, Stdio};
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use sinew_rig::toml_file;
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::line::{Line, LineDevice};
use sinew_servo_sim::load::{Load, Plant, Push, Shaft};
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::port::Port;
use sinew_servo_sim::supply::Supply;

use crate::common::{command, printed};

const BAUD: u32 = 1_000_000;
/// Longest wait of a test.
const PATIENCE: Duration = Duration::from_mins(1);

/// State that the test and the servo's thread share. Positions are in microradians from the encoder's zero.
#[derive(Default)]
struct Shared {
    hand_urad: AtomicI64,
    shaft_urad: AtomicI64,
    /// Number of packets that the servo has received.
    heard: AtomicU64,
    stop: AtomicBool,
}

/// A hand on the horn, which pulls the shaft to the hand's position.
#[derive(Clone, Copy)]
struct Hand {
    at_rad: f64,
}

impl Load for Hand {
    fn inertia_kg_m2(&self) -> f64 {
        1e-3
    }

    fn torque_nm(&self, shaft: Shaft) -> f64 {
        // 5 N m/rad up to 0.4 N m, more than critically damped: 2 √(5 · 1e-3) N m s.
        (5.0 * (self.at_rad - shaft.position_rad)).clamp(-0.4, 0.4) - 0.2 * shaft.velocity_rad_s
    }
}

struct Held<'s>(&'s Shared);

impl Plant for Held<'_> {
    type Load = Hand;

    fn load(&self, _: usize) -> Hand {
        Hand { at_rad: 1e-6 * self.0.hand_urad.load(Ordering::Relaxed) as f64 }
    }

    fn step(&mut self, _: f64, _: &[Push], shafts: &mut [Shaft]) {
        let urad = (1e6 * shafts[0].position_rad).round();
        self.0.shaft_urad.store(urad as i64, Ordering::Relaxed);
    }
}

/// A bench that counts the packets from the program.
struct Counted<'s> {
    bench: Bench<'s, Held<'s>>,
    shared: &'s Shared,
}

impl LineDevice for Counted<'_> {
    fn now_ns(&self) -> u64 {
        self.bench.now_ns()
    }
    fn run_until(&mut self, ns: u64) {
        self.bench.run_until(ns);
    }
    fn wire_ns(&self, bytes: usize) -> u64 {
        self.bench.wire_ns(bytes)
    }
    fn set_rate(&mut self, baud: u32) {
        self.bench.set_rate(baud);
    }
    fn hear(&mut self, bytes: &[u8], speaker: Option<usize>) {
        self.bench.hear(bytes, speaker);
        self.shared.heard.fetch_add(1, Ordering::Relaxed);
    }
    fn next_speaker(&self) -> Option<(usize, u32)> {
        self.bench.next_speaker()
    }
    fn speak(&mut self, speaker: usize) -> Option<(Vec<u8>, u32)> {
        self.bench.speak(speaker)
    }
    fn silence(&mut self) {
        self.bench.silence();
    }
}

impl Shared {
    #[track_caller]
    fn wait_until(&self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let begin = Instant::now();
        while !is_so(self) {
            assert!(begin.elapsed() < PATIENCE, "{what}");
            std::thread::yield_now();
        }
    }

    /// Moves the joint to an angle, and waits until the program has read the servo there.
    #[track_caller]
    fn move_to(&self, degrees: f64) {
        let urad = (1e6 * (degrees + 180.0).to_radians()).round() as i64;
        self.hand_urad.store(urad, Ordering::Relaxed);
        // 1 deg: at this angle from a hand of 5 N m/rad, friction still holds an XL330.
        self.wait_until("the joint does not follow", |shared| {
            (shared.shaft_urad.load(Ordering::Relaxed) - urad).abs() < 17_000
        });
        let before = self.heard.load(Ordering::Relaxed);
        // A question and its answer, both after the joint arrived.
        self.wait_until("nobody looks", |shared| {
            shared.heard.load(Ordering::Relaxed) >= before + 4
        });
    }
}

/// The process `sinew servo calibrate`, and its output.
struct Calibrate {
    child: Child,
    input: ChildStdin,
    said: Receiver<String>,
}

impl Calibrate {
    fn start(rig: &Path, link: &Path) -> Self {
        let mut child = command()
            .args(["servo", "calibrate", "--rig", rig.to_str().unwrap()])
            .args(["--baud", "1000000", "--port", link.to_str().unwrap()])
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (send, said) = mpsc::channel();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        std::thread::spawn(move || {
            lines.map_while(Result::ok).try_for_each(|line| send.send(line))
        });
        let input = child.stdin.take().unwrap();
        Self { child, input, said }
    }

    #[track_caller]
    fn says(&self, words: &str) {
        let mut all = String::new();
        while !all.contains(words) {
            all += &self.said.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("{words}: {all}"));
        }
    }

    fn enter(&mut self) {
        self.input.write_all(b"\n").unwrap();
    }
}

#[test]
fn a_joint_that_is_moved_by_hand_gets_its_range_and_its_offset() {
    let folder = tempfile::tempdir().unwrap();
    let (rig, link) = (folder.path().join("rig.toml"), folder.path().join("bus"));
    printed(&["rig", "new", "--arm", "1", "-o", rig.to_str().unwrap()]);
    let before = std::fs::read_to_string(&rig).unwrap();
    let home_deg = toml_file::read(&before).unwrap().joints[0].home()[0].to_degrees();

    let kind = Parameters::built_in("XL330-M288-T").unwrap();
    let mut memory = [0; MEMORY_LEN];
    let mut servo = Servo::new(&kind, 1, &mut memory).unwrap();
    servo.set_baud(BAUD).unwrap();
    let shared = Shared::default();
    shared.hand_urad.store((1e6 * std::f64::consts::PI) as i64, Ordering::Relaxed);
    let supply = Supply::stiff(kind.voltage_v);
    let bench = Bench::new(vec![servo], Held(&shared), supply);
    let mut line = Line::new(Counted { bench, shared: &shared });
    let port = Port::open(&link, BAUD).unwrap();

    std::thread::scope(|scope| {
        scope.spawn(|| port.serve(&mut line, &shared.stop).unwrap());
        // A test that fails ends the thread, too.
        let _stop = StopAtEnd(&shared.stop);
        let mut calibrate = Calibrate::start(&rig, &link);
        calibrate.says("hold the parts that would fall");
        calibrate.enter();
        calibrate.says("from stop to stop");
        shared.move_to(-70.0);
        shared.move_to(95.0);
        shared.move_to(10.0);
        calibrate.enter();
        calibrate.says("Now put it at home");
        shared.move_to(25.0);
        calibrate.enter();
        calibrate.says("wrote ");
        assert!(calibrate.child.wait().unwrap().success());
    });

    let after = std::fs::read_to_string(&rig).unwrap();
    let found = toml_file::read(&after).unwrap();
    let [least, most] = found.servos[0].range_rad[0].map(f64::to_degrees);
    // One degree for the hand, and 2 of margin.
    assert!((least + 68.0).abs() < 1.1 && (most - 93.0).abs() < 1.1, "{least} {most}");
    let offset_deg = found.servos[0].offset_rad.unwrap().to_degrees();
    let turned_deg = f64::from(found.servos[0].direction) * home_deg;
    assert!((offset_deg - (25.0 - turned_deg)).abs() < 1.1, "{offset_deg}");
    // Everything else in the file is unchanged.
    let rest = |text: &str| -> Vec<String> {
        let keeps = |line: &&str| !line.starts_with("range_deg") && !line.starts_with("offset_deg");
        text.lines().filter(keeps).map(str::to_owned).collect()
    };
    assert_eq!(rest(&before), rest(&after));
}

struct StopAtEnd<'s>(&'s AtomicBool);

impl Drop for StopAtEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
