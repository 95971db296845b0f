//! The sound that the console's page plays with a show, compared with the jaw: the sound is heard in the browser, the
//! jaw is seen in the simulated mechanism. No estimate of the page is used.

mod board;
mod clicks;
mod heard;
mod offsets;

use std::path::Path;
use std::time::Instant;

use crate::common::sinew_in;
use crate::console::{Served, arm, text, wait_for_state, wait_until};
use crate::page::Page;
use heard::{Compared, Heard, TAP, compare};
use offsets::{BoardClock, Offsets, START_S, openings};

/// Largest uncertainty of a comparison of the sound's time with the jaw's, s: an eighth of the limit of the drift.
const UNCERTAIN_S: f64 = 0.0025;

/// The machine has stopped the simulated board too often.
const BUSY: &str = "this machine is too busy to measure: it has stopped the simulated board";

/// Returns the duration of the show, s: that of the variable `SINEW_SOUND_S`, otherwise 40.
fn duration_s() -> u32 {
    std::env::var("SINEW_SOUND_S").ok().and_then(|text| text.parse().ok()).unwrap_or(40)
}

fn wait_for_sound(page: &Page, plays: bool) {
    wait_until(page, &format!("document.getElementById('sound').dataset.plays === '{plays}'"));
}

/// Makes a face and a show of `seconds` whose jaw opens at each click.
fn bake(folder: &Path, seconds: u32) {
    std::fs::write(folder.join("clicks.wav"), clicks::wav(seconds)).unwrap();
    std::fs::write(folder.join("clicks.csv"), clicks::keys(seconds)).unwrap();
    for arguments in [
        "rig new --face --output face.toml",
        "bake clicks.csv --rig face.toml --sound clicks.wav --tolerance-deg 0.05 -o clicks.show",
    ] {
        let arguments: Vec<_> = arguments.split(' ').collect();
        assert!(sinew_in(folder, &arguments).status.success(), "{arguments:?}");
    }
}

/// A show that was played and heard. Times are seconds since `start`, except those of `heard`.
struct Played {
    start: Instant,
    heard: Heard,
    /// The page's clock before and after the show.
    compared: [Compared; 2],
    end_s: f64,
    /// Log of the console's page.
    log: String,
}

impl Played {
    /// Plays the show of a console once, until the rig holds.
    fn once(page: &Page, start: Instant, seconds: u32) -> Self {
        wait_for_state(page, "limp");
        arm(page);
        let before = compare(page, start);
        page.hold("#play", 50);
        wait_for_sound(page, true);
        // A command of the browser may take two minutes, so the show is not waited for at once.
        (3..seconds).for_each(|_| page.wait_ms(1000));
        wait_for_state(page, "holding");
        wait_for_sound(page, false);
        let compared = [before, compare(page, start)];
        let (heard, log) = (Heard::of(page), text(page, "events"));
        Self { start, heard, compared, end_s: start.elapsed().as_secs_f64(), log }
    }

    /// Returns a time of the page.
    fn of_page(&self, page_s: f64) -> f64 {
        let [before, after] = self.compared;
        page_s - 0.5 * (before.start_s + after.start_s)
    }

    /// Returns the largest error of a click's time, s: of the comparison of clocks, and the difference between two ways
    /// to find when a block of the sound was heard.
    fn uncertain_s(&self) -> f64 {
        let [before, after] = self.compared;
        let clocks_s = before.error_s.max(after.error_s) + (before.start_s - after.start_s).abs();
        let ways = self
            .heard
            .clicks
            .iter()
            .map(|(at, _)| (self.heard.told_s(*at) - self.heard.computed_s(*at)).abs());
        let mut ways: Vec<f64> = ways.collect();
        ways.sort_by(f64::total_cmp);
        clocks_s + ways[ways.len() / 2]
    }
}

/// The sound starts within 40 ms of the jaw, drifts by less than 20 ms, and begins and ends with the show.
#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn the_sound_keeps_the_time_of_the_board() {
    let folder = tempfile::tempdir().unwrap();
    let seconds = duration_s();
    bake(folder.path(), seconds);
    let start = Instant::now();
    let mut played = None;
    let (rig, link) = (folder.path().join("face.toml"), folder.path().join("board"));
    let seen = board::watched(&rig, "jaw", &link, || {
        let options = ["--rig", "face.toml", "--target", "board", "--no-open", "clicks.show"];
        let console = Served::start_in(folder.path(), &options);
        console.with_page_after(TAP, |page| {
            played = Some(Played::once(page, start, seconds));
            // A hold stops the sound, too.
            page.hold("#play", 50);
            wait_for_sound(page, true);
            page.press("Escape");
            wait_for_sound(page, false);
            page.wait_ms(100);
            let last = Heard::of(page).sounds.pop();
            assert!(last.is_some_and(|(_, end)| end.is_some()), "the sound is over: {last:?}");
        });
    });
    let played = played.unwrap();
    judge(&played, &seen, seconds);
}

/// Compares the sound of a played show with what was seen of its jaw.
fn judge(played: &Played, seen: &[board::Seen], seconds: u32) {
    let here_s = |seen: &board::Seen| (seen.at - played.start).as_secs_f64();
    let during = || seen.iter().filter(|seen| here_s(seen) < played.end_s);
    let clock = BoardClock::new(during().map(|seen| (seen.board_s, here_s(seen))));
    let goals: Vec<_> = (during().map(|seen| (seen.board_s, seen.pulse_us)))
        .filter(|(_, pulse_us)| *pulse_us > 0.0)
        .collect();
    let jaw: Vec<_> = during().map(|seen| (seen.board_s, seen.shaft_rad)).collect();
    let [goals, jaw] = [goals, jaw].map(|positions| openings(&positions));
    let heard = &played.heard;
    let count = seconds as usize - 1;
    let counts = [heard.clicks.len(), goals.len(), jaw.len()];
    assert_eq!(counts, [count; 3], "clicks, goals, openings; {:?}; {}", heard.sounds, played.log);
    for (index, (at, until)) in heard.clicks.iter().enumerate() {
        let duration_s = until.unwrap() - at;
        // A click is 3 ms longer or shorter than the next; steering changes it by 2 % at most.
        assert!((duration_s - clicks::duration_s(index)).abs() < 0.0015, "{index}: {duration_s} s");
    }

    let heard_s = |at: f64| played.of_page(heard.told_s(at));
    // The show's clock starts a second before its first click.
    let begin_s = goals[0] - 1.0;
    let mut by_jaw = Vec::new();
    let mut by_goal = Vec::new();
    for (index, (at, _)) in heard.clicks.iter().enumerate() {
        let click_s = heard_s(*at);
        let [jaw_s, goal_s] = [jaw[index], goals[index]].map(|board_s| clock.here_s(board_s));
        let counts = clock.is_calm(goals[index], begin_s - 1.0);
        let late = [click_s - jaw_s, click_s - goal_s].map(|late_s| 1e3 * late_s);
        println!("click {index}: {late:.1?} ms behind the jaw and its goal; counts: {counts}");
        assert!(counts || index > 0, "{BUSY}");
        if counts {
            by_jaw.push((jaw_s, click_s));
            by_goal.push((goal_s, click_s));
        }
    }
    assert!(2 * by_jaw.len() >= count, "{BUSY}");
    let [by_jaw, by_goal] = [by_jaw, by_goal].map(|pairs| Offsets::of(&pairs));
    // The first sound is audible at once, not only in time.
    let begin_late_s = heard_s(heard.sounds[0].0) - clock.here_s(begin_s);
    println!("{seconds} s. The sound behind the jaw: {by_jaw}");
    println!("behind the goals of the jaw: {by_goal}");
    println!("it begins {:.1} ms after the show's clock", 1e3 * begin_late_s);
    println!("uncertain: {:.1} ms", 1e3 * played.uncertain_s());
    assert!(played.uncertain_s() < UNCERTAIN_S);
    assert!(by_jaw.is_in_time(), "{by_jaw}");
    assert!(begin_late_s.abs() < START_S, "{begin_late_s} s");
}
