//! A console for a rig of many servos: rate of pictures, processor time, and memory.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::json;
use sinew_performance::play::Drive as DriveMode;
use sinew_rig::description::{Body, Drive, Joint, Servo};
use sinew_rig::servo::Address;
use sinew_rig::{Description, new};

use crate::client::Page;
use crate::other_side::{BOARD, OtherSide};

/// Environment variable with the duration of the test, s.
const SOAK: &str = "SINEW_SOAK_S";
const SERVOS: u8 = 60;
/// Largest growth of memory, kB. The allocator may keep some more pages; a leak of each picture would take 120 MB in an
/// hour.
const GROWTH_KB: u64 = 4096;

/// Returns a base with many joints, each with a servo of its own.
fn porcupine() -> Description {
    let mut rig = new::arm(1).unwrap();
    let (body, joint) = (rig.bodies[1].clone(), rig.joints[0].clone());
    let (drive, servo) = (rig.drives[0].clone(), rig.servos[0].clone());
    for id in 2..=SERVOS {
        let name = format!("turn{id}");
        rig.bodies.push(Body { name: name.clone(), ..body.clone() });
        rig.joints.push(Joint { name: name.clone(), child: name.clone(), ..joint.clone() });
        let [joints, servos] = [(); 2].map(|()| vec![name.clone()]);
        rig.drives.push(Drive { joints, servos, ..drive.clone() });
        rig.servos.push(Servo { name, address: Address::Id(id), ..servo.clone() });
    }
    rig
}

/// Processor time of this program, s, or its share of a core.
#[derive(Debug, Clone, Copy, Default)]
struct Used {
    /// The thread of the simulated board with its servos.
    board: f64,
    /// The thread of this test, which is the page.
    page: f64,
    /// All other threads: the hub, and those that serve pages.
    hub: f64,
}

impl Used {
    fn now() -> Self {
        let name = |path: &Path| fs::read_to_string(path.join("comm")).unwrap_or_default();
        let tasks = fs::read_dir("/proc/self/task").unwrap().map(|task| task.unwrap().path());
        let boards = tasks.filter(|task| name(task).trim_end() == BOARD);
        let board = boards.map(|task| seconds(&task.join("stat"))).sum();
        let page = seconds(Path::new("/proc/thread-self/stat"));
        Self { board, page, hub: seconds(Path::new("/proc/self/stat")) - board - page }
    }

    /// Returns the shares of a core since an earlier time.
    fn since(self, before: Self, time: Duration) -> Self {
        let share = |now: f64, then: f64| (now - then) / time.as_secs_f64();
        Self {
            board: share(self.board, before.board),
            page: share(self.page, before.page),
            hub: share(self.hub, before.hub),
        }
    }
}

/// Returns the processor time in a file `stat` of a process or a thread, s.
pub(crate) fn seconds(stat: &Path) -> f64 {
    let stat = fs::read_to_string(stat).unwrap();
    // The name of the program ends with a bracket; user and system time are 12 and 13 fields after it.
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    let ticks: f64 = fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap();
    ticks / 100.0
}

/// Returns the memory of this program, kB.
pub(crate) fn memory_kb() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    resident.trim_end_matches("kB").trim().parse().unwrap()
}

/// Serves a page with many servos. `SINEW_SOAK_S=3600` makes it an hour.
#[cfg(target_os = "linux")]
#[test]
fn many_servos_need_little_and_always_the_same() {
    let seconds = std::env::var(SOAK).map_or(5, |seconds| seconds.parse().unwrap());
    let console = OtherSide::start_on(porcupine(), Some(DriveMode::Position), false);
    let mut page = Page::open(&console);
    page.arm();
    assert_eq!(page.texts[0]["servos"].as_array().unwrap().len(), usize::from(SERVOS));
    let look = |page: &mut Page, time: Duration| {
        let (mut pictures, begun) = (0_u32, Instant::now());
        let mut said = begun;
        while begun.elapsed() < time {
            page.hear().unwrap();
            pictures += u32::from(page.picture.take().is_some());
            page.texts.clear();
            if said.elapsed() > Duration::from_secs(1) {
                said = Instant::now();
                page.say(&json!({ "type": "ping", "t": 0 }));
            }
        }
        f64::from(pictures) / begun.elapsed().as_secs_f64()
    };
    look(&mut page, Duration::from_secs(2));
    let (begun, before, before_kb) = (Instant::now(), Used::now(), memory_kb());
    let rate_hz = look(&mut page, Duration::from_secs(seconds));
    let share = Used::now().since(before, begun.elapsed());
    let after_kb = memory_kb();
    println!(
        "{SERVOS} servos, {rate_hz:.1} pictures a second for {seconds} s: of a core, hub and its server {:.1} %, board \
         with its simulated servos {:.1} %, this page {:.1} %; memory {before_kb} kB, then {after_kb} kB",
        100.0 * share.hub,
        100.0 * share.board,
        100.0 * share.page,
    );
    assert!(rate_hz > 20.0, "{rate_hz} Hz");
    // Half of a core is the aim, a slow machine takes longer.
    assert!(share.hub + share.board < 1.0, "{share:?} of a core");
    assert!(after_kb < before_kb + GROWTH_KB, "{before_kb} kB to {after_kb} kB");
}
