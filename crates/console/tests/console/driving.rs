//! A page that drives: arming, sliders, shows, stops; and which motions end when the page is gone.

use std::os::unix::net::UnixListener;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

use serde_json::json;
use sinew_console::Ended;
use sinew_console::local::{Bell, Request, Role, ask, ask_all, consoles, private_folder, roles};
use sinew_link::message::{Command, Feed};
use sinew_rig::description::LinkedLimit;
use sinew_rig::new;

use crate::client::{FAULTED, HOLDING, LIMP, LOWERING, PLAYING, Page};
use crate::other_side::{OtherSide, Prepared};

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

#[test]
fn a_page_arms_moves_a_joint_plays_and_stops() {
    let console = OtherSide::start(true);
    let mut page = Page::open(&console);
    assert_eq!(page.texts[0]["type"], "head");
    assert_eq!(page.texts[0]["dofs"][0]["coordinate"], 0);
    assert_eq!(page.texts[1]["slots"][0]["name"], "nod");
    assert_eq!(page.texts[1]["slots"][0]["cues"][0]["name"], "far");
    assert_eq!(
        page.texts[2],
        json!({ "type": "role", "driver": true, "other": null, "asked": false })
    );
    page.until_state(LIMP);
    assert!(page.shown().wanted.is_nan(), "nothing is wanted of a limp rig");
    let (is_done, text) = page.ask(json!({ "type": "jog", "dof": 0, "goal": 0.1 }));
    assert!(!is_done && text.contains("arm it first"), "{text}");
    page.arm();
    let start = page.shown().measured;
    // A busy machine takes longer.
    let begun = Instant::now();
    while (page.shown().wanted - start - 0.15).abs() >= 2e-3 && begun.elapsed() < ms(10_000) {
        page.slide(start + 0.15, ms(200));
    }
    let there = page.shown();
    assert!((there.wanted - start - 0.15).abs() < 2e-3, "{there:?} from {start}");
    assert!((there.measured - start - 0.15).abs() < 0.02, "{there:?} from {start}");
    assert_eq!((there.state, there.flags), (PLAYING, 1));
    assert!(page.ask(json!({ "type": "release", "dof": 0 })).0);
    page.until_state(HOLDING);
    // At no time faster than 20 deg/s.
    let told = console.told.lock().unwrap().jogs.iter().fold(0.0_f32, |most, v| most.max(v.abs()));
    assert!(told > 0.1 && told <= 20_f32.to_radians() + 1e-6, "{told}");

    assert!(page.ask(json!({ "type": "seek", "t": 0.3 })).0);
    page.until("a ghost", |page| page.shown().flags & 8 != 0);
    let (is_done, text) = page.ask(json!({ "type": "play", "slot": 0 }));
    assert!(is_done, "{text}");
    page.until("a show", |page| page.shown().flags & 2 != 0);
    page.until_state(HOLDING);
    assert!(page.ask(json!({ "type": "play", "slot": 0, "loop": true })).0);
    page.until_state(PLAYING);
    let (is_done, text) = page.ask(json!({ "type": "estop" }));
    assert!(is_done, "{text}");
    page.until_state(FAULTED);
    assert!(page.ask(json!({ "type": "clear" })).0);
    page.until_state(LIMP);
    assert_eq!(console.end(), Ended::Stopped);
}

#[test]
fn a_tied_joint_moves_with_its_leader() {
    // The tie means: bend2 = 0.5 turn1 + 20 deg.
    let offset = 20_f64.to_radians();
    let mut arm = new::arm(2).unwrap();
    arm.limits.push(LinkedLimit {
        joint: "bend2".to_owned(),
        other: "turn1".to_owned(),
        other_factor: -0.5,
        least_rad: Some(offset),
        most_rad: Some(offset),
        ..LinkedLimit::default()
    });
    let console = OtherSide::start_on(arm, None, false);
    let mut page = Page::open(&console);
    let leaders = [0, 1].map(|dof| page.texts[0]["dofs"][dof]["leader"].clone());
    assert_eq!(leaders, [json!(null), json!(0)]);
    page.arm();
    let why = "`bend2` follows `turn1`: move `turn1`";
    let (is_done, text) = page.ask(json!({ "type": "jog", "dof": 1, "goal": 0.5 }));
    assert!(!is_done && text.contains(why), "{text}");
    let own = Request::Jog { joint: "bend2".to_owned(), by: 5.0 };
    let refused = ask(&console.name, &own).unwrap();
    assert!(!refused.ok && refused.text.contains(why), "{}", refused.text);
    let start = page.shown().wanted;
    let begun = Instant::now();
    while (page.shown().wanted - start - 0.1).abs() >= 2e-3 && begun.elapsed() < ms(10_000) {
        page.slide(start + 0.1, ms(200));
    }
    assert!((page.shown().wanted - start - 0.1).abs() < 2e-3, "{:?}", page.shown());
    assert!(page.ask(json!({ "type": "release", "dof": 0 })).0);
    page.until_state(HOLDING);
    let name = console.name.clone();
    let jog = Request::Jog { joint: "turn1".to_owned(), by: -5.0 };
    let command = spawn(move || ask(&name, &jog).unwrap());
    page.until("its end", |_| command.is_finished());
    let reply = command.join().unwrap();
    assert!(reply.ok, "{}", reply.text);
    let told = console.told.lock().unwrap();
    assert!(told.jogs.is_empty() && told.poses.len() > 10);
    for (index, pose) in told.poses.iter().enumerate() {
        let off = f64::from(pose[1]) - 0.5 * f64::from(pose[0]) - offset;
        // The motion begins at the measured pose, which gravity has moved a little.
        assert!(off.abs() < 0.02, "pose {index}: off by {off}");
    }
}

#[test]
fn a_motion_that_misses_its_goal_says_so() {
    let console = OtherSide::start(false);
    let mut page = Page::open(&console);
    page.arm();
    let name = console.name.clone();
    console.is_stuck.store(true, Ordering::Relaxed);
    let jog = Request::Jog { joint: "turn1".to_owned(), by: 20.0 };
    let command = spawn(move || ask(&name, &jog).unwrap());
    let mut said = Instant::now();
    while !command.is_finished() {
        page.hear().unwrap();
        if said.elapsed() > ms(500) {
            said = Instant::now();
            page.say(&json!({ "type": "ping", "t": 0 }));
        }
    }
    let reply = command.join().unwrap();
    assert!(!reply.ok && reply.text.contains("it misses `turn1` by"), "{}", reply.text);
    page.until_state(HOLDING);
}

#[test]
fn a_joint_stops_when_its_page_dies() {
    let console = OtherSide::start(false);
    let (mut driver, mut viewer) = (Page::open(&console), Page::open(&console));
    driver.arm();
    driver.slide(1.0, ms(700));
    viewer.until_state(PLAYING);
    drop(driver);
    let killed = Instant::now();
    viewer.until_state(HOLDING);
    assert!(killed.elapsed() < ms(300), "{:?}", killed.elapsed());
    assert!(console.was_told(&Command::Hold));
    let at = viewer.shown().wanted;
    sleep(ms(300));
    viewer.until("a picture", |page| page.picture.is_some());
    // It has come to rest within its own deceleration.
    assert!((viewer.shown().wanted - at).abs() < 0.03);
    // The wheel is free.
    let (is_done, text) = viewer.ask(json!({ "type": "wheel", "take": true }));
    assert!(is_done, "{text}");
}

#[test]
fn a_slider_that_falls_silent_holds() {
    let console = OtherSide::start(false);
    let mut page = Page::open(&console);
    page.arm();
    page.slide(1.0, ms(600));
    let silent = Instant::now();
    page.until("holding", |page| page.shown().state == HOLDING);
    assert!((ms(80)..ms(350)).contains(&silent.elapsed()), "{:?}", silent.elapsed());
}

#[test]
fn one_page_drives_and_all_may_stop() {
    let console = OtherSide::start(false);
    let (mut driver, mut viewer) = (Page::open(&console), Page::open(&console));
    let role = json!({ "type": "role", "driver": false, "other": "page", "asked": false });
    assert_eq!(viewer.texts.last(), Some(&role));
    viewer.until_state(LIMP);
    for command in [
        json!({ "type": "arm" }),
        json!({ "type": "home" }),
        json!({ "type": "lower" }),
        json!({ "type": "clear" }),
        json!({ "type": "jog", "dof": 0, "goal": 0.1 }),
        json!({ "type": "play", "slot": 0 }),
        json!({ "type": "upload", "name": "a" }),
        json!({ "type": "wheel", "take": true }),
    ] {
        let (is_done, text) = viewer.ask(command.clone());
        assert!(!is_done && text.contains("somebody else drives"), "{command}: {text}");
    }
    assert!(console.told.lock().unwrap().jogs.is_empty() && !console.was_told(&Command::Arm));
    driver.arm();
    driver.slide(1.0, ms(300));
    assert!(viewer.ask(json!({ "type": "hold" })).0);
    viewer.until_state(HOLDING);
    // The driver's slider is still held, and moves nothing any more.
    driver.slide(1.0, ms(500));
    assert_eq!(driver.shown().state, HOLDING);
    sleep(ms(450));
    driver.slide(1.0, ms(300));
    driver.until_state(PLAYING);
    // The viewer has asked for the wheel above; now it gets the wheel.
    assert!(driver.texts.iter().any(|text| text["type"] == "role" && text["asked"] == true));
    assert!(driver.ask(json!({ "type": "wheel", "take": false })).0);
    let is_at_the_wheel = |page: &Page| {
        let mut roles = page.texts.iter().rev().filter(|text| text["type"] == "role");
        roles.next().is_some_and(|role| role["driver"] == true)
    };
    viewer.until("the wheel", is_at_the_wheel);
    assert!(!driver.ask(json!({ "type": "home" })).0);
    assert!(driver.ask(json!({ "type": "stop" })).0);
    driver.until_state(LOWERING);
    assert!(console.was_told(&Command::Stop));
}

#[test]
fn a_show_without_a_driver_is_held() {
    let console = OtherSide::start(true);
    let (mut driver, mut viewer) = (Page::open(&console), Page::open(&console));
    driver.arm();
    assert!(driver.ask(json!({ "type": "play", "slot": 0, "loop": true })).0);
    driver.until("a show", |page| page.shown().flags & 2 != 0);
    // The page is there, and says nothing.
    let silent = Instant::now();
    let is_held = |page: &Page| {
        page.texts
            .iter()
            .any(|text| text["text"].as_str().is_some_and(|text| text.contains("nobody")))
    };
    viewer.until("a held show", is_held);
    assert!((ms(1500)..ms(2600)).contains(&silent.elapsed()), "{:?}", silent.elapsed());
    viewer.until_state(LOWERING);
    assert!(console.was_told(&Command::Play(Feed::Show)) && console.was_told(&Command::Disarm));
}

#[test]
fn commands_of_other_terminals_move_and_stop() {
    let console = OtherSide::start(false);
    let mut page = Page::open(&console);
    let jog = |by: f64| Request::Jog { joint: "turn1".to_owned(), by };
    assert!(consoles().contains(&console.name));
    page.until_state(LIMP);
    let refused = ask(&console.name, &jog(5.0)).unwrap();
    assert!(!refused.ok && refused.text.contains("limp"), "{}", refused.text);
    page.arm();
    let start = page.shown().wanted;
    let name = console.name.clone();
    let command = spawn(move || ask(&name, &jog(5.0)).unwrap());
    page.until("a command at the wheel", |page| {
        page.texts.iter().any(|text| text["other"] == "command")
    });
    // Nobody moves the rig meanwhile.
    assert!(!page.ask(json!({ "type": "jog", "dof": 0, "goal": 0.0 })).0);
    page.until("its end", |_| command.is_finished());
    let reply = command.join().unwrap();
    assert!(reply.ok, "{}", reply.text);
    page.until_state(HOLDING);
    let moved = page.shown().wanted - start;
    assert!((moved - 5_f32.to_radians()).abs() < 5e-3, "{moved}");
    for (by, why) in [(400.0, "range"), (f64::INFINITY, "")] {
        let refused = ask(&console.name, &jog(by));
        assert!(
            refused.is_err() || refused.is_ok_and(|reply| !reply.ok && reply.text.contains(why))
        );
    }
    assert!(ask(&console.name, &Request::Stop).unwrap().ok);
    page.until_state(LOWERING);
    assert!(ask(&console.name, &Request::EStop).unwrap().ok);
    page.until_state(FAULTED);
}

#[test]
fn a_simulated_play_is_no_hub_of_a_board() {
    let console = OtherSide::start(false);
    Page::open(&console).until_state(LIMP);
    let name = format!("test-{}-simulated", std::process::id());
    let mut bell = Bell::open(&name).unwrap();
    let own = console.name.clone();
    let asks = spawn(move || roles(&[name, own]));
    while !asks.is_finished() {
        assert_eq!(bell.asked(), (false, false));
        sleep(ms(5));
    }
    assert_eq!(asks.join().unwrap(), [Some(Role::Simulates), Some(Role::Drives)]);
}

#[test]
fn a_hub_that_stands_still_delays_no_stop() {
    let console = OtherSide::start(false);
    Page::open(&console).until_state(LIMP);
    let still = format!("test-{}-still", std::process::id());
    let path = private_folder().unwrap().join(format!("{still}.sock"));
    // Nobody accepts its connections.
    let _listener = UnixListener::bind(&path).unwrap();
    assert!(consoles().contains(&still));
    let begun = Instant::now();
    let replies = ask_all(&[still.clone(), console.name.clone()], &Request::Stop);
    std::fs::remove_file(path).unwrap();
    assert!(begun.elapsed() < ms(4000), "{:?}", begun.elapsed());
    assert!(replies[1].as_ref().unwrap().ok && console.was_told(&Command::Stop));
    let late = replies[0].as_ref().unwrap_err().to_string();
    assert!(late.contains("no answer within 2 s"), "{late}");
}

#[test]
fn a_stop_ends_a_command_that_waits_to_arm() {
    let board = Prepared::new(new::arm(1).unwrap(), None);
    let (told, is_busy) = (Arc::clone(&board.told), Arc::clone(&board.is_busy));
    is_busy.store(true, Ordering::Relaxed);
    let name = format!("test-{}-arms", std::process::id());
    let own = name.clone();
    let command = spawn(move || board.execute(&own, &Request::Home));
    let attempts = || {
        let told = told.lock().unwrap();
        told.commands.iter().filter(|command| **command == Command::Arm).count()
    };
    let begun = Instant::now();
    while attempts() < 3 {
        assert!(begun.elapsed() < ms(20_000) && !command.is_finished());
        sleep(ms(5));
    }
    assert!(ask(&name, &Request::Stop).unwrap().ok);
    let before = attempts();
    is_busy.store(false, Ordering::Relaxed);
    let reply = command.join().unwrap();
    assert!(!reply.ok && reply.text.contains("another terminal has stopped"), "{}", reply.text);
    assert_eq!(attempts(), before);
    assert!(told.lock().unwrap().poses.is_empty());
}

#[test]
fn a_page_that_gives_up_the_wheel_does_not_arm_any_more() {
    let console = OtherSide::start(false);
    console.is_busy.store(true, Ordering::Relaxed);
    let (mut driver, mut viewer) = (Page::open(&console), Page::open(&console));
    driver.until_state(LIMP);
    let refused = |page: &Page, id: u64| {
        page.texts.iter().any(|text| text["id"] == id && text["ok"] == false)
    };
    driver.say(&json!({ "type": "arm", "id": 100 }));
    assert!(driver.ask(json!({ "type": "wheel", "take": false })).0);
    driver.until("a refusal", |page| refused(page, 100));
    assert!(viewer.ask(json!({ "type": "wheel", "take": true })).0);
    // The page falls silent.
    viewer.say(&json!({ "type": "arm", "id": 101 }));
    let silent = Instant::now();
    while !refused(&viewer, 101) {
        viewer.hear().unwrap();
    }
    // The hub would try for 10 s.
    assert!(silent.elapsed() < ms(6000), "{:?}", silent.elapsed());
    // The board is ready, and nobody asks it to arm.
    console.is_busy.store(false, Ordering::Relaxed);
    let attempts = || {
        let told = console.told.lock().unwrap();
        told.commands.iter().filter(|command| **command == Command::Arm).count()
    };
    let before = attempts();
    sleep(ms(300));
    assert_eq!(attempts(), before);
    driver.picture = None;
    driver.until_state(LIMP);
}

#[test]
fn a_slider_reaches_the_board_soon() {
    let console = OtherSide::start(false);
    let mut page = Page::open(&console);
    page.arm();
    page.slide(1.0, ms(300));
    let newest = || console.told.lock().unwrap().jogs.last().copied().unwrap_or_default();
    let mut times = Vec::new();
    for turn in 0..60 {
        let goal = if turn % 2 == 0 { -1.0 } else { 1.0 };
        let said = Instant::now();
        page.say(&json!({ "type": "jog", "dof": 0, "goal": goal }));
        while newest() * goal <= 0.0 {
            assert!(said.elapsed() < ms(2000));
            sleep(Duration::from_micros(200));
        }
        times.push(said.elapsed());
        page.hear().unwrap();
    }
    times.sort();
    println!(
        "from a page's goal to the board's line: median {:?}, worst {:?}",
        times[30], times[59]
    );
    assert!(times[30] < ms(60), "{:?}", times[30]);
}
