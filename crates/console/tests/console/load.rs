//! Load and attacks while a joint moves, measured at the servos; and response times.

use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::json;
use sinew_performance::play::Drive as DriveMode;
use sinew_rig::description::{Body, Drive, Joint, Servo};
use sinew_rig::servo::Address;
use sinew_rig::{Description, new};

use crate::client::{HOLDING, LIMP, Page};
use crate::other_side::OtherSide;

/// Maximum speed of a slider, deg/s; and largest step of a servo's goal between two ticks of 100 Hz. The step is larger
/// than the speed alone requires, because the drive adds the angle by which it expects the servo to sag.
const SPEED_DEG_S: f64 = 20.0;
const STEP_DEG: f64 = 1.0;
/// Environment variable with the duration of the test with many servos, s.
const SOAK: &str = "SINEW_SOAK_S";
/// Number of servos. A board has no room for a description of more joints.
const SERVOS: u8 = 40;

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// Checks that the goals of the servo are those of a slider.
#[track_caller]
fn assert_gentle(console: &OtherSide) {
    let servo = console.servo.lock().unwrap();
    println!(
        "largest step of a goal {:.2} deg, shaft {:.1} deg/s",
        servo.step_deg, servo.speed_deg_s
    );
    assert!(servo.step_deg <= STEP_DEG, "{servo:?}");
    assert!(servo.speed_deg_s <= 1.5 * SPEED_DEG_S, "{servo:?}");
}

#[test]
fn ten_thousand_connections_do_not_move_a_joint() {
    let console = OtherSide::start_on_positions();
    let mut page = Page::open(&console);
    page.arm();
    let mut flood = Vec::new();
    let mut opened = 0;
    for _ in 0..100 {
        // The joint must follow its slider during the flood.
        page.slide(2.5, ms(20));
        let more = (0..100).filter_map(|_| TcpStream::connect(&console.host).ok());
        flood.extend(more.inspect(|_| opened += 1));
        // Closes old connections, because a program may have only a limited number of open files.
        let old = flood.len().saturating_sub(300);
        flood.drain(..old);
    }
    let begun = Instant::now();
    let (is_done, text) = page.ask(json!({ "type": "hold" }));
    assert!(is_done && begun.elapsed() < ms(1000), "{text}");
    page.until_state(HOLDING);
    assert!(opened > 9_000, "{opened}");
    assert!(console.servo.lock().unwrap().way_deg > 1.0, "the slider moved the joint");
    assert_gentle(&console);
}

#[test]
fn a_killed_page_leaves_a_joint_that_stands() {
    let console = OtherSide::start_on_positions();
    let (mut driver, mut viewer) = (Page::open(&console), Page::open(&console));
    driver.arm();
    driver.slide(1.0, ms(700));
    drop(driver);
    viewer.until_state(HOLDING);
    sleep(ms(300));
    let way_deg = console.servo.lock().unwrap().way_deg;
    assert!(way_deg > 1.0);
    sleep(ms(1000));
    let later_deg = console.servo.lock().unwrap().way_deg;
    assert!(later_deg - way_deg < 0.2, "{way_deg} to {later_deg}");
    assert_gentle(&console);
}

#[test]
fn a_slider_reaches_the_goal_of_the_servo_soon() {
    let console = OtherSide::start_on_positions();
    let mut page = Page::open(&console);
    page.arm();
    let way_deg = || console.servo.lock().unwrap().way_deg;
    // Times until the goal changes by a count, and by 0.2 deg. They differ, because a motion begins softly.
    let [mut first, mut times] = [(); 2].map(|()| Vec::new());
    for turn in 0..40 {
        sleep(ms(700));
        let before = way_deg();
        let goal = if turn % 2 == 0 { 0.4 } else { -0.4 };
        let said = Instant::now();
        let mut due = said;
        let mut moved = None;
        while way_deg() - before < 0.2 {
            if way_deg() > before {
                moved.get_or_insert(said.elapsed());
            }
            assert!(said.elapsed() < ms(3000));
            if Instant::now() >= due {
                due += ms(50);
                page.say(&json!({ "type": "jog", "dof": 0, "goal": goal }));
            }
            sleep(Duration::from_micros(500));
        }
        times.push(said.elapsed());
        first.push(moved.unwrap_or(said.elapsed()));
        page.ask(json!({ "type": "release", "dof": 0 }));
        page.until_state(HOLDING);
    }
    times.sort();
    first.sort();
    println!(
        "from a page's goal to the servo's: first count median {:?}, largest {:?}; 0.2 deg median {:?}, largest {:?}",
        first[20], first[39], times[20], times[39]
    );
    assert!(times[20] < ms(250) && times[39] < ms(500), "{times:?}");
    assert!(first[20] < ms(200) && first[39] < ms(450), "{first:?}");
    assert_gentle(&console);
}

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

/// Returns the CPU time of this program, s, and its memory, kB.
pub(crate) fn used() -> (f64, u64) {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    // The name of the program ends with a bracket; user and system time are 12 and 13 fields after it.
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    let ticks: f64 = fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap();
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    let resident = resident.trim_end_matches("kB").trim().parse().unwrap();
    (ticks / 100.0, resident)
}

/// Serves a page with many servos. `SINEW_SOAK_S=3600` makes it an hour.
#[cfg(target_os = "linux")]
#[test]
fn many_servos_need_little_and_always_the_same() {
    let seconds = std::env::var(SOAK).map_or(5, |seconds| seconds.parse().unwrap());
    let console = OtherSide::start_on(porcupine(), Some(DriveMode::Position), false);
    let mut page = Page::open(&console);
    page.until_state(LIMP);
    let look = |page: &mut Page, time: Duration| {
        let (mut pictures, begun) = (0_u32, Instant::now());
        let mut said = begun;
        while begun.elapsed() < time {
            page.hear().unwrap();
            pictures += u32::from(page.picture.take().is_some());
            page.texts.clear();
            if said.elapsed() > ms(1000) {
                said = Instant::now();
                page.say(&json!({ "type": "ping", "t": 0 }));
            }
        }
        f64::from(pictures) / begun.elapsed().as_secs_f64()
    };
    look(&mut page, Duration::from_secs(2));
    let (begun, (cpu_s, before_kb)) = (Instant::now(), used());
    let rate_hz = look(&mut page, Duration::from_secs(seconds));
    let (after_s, after_kb) = used();
    let share = (after_s - cpu_s) / begun.elapsed().as_secs_f64();
    println!(
        "{SERVOS} servos, {rate_hz:.1} pictures a second for {seconds} s: {:.0} % of a core for hub, board, its servos \
         and this page; memory {before_kb} kB, then {after_kb} kB",
        100.0 * share
    );
    assert!(rate_hz > 20.0 && share < 1.0, "{rate_hz} Hz, {share} of a core");
    assert!(after_kb < before_kb + 4096, "{before_kb} kB to {after_kb} kB");
}
