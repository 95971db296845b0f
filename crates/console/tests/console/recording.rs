//! A recording that a page begins and ends.

use std::fs;
use std::thread::sleep;
use std::time::Duration;

use serde_json::{Value, json};
use sinew_performance::play::Recording;
use sinew_rig::new;

use crate::client::{FAULTED, LIMP, Page};
use crate::other_side::OtherSide;

fn record(page: &mut Page, on: bool) -> (bool, String) {
    page.ask(json!({ "type": "record", "on": on }))
}

/// Returns the file of the last message about the recording.
fn file(page: &Page) -> Value {
    let mut texts = page.texts.iter().rev();
    texts.find(|text| text["type"] == "record").map_or(Value::Null, |text| text["file"].clone())
}

#[test]
fn the_driver_records_and_viewers_see_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("session.parquet");
    let own = Some(folder.path().to_owned());
    let console = OtherSide::start_in(own, new::arm(1).unwrap(), None, false);
    let (mut driver, mut viewer) = (Page::open(&console), Page::open(&console));
    driver.until_state(LIMP);
    let (is_done, text) = record(&mut viewer, true);
    assert!(!is_done && text.contains("somebody else drives"), "{text}");
    let (is_done, text) = record(&mut driver, false);
    assert!(!is_done && text.contains("nothing is being recorded"), "{text}");
    let (is_done, text) = record(&mut driver, true);
    assert!(is_done && text.contains("session.parquet"), "{text}");
    let (is_done, text) = record(&mut driver, true);
    assert!(!is_done && text.contains("end it first"), "{text}");
    viewer.until("the file", |page| file(page) == json!(path.display().to_string()));
    let mut late = Page::open(&console);
    late.until("the file", |page| file(page) == json!(path.display().to_string()));
    assert!(!record(&mut viewer, false).0);
    driver.arm();
    driver.slide(0.2, Duration::from_millis(500));
    assert!(driver.ask(json!({ "type": "estop" })).0);
    driver.until_state(FAULTED);
    sleep(Duration::from_millis(200));
    let (is_done, text) = record(&mut driver, false);
    assert!(is_done && text.contains("the recording has ended"), "{text}");
    viewer.until("no file", |page| file(page) == Value::Null);
    let recording = Recording::open(&path).unwrap();
    let parts = recording.parts().map(Result::unwrap);
    let mut states: Vec<String> = parts.flat_map(|part| part.states).flatten().collect();
    states.dedup();
    assert_eq!(states, ["limp", "arming", "holding", "playing", "faulted"]);
    // Another recording may follow.
    assert!(record(&mut driver, true).0 && record(&mut driver, false).0);
}

#[test]
fn a_recording_that_cannot_begin_is_refused_by_words() {
    let console = OtherSide::start(false);
    let mut page = Page::open(&console);
    let (is_done, text) = record(&mut page, true);
    assert!(!is_done && text.contains("cannot record"), "{text}");
    drop(console);
    let folder = tempfile::tempdir().unwrap();
    let gone = folder.path().join("gone");
    let console = OtherSide::start_in(Some(gone.clone()), new::arm(1).unwrap(), None, false);
    let mut page = Page::open(&console);
    let (is_done, text) = record(&mut page, true);
    assert!(!is_done && text.to_lowercase().contains("no such file"), "{text}");
    assert_eq!(file(&page), Value::Null);
    fs::create_dir(&gone).unwrap();
    assert!(record(&mut page, true).0);
}
