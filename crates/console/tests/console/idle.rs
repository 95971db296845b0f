//! Idle life: a page starts it, a show interrupts it, and it continues where it was.

use std::time::Duration;

use serde_json::json;
use sinew_link::message::{Command, Feed};

use crate::client::{HOLDING, LIMP, PLAYING, Page};
use crate::other_side::OtherSide;

/// Returns the last state of idle life that the page was told.
fn is_on(page: &Page) -> bool {
    let last = page.texts.iter().rev().find(|text| text["type"] == "shows").unwrap();
    assert_eq!(last["idle"]["name"], "sway");
    last["idle"]["on"] == true
}

#[test]
fn idle_life_goes_on_after_a_show() {
    let console = OtherSide::start(true);
    let mut page = Page::open(&console);
    page.until_state(LIMP);
    assert!(!is_on(&page));
    let (is_done, text) = page.ask(json!({ "type": "idle", "on": true }));
    assert!(!is_done && text.contains("arm it first"), "{text}");
    page.arm();
    assert!(page.ask(json!({ "type": "idle", "on": true })).0);
    assert!(is_on(&page));
    // The loop swings between -0.16 and -0.04 rad.
    page.until("the loop", |page| page.shown().wanted < -0.13);
    let (is_done, text) = page.ask(json!({ "type": "jog", "dof": 0, "goal": 0.1 }));
    assert!(!is_done && text.contains("hold it first"), "{text}");
    let before = console.told.lock().unwrap().poses.last().unwrap()[0];
    assert!(page.ask(json!({ "type": "play", "slot": 0 })).0);
    page.until("the show", |page| page.shown().flags & 2 != 0 && page.shown().wanted > 0.05);
    let count = console.told.lock().unwrap().poses.len();
    page.until("idle life again", |page| page.shown().flags & 2 == 0 && page.shown().wanted < -0.1);
    assert!(is_on(&page));
    // The way back leads to the pose in which the loop was interrupted, at 20 deg/s at most.
    let poses: Vec<f32> = console.told.lock().unwrap().poses.iter().map(|q| q[0]).collect();
    let back = &poses[count..];
    assert!(back.iter().any(|q| (q - before).abs() < 0.01), "{before}: {back:?}");
    assert!(back.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.03), "{back:?}");
    assert!(console.was_told(&Command::Play(Feed::Show)));
    page.until_state(PLAYING);
    // A hold ends idle life for good.
    assert!(page.ask(json!({ "type": "hold" })).0);
    page.until_state(HOLDING);
    assert!(!is_on(&page));
    let count = console.told.lock().unwrap().poses.len();
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(console.told.lock().unwrap().poses.len(), count);
}

#[test]
fn idle_life_without_a_driver_is_held() {
    let console = OtherSide::start(true);
    let (mut driver, mut viewer) = (Page::open(&console), Page::open(&console));
    driver.arm();
    assert!(driver.ask(json!({ "type": "idle", "on": true })).0);
    viewer.until_state(PLAYING);
    drop(driver);
    viewer.until_state(HOLDING);
    assert!(!is_on(&viewer));
}
