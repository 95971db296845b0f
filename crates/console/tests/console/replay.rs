//! A recording instead of a board: pages seek in it and play it, and cannot command anything.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::Duration;

use serde_json::json;
use sinew_console::{Console, Options, Replay, Scene, Source};
use sinew_performance::play::{
    Options as Driven, Recorder, Recording, RigParts, Tick, TickOfJoint,
};
use sinew_rig::{new, toml_file};

use crate::client::{HOLDING, LIMP, Page};

const RATE_HZ: f64 = 60.0;

/// Returns the tick of a joint that turns by 0.1 rad a second. The rig is limp, and holds from 2 s on.
fn tick(row: u32) -> Tick {
    let time_s = f64::from(row) / RATE_HZ;
    #[expect(clippy::cast_possible_truncation, reason = "a recording has f32")]
    let at = (0.1 * time_s) as f32;
    let is_holding = time_s >= 2.0;
    let numbers = [Some(at + 0.01), Some(at), Some(0.01), Some(0.5)];
    let joint = TickOfJoint { numbers, limiter: Some("heat".to_owned()), swings: None };
    Tick {
        time_s,
        state: Some(if is_holding { "holding" } else { "limp" }.to_owned()),
        runs: false,
        faults: (row == 120).then(|| "fault 2 (link lost)".to_owned()),
        joints: vec![joint],
        servos: vec![[None, Some(40.0), Some(5.0)]],
    }
}

#[test]
fn a_recording_is_shown_sought_and_played() {
    let arm = new::arm(1).unwrap();
    let mechanism = arm.mechanism().unwrap();
    let parts = RigParts::new(&arm, &mechanism, Driven::default()).unwrap();
    let path = std::env::temp_dir().join(format!("sinew-replay-{}.parquet", std::process::id()));
    let rig = toml_file::write(&arm);
    let mut recorder = Recorder::new(&path, (&parts, RATE_HZ), &rig, &[]).unwrap();
    (0..240).for_each(|row| recorder.put(&tick(row)).unwrap());
    recorder.end().unwrap();
    let recording = Recording::open(&path).unwrap();
    let scene = Scene::new(&arm.name, &mechanism, &parts, Source::Recording);
    let replay = Replay::new(&recording, &scene, &parts).unwrap();
    std::fs::remove_file(&path).unwrap();

    let console = Console::open(Options::default()).unwrap();
    let address = console.addresses().remove(0);
    let (host, token) = address.strip_prefix("http://").unwrap().split_once("/#").unwrap();
    let stops = Arc::new(AtomicU32::new(0));
    let counted = Arc::clone(&stops);
    let served = thread::spawn(move || {
        console.replay(&replay, (&scene, "a nod"), &|| counted.load(Ordering::Relaxed)).unwrap();
    });
    let mut page = Page::mute(host);
    page.say(&json!({ "type": "hello", "token": token }));
    page.until_state(LIMP);
    assert_eq!(
        (&page.texts[0]["source"], &page.texts[0]["commands"]),
        (&json!("recording"), &json!(false))
    );
    assert_eq!(
        page.texts[1]["slots"],
        json!([{ "slot": 0, "name": "a nod", "duration_s": 4.0, "cues": [] }])
    );
    let is_fault = |text: &serde_json::Value| text["level"] == "fault" && text["t"] == 2.0;
    page.until("the fault", |page| page.texts.iter().any(is_fault));
    for command in ["arm", "stop", "estop", "home"] {
        let (is_done, text) = page.ask(json!({ "type": command }));
        assert!(!is_done && text.contains("a recording has no commands"), "{command}: {text}");
    }
    assert!(page.ask(json!({ "type": "seek", "t": 3.0 })).0);
    page.until_state(HOLDING);
    let at = |page: &Page| page.shown().measured;
    page.until("its pose", |page| (at(page) - 0.3).abs() < 5e-3);
    assert!((page.shown().wanted - at(&page) - 0.01).abs() < 1e-5);
    assert!(page.ask(json!({ "type": "seek", "t": 0.5 })).0);
    assert!(page.ask(json!({ "type": "play", "slot": 0 })).0);
    page.until("its way", |page| at(page) > 0.15);
    assert!(page.ask(json!({ "type": "hold" })).0);
    page.until_state(LIMP);
    let before = at(&page);
    thread::sleep(Duration::from_millis(300));
    page.ask(json!({ "type": "seek", "t": 99.0 }));
    page.until("its end", |page| (at(page) - 0.398).abs() < 5e-3);
    assert!(before < 0.3, "{before}");
    stops.store(1, Ordering::Relaxed);
    served.join().unwrap();
}
