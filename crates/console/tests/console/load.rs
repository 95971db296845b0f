//! Load and attacks while a joint moves, measured at the servos.

use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::client::{HOLDING, Page};
use crate::other_side::OtherSide;

/// Maximum speed of a slider, deg/s; and largest step of a servo's goal between two ticks of 100 Hz. The step is larger
/// than the speed alone requires, because the drive adds the angle by which it expects the servo to sag.
const SPEED_DEG_S: f64 = 20.0;
const STEP_DEG: f64 = 1.0;

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// Checks that the goals of the servo are those of a slider, and that its shaft is at most `ratio` times as fast as a
/// slider.
#[track_caller]
pub(crate) fn assert_gentle(console: &OtherSide, ratio: f64) {
    let servo = console.servo.lock().unwrap();
    println!(
        "largest step of a goal {:.2} deg, shaft {:.1} deg/s",
        servo.step_deg, servo.speed_deg_s
    );
    assert!(servo.step_deg <= STEP_DEG, "{servo:?}");
    assert!(servo.speed_deg_s <= ratio * SPEED_DEG_S, "{servo:?}");
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
    assert_gentle(&console, 1.5);
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
    assert_gentle(&console, 1.5);
}
