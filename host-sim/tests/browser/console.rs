//! Tests of the console's page with the real hub, on a simulated board.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{command, sinew_in};
use crate::page::{Page, with_url};

/// Longest wait for a state.
const PATIENCE: Duration = Duration::from_mins(1);

/// A running console.
pub(crate) struct Served {
    process: Child,
    pub(crate) address: String,
}

impl Served {
    pub(crate) fn start(arguments: &[&str]) -> Self {
        Self::start_in(Path::new("."), arguments)
    }

    /// Starts a console in a folder, in which its page records.
    pub(crate) fn start_in(folder: &Path, arguments: &[&str]) -> Self {
        let mut process = command()
            .current_dir(folder)
            .arg("console")
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut address = String::new();
        let stdout = process.stdout.take().unwrap();
        BufReader::new(stdout).read_line(&mut address).unwrap();
        Self { process, address: address.trim().to_owned() }
    }

    /// Sends a signal to the console.
    pub(crate) fn signal(&self, signal: &str) {
        let id = self.process.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
    }

    /// Opens the page, and calls `read` with it. The page may request nothing but files of its console.
    pub(crate) fn with_page(&self, read: impl FnOnce(&Page)) {
        self.with_page_after("", read);
    }

    /// As [`Self::with_page`], with a script that runs before those of the page.
    pub(crate) fn with_page_after(&self, script: &str, read: impl FnOnce(&Page)) {
        // All addresses of files begin with that of the page, without the token.
        let origin = self.address.split('#').next().unwrap();
        with_url(script, &self.address, |request| request.starts_with(origin), read);
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Writes the desk arm and a show of it; returns their paths.
fn arm_and_show(folder: &Path) -> [String; 2] {
    let run = |arguments: &[&str]| assert!(sinew_in(folder, arguments).status.success());
    run(&["rig", "new", "--arm", "6", "--output", "arm.toml"]);
    let bake = ["bake", "punches_01", "--seconds", "2", "--rig", "arm.toml", "--fit"];
    run(&[&bake[..], &["--output", "punch.show"]].concat());
    ["arm.toml", "punch.show"].map(|name| folder.join(name).display().to_string())
}

pub(crate) fn text(page: &Page, id: &str) -> String {
    let text = page.ask(&format!("document.getElementById('{id}').textContent"));
    text.as_str().unwrap().to_owned()
}

/// Waits until an expression of the page is true.
#[track_caller]
pub(crate) fn wait_until(page: &Page, expression: &str) {
    let begun = Instant::now();
    while page.ask(expression) != true {
        let state = text(page, "state");
        let answer = text(page, "answer");
        assert!(begun.elapsed() < PATIENCE, "never: {expression}; it is {state}; {answer}");
        page.wait_ms(50);
    }
}

#[track_caller]
pub(crate) fn wait_for_state(page: &Page, state: &str) {
    wait_until(page, &format!("document.getElementById('state').textContent === '{state}'"));
}

/// Arms the rig as soon as it rests: until then, arming is refused.
#[track_caller]
pub(crate) fn arm(page: &Page) {
    let begun = Instant::now();
    while text(page, "state") == "limp" {
        assert!(begun.elapsed() < PATIENCE, "{}", text(page, "answer"));
        page.hold("#arm", 1300);
        page.wait_ms(500);
    }
    wait_for_state(page, "holding");
}

/// Returns the measured position that a joint's row shows, deg.
fn position(page: &Page, joint: usize) -> f64 {
    let shown =
        page.ask(&format!("document.querySelectorAll('#sliders .value')[{joint}].textContent"));
    shown.as_str().unwrap().trim_end_matches('°').parse().unwrap()
}

#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn a_rig_is_armed_moved_played_and_stopped_from_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = arm_and_show(folder.path());
    let console = Served::start_in(folder.path(), &["--rig", &rig, &show]);
    console.with_page(|page| {
        wait_for_state(page, "limp");
        space_and_a_short_press_do_not_arm(page);
        arm(page);
        sliders_move_joints_while_they_are_held(page);
        a_scrub_moves_the_ghost_alone(page);
        the_show_plays_loops_and_is_held(page);
        an_emergency_stop_is_a_fault_that_is_cleared(page);
        a_session_is_recorded(page, folder.path());
        arm(page);
        page.hold("#stop", 50);
        wait_for_state(page, "limp");
        for width in [1280, 400] {
            page.assert_fits(width);
        }
    });
}

fn space_and_a_short_press_do_not_arm(page: &Page) {
    page.hold("#arm", 300);
    page.ask("document.getElementById('arm').focus()");
    page.press(" ");
    page.wait_ms(1500);
    assert_eq!(text(page, "state"), "limp");
}

fn sliders_move_joints_while_they_are_held(page: &Page) {
    for joint in [0, 1, 2] {
        let before = position(page, joint);
        let share = if before > 0.0 { [0.7, 0.55] } else { [0.5, 0.65] };
        let mut held = before;
        page.drag(&format!("#joint-{joint}"), share, || {
            page.wait_ms(1500);
            held = position(page, joint);
        });
        assert!((held - before).abs() > 3.0, "joint {joint}: {before} to {held}");
        wait_for_state(page, "holding");
        page.wait_ms(300);
        let after = position(page, joint);
        page.wait_ms(500);
        let later = position(page, joint);
        assert!((later - after).abs() < 0.5, "joint {joint} stands: {after} to {later}");
    }
    // An arrow key is a step.
    page.ask("document.getElementById('joint-0').focus()");
    let before = position(page, 0);
    for _ in 0..3 {
        page.press("ArrowRight");
        page.wait_ms(200);
    }
    page.wait_ms(600);
    let moved = position(page, 0) - before;
    assert!((1.0..4.0).contains(&moved), "{moved}");
    wait_for_state(page, "holding");
}

fn a_scrub_moves_the_ghost_alone(page: &Page) {
    let before = position(page, 1);
    page.drag("#scrub", [0.3, 0.6], || page.wait_ms(300));
    wait_until(page, "document.getElementById('place').textContent.startsWith('ghost')");
    page.wait_ms(500);
    assert!((position(page, 1) - before).abs() < 0.5, "the rig does not follow");
    // It follows when it is asked.
    page.hold("#follow", 50);
    wait_for_state(page, "moving");
    wait_for_state(page, "holding");
    page.hold("#no-ghost", 50);
    wait_until(page, "!document.getElementById('place').textContent.startsWith('ghost')");
}

fn the_show_plays_loops_and_is_held(page: &Page) {
    page.hold("#play", 50);
    wait_for_state(page, "playing");
    wait_until(page, "parseFloat(document.getElementById('place').textContent) > 0.5");
    wait_for_state(page, "holding");
    page.hold("#loop", 50);
    page.hold("#play", 50);
    wait_for_state(page, "playing");
    wait_until(page, "parseFloat(document.getElementById('place').textContent) > 0.5");
    page.press("Escape");
    wait_for_state(page, "holding");
}

fn an_emergency_stop_is_a_fault_that_is_cleared(page: &Page) {
    page.hold("#estop", 50);
    wait_for_state(page, "faulted");
    wait_until(page, "!document.getElementById('faults').hidden");
    let fault = text(page, "faults");
    assert!(fault.contains("emergency stop") && fault.contains("To do"), "{fault}");
    page.hold("#faults .clear", 50);
    wait_for_state(page, "limp");
    // A warning may stay for a moment: the arm fell and swings.
    let is_told = "document.getElementById('faults').textContent.includes('Fault')";
    wait_until(page, &format!("!{is_told}"));
}

fn a_session_is_recorded(page: &Page, folder: &Path) {
    page.hold("#record", 50);
    wait_until(page, "!document.getElementById('recording').hidden");
    let file = text(page, "record-file");
    assert!(file.starts_with("Recording into ") && file.ends_with("session-1.parquet"), "{file}");
    page.wait_ms(1000);
    page.hold("#record", 50);
    wait_until(page, "document.getElementById('recording').hidden");
    let report = ["report", "session-1.parquet", "-o", "session.html"];
    assert!(sinew_in(folder, &report).status.success());
}

/// Simulates a silent servo and a hot servo. The page must name the joint and the remedy, mark the servo, and clear the
/// fault when its cause is gone.
#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn faults_are_told_with_joint_and_remedy_and_are_cleared() {
    // The second fault comes when the rig, lowered by the first, is armed again.
    let faults = ["--fault", "2:silent@10s+4s", "--fault", "3:hot=67@55s+4s"];
    let console = Served::start(&faults);
    console.with_page(|page| {
        wait_for_state(page, "limp");
        for (fault, joint, flag) in
            [("servo silent", "bend2", "bus errors"), ("hot, measured", "bend3", "hot")]
        {
            // While torque is off, such a fault is only noted.
            arm(page);
            let told = "document.getElementById('faults').textContent";
            wait_until(page, &format!("{told}.includes(\"{fault}\")"));
            let panel = text(page, "faults");
            assert!(panel.contains(joint) && panel.contains("To do: "), "{panel}");
            wait_until(
                page,
                &format!("document.getElementById('servo-table').textContent.includes('{flag}')"),
            );
            let log = text(page, "events");
            assert!(log.contains(fault), "{log}");
            // The clear is refused until the cause is gone.
            let begun = Instant::now();
            while page.ask("document.getElementById('faults').hidden") != true {
                assert!(begun.elapsed() < PATIENCE, "{}", text(page, "answer"));
                page.ask("document.querySelector('#faults .clear')?.click()");
                page.wait_ms(500);
            }
        }
    });
}

#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn a_recording_is_watched_on_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, show] = arm_and_show(folder.path());
    let recording = folder.path().join("punch.parquet").display().to_string();
    let play = ["play", &show, "--rig", &rig, "--fast", "--record", &recording];
    assert!(sinew_in(folder.path(), &play).status.success());
    let console = Served::start(&[&recording]);
    console.with_page(|page| {
        // The recording begins at power-on.
        wait_for_state(page, "off");
        assert_eq!(page.ask("document.getElementById('commands').hidden"), true);
        page.drag("#scrub", [0.1, 0.5], || page.wait_ms(300));
        wait_for_state(page, "playing");
        let place = || {
            let place = page.ask("parseFloat(document.getElementById('place').textContent)");
            place.as_f64().unwrap()
        };
        let before = place();
        page.hold("#play", 50);
        wait_until(page, "document.getElementById('play-text').textContent === 'Pause'");
        page.wait_ms(1000);
        page.hold("#play", 50);
        wait_until(page, "document.getElementById('play-text').textContent === 'Play'");
        let after = place();
        assert!((0.8..4.0).contains(&(after - before)), "{before} to {after}");
        page.wait_ms(500);
        assert!((place() - after).abs() < 0.1);
        for width in [1280, 400] {
            page.assert_fits(width);
        }
    });
}

#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn a_page_without_its_console_controls_nothing() {
    let console = Served::start(&[]);
    // A refused connection is an error of the browser's console, therefore it is counted by hand.
    console.with_page(|page| {
        wait_for_state(page, "limp");
        page.ask("WebSocket = class extends EventTarget { static OPEN = 1 }");
        console.signal("-KILL");
        wait_until(page, "!document.getElementById('lost').hidden");
        let enabled = page.ask(
            "[...document.querySelectorAll('button:enabled')].map(e => e.id).filter(id => id)",
        );
        let harmless = ["front", "tab-joints", "tab-servos", "tab-log"];
        for id in enabled.as_array().unwrap() {
            assert!(harmless.contains(&id.as_str().unwrap()), "{id} pretends to work");
        }
        assert_eq!(page.ask("document.getElementById('hold').disabled"), true);
        assert_eq!(page.ask("document.querySelectorAll('#sliders input:enabled').length"), 0);
    });
}
