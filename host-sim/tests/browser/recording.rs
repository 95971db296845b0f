//! Tests of the page of a recording.

use std::path::Path;

use sinew_performance::play::{Part, Recording};

use crate::common::{sinew_in, text};
use crate::page::{Page, with_page};
use crate::player::{clock, it_plays_and_stops, seek};

/// Returns a recording of an arm with three joints that plays for 2 s, and its page.
fn recorded(folder: &Path) -> [std::path::PathBuf; 2] {
    let sinew = |arguments: &[&str]| {
        let output = sinew_in(folder, arguments);
        let told = text(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {told}");
    };
    sinew(&["rig", "new", "--arm", "3", "-o", "arm.toml"]);
    let curve = "rig = \"arm\"\nclip = \"punches_01\"\n\n[[curve]]\nclip = \"forearm_l\"\naxis = [0, 0, 1]\n\
                 rig = \"bend2\"\npoints_deg = [[-180, -60], [180, 60]]\n";
    std::fs::write(folder.join("map.toml"), curve).unwrap();
    let play = ["play", "punches_01", "--rig", "arm.toml", "--mapping", "map.toml"];
    let record = ["--seconds", "2", "--record", "arm.parquet"];
    sinew(&[&play[..], &record].concat());
    sinew(&["report", "arm.parquet"]);
    ["arm.parquet", "arm.html"].map(|name| folder.join(name))
}

#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn a_builder_sees_how_a_rig_followed() {
    let folder = tempfile::tempdir().unwrap();
    let [file, html] = recorded(folder.path());
    let recording = Recording::open(&file).unwrap();
    let parts: Vec<Part> = recording.parts().map(Result::unwrap).collect();
    with_page(&html, |page| {
        it_plays_and_stops(page);
        the_plots_say_what_was_recorded(page, &recording, &parts);
        the_largest_error_leads_to_its_time(page, &parts);
        a_state_leads_to_its_time(page);
        a_joint_is_chosen_by_its_row(page);
        for width in [1280, 768, 400] {
            page.assert_fits(width);
        }
    });
}

fn choose(page: &Page, joint: usize) {
    page.ask(&format!(
        "(s => {{ s.value = {joint}; s.dispatchEvent(new Event('change')); }})(document.getElementById('joint')) ?? 0"
    ));
}

/// Checks that the plots show the recorded numbers, although the page stores them in 16 bits and one decimal.
fn the_plots_say_what_was_recorded(page: &Page, recording: &Recording, parts: &[Part]) {
    let joint = recording.joints().iter().position(|name| name == "bend2").unwrap();
    let chosen = page.ask("RIG.dofs.findIndex(({ name }) => name === 'bend2')");
    choose(page, usize::try_from(chosen.as_u64().unwrap()).unwrap());
    // A sample is 10 ticks of 2 ms; the row of time t is the tick that ended at t.
    for row in [0, 800, 900, 1000, 1200] {
        seek(page, row as f64 * 0.002);
        for (class, course) in [
            ("commanded", &parts[0].joints[joint].commanded),
            ("measured", &parts[0].joints[joint].measured),
        ] {
            let text =
                page.ask(&format!("document.querySelector('#charts .value.{class}').textContent"));
            let text = text.as_str().unwrap().replace('−', "-");
            let number = text.trim_start_matches(class).trim().trim_end_matches('°');
            let degrees: f64 = number.parse().unwrap();
            let recorded = f64::from(course[row]).to_degrees();
            assert!((degrees - recorded).abs() <= 0.06, "{row}: {text} {recorded}");
        }
    }
}

fn the_largest_error_leads_to_its_time(page: &Page, parts: &[Part]) {
    page.ask("document.querySelector('#joints tbody [data-at]').click()");
    page.settle();
    let playing = parts.iter().flat_map(|part| {
        let rows = part.time_s.iter().zip(&part.runs).zip(&part.joints[0].error);
        rows.filter(|((_, runs), _)| **runs)
    });
    // The first of equal errors.
    let (at_s, _) = playing.fold((0.0, 0.0), |(at_s, most), ((time_s, _), error)| {
        if error.abs() > most { (*time_s, error.abs()) } else { (at_s, most) }
    });
    assert!((clock(page) - at_s).abs() < 0.01, "{} {at_s}", clock(page));
    // The click on the row has also selected its joint.
    assert_eq!(page.ask("document.getElementById('joint').value"), "0");
}

fn a_state_leads_to_its_time(page: &Page) {
    let states = "[...document.querySelectorAll('#excesses li')].map(e => e.textContent)";
    let told = page.ask(states).to_string();
    for state in ["limp", "arming", "playing", "lowering"] {
        assert!(told.contains(state), "{told}");
    }
    let item = "[...document.querySelectorAll('#excesses button')].find(e => e.textContent.includes('playing'))";
    page.ask(&format!("{item}.click()"));
    page.settle();
    let begin = page.ask("SHOW.states.find(({ name }) => name === 'playing').from_s");
    assert!((clock(page) - begin.as_f64().unwrap()).abs() < 0.01);
    assert_eq!(page.ask(&format!("{item}.classList.contains('now')")), true);
}

fn a_joint_is_chosen_by_its_row(page: &Page) {
    let titles = "[...document.querySelectorAll('#charts .area')].map(e => e.ariaLabel)";
    let before = page.ask(titles);
    page.ask("document.querySelectorAll('#joints tbody th button')[1].focus()");
    page.press("Enter");
    assert_eq!(page.ask("document.getElementById('joint').value"), "1");
    assert_ne!(page.ask(titles), before);
    assert_eq!(page.ask("document.querySelectorAll('#joints [aria-pressed=true]').length"), 1);
}
