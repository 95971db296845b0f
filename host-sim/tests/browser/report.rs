//! Tests of the report of an evaluation.

use sinew_evaluation::optimum::optimum;
use sinew_evaluation::{Protocol, evaluate};
use sinew_figure::FigureMotion;
use sinew_figure::builtin;
use sinew_figure::pipeline::{Settings, prepare};
use sinew_report::scene::Mannequin;
use sinew_report::{Comparison, Playback, Report, Sweep};

use crate::page::{Page, with_page};
use std::path::Path;

/// A clip's name that would be markup if it were not escaped.
const NAME: &str = "kick</script><script>throw 1</script>&amp;\"'";

fn motion() -> FigureMotion {
    let clip = builtin::clips().into_iter().find(|clip| clip.name == "kicks_01").unwrap();
    let (motion, _) = prepare(clip, &Settings::default()).unwrap();
    FigureMotion { name: NAME.into(), ..motion }
}

/// Writes a report with every kind of content.
fn write_report(folder: &Path) {
    let motions = [motion(), FigureMotion { name: "again".into(), ..motion() }];
    let protocol = Protocol { seconds: Some(4.0), ..Protocol::default() };
    let csv = folder.join("sweep.csv");
    std::fs::write(&csv, "beta,kp,all_linear_mean_cm\n0,100,3\n1,100,2\n0,200,1\n1,200,\n")
        .unwrap();
    let evaluation = evaluate(&motions, &protocol, |_| ()).unwrap();
    let mannequin = Mannequin::of_figure(&motions[0]);
    let report = Report {
        command: "sinew evaluate",
        settings: &[("Plant", "rapier".into())],
        notices: &["kick: skipped <nothing>".into()],
        evaluation: &evaluation,
        dt_s: motions[0].dt_s,
        comparison: Some(&Comparison::new(&motions[0], &protocol, 1.1).unwrap()),
        optimum: Some(&optimum(&motions, &protocol).unwrap()),
        playback: Some(&Playback::record(&motions[0], mannequin, &protocol, 0).unwrap()),
        sweep: Some(&Sweep::read(&csv).unwrap()),
    };
    report.write(folder).unwrap();
}

#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn a_reader_can_use_the_report() {
    let folder = tempfile::tempdir().unwrap();
    write_report(folder.path());
    with_page(&folder.path().join("index.html"), |page| {
        the_views_show_figures(page);
        the_scrubber_moves_the_figures(page);
        the_keyboard_turns_the_view(page);
        it_plays(page);
        choices_show_other_charts(page);
        it_fits_a_narrow_screen(page);
        it_is_dark_where_the_reader_wants_it(page);
        it_prints(page);

        let shown = page.ask("document.querySelector('#playback b').textContent");
        assert_eq!(shown, NAME, "names are text");
    });
}

fn the_views_show_figures(page: &Page) {
    // Shares of each view that are red and white, in thousandths.
    let shares = page.ask(
        "[...document.querySelectorAll('canvas')].map(c => {
            const data = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
            const shares = [0, 0];
            for (let i = 0; i < data.length; i += 4) {
                const [r, g, b] = data.slice(i, i + 3);
                if (r > 120 && g < 130 && b < 110) shares[0] += 1;
                if (r > 200 && g > 200 && b > 200) shares[1] += 1;
            }
            return shares.map(n => Math.floor(1000 * n / (c.width * c.height)));
        })",
    );
    let shares: Vec<[u64; 2]> = serde_json::from_value(shares).unwrap();
    assert_eq!(shares.len(), 2, "two methods side by side");
    for [red, white] in shares {
        // Measured: 44 and 7. The red figure hides most of the white one.
        assert!(red > 15 && white > 2, "{red} and {white} of 1000");
    }
    let pictures = page.pixels();
    assert_ne!(pictures[0], pictures[1], "the methods differ");
}

fn clock_of(page: &Page) -> String {
    page.ask("document.getElementById('clock').textContent").as_str().unwrap().to_owned()
}

fn the_scrubber_moves_the_figures(page: &Page) {
    page.ask("document.getElementById('scrubber').focus()");
    let (clock, pixels) = (clock_of(page), page.pixels());
    page.press("Home");
    let (start, at_start) = (clock_of(page), page.pixels());
    assert_eq!(start, "0.00 s");
    assert_ne!((&clock, &pixels), (&start, &at_start));
    page.press("ArrowRight");
    let (next, at_next) = (clock_of(page), page.pixels());
    assert_eq!(next, "0.02 s");
    for view in [0, 1] {
        assert_ne!(at_start[view], at_next[view], "view {view} stands still");
    }
    page.press("Home");
    assert_eq!(page.pixels(), at_start, "the same moment is the same picture");
    let read = |page: &Page| page.ask("document.querySelector('[data-readout]').textContent");
    let error = read(page);
    page.press("End");
    assert_ne!(read(page), error, "the errors are those of the moment");
}

fn the_keyboard_turns_the_view(page: &Page) {
    page.ask("document.querySelector('canvas').focus()");
    let before = page.pixels();
    for key in ["ArrowLeft", "ArrowUp", "+"] {
        let pixels = page.pixels();
        page.press(key);
        assert_ne!(page.pixels()[0], pixels[0], "{key}");
    }
    assert_ne!(page.pixels()[1], before[1], "both views turn");
    page.ask("document.getElementById('reset').click()");
    page.settle();
    assert_eq!(page.pixels(), before);
}

fn it_plays(page: &Page) {
    page.ask("document.getElementById('scrubber').focus()");
    page.press("Home");
    page.press(" ");
    let label = "document.getElementById('play').getAttribute('aria-label')";
    assert_eq!(page.ask(label), "Pause");
    page.wait_ms(400);
    page.press(" ");
    assert_eq!(page.ask(label), "Play");
    let clock = clock_of(page);
    let seconds: f64 = clock.trim_end_matches(" s").parse().unwrap();
    assert!((0.2..4.0).contains(&seconds), "0.4 s of playing went to {clock}");
    page.settle();
    assert_eq!(clock_of(page), clock, "it has stopped");
}

fn choices_show_other_charts(page: &Page) {
    let shown = "[...document.querySelectorAll('#time .pair')].filter(p => !p.hidden).map(p => ({...p.dataset}))";
    let before = page.ask(shown);
    assert_eq!(before.as_array().unwrap().len(), 1);
    page.ask(
        "[['clip', '1'], ['figure', '0'], ['statistic', 'max']].forEach(([name, value]) => {
            const select = document.querySelector(`#time [data-choice=${name}]`);
            select.value = value;
            select.dispatchEvent(new Event('change'));
        })",
    );
    let after = page.ask(shown);
    assert_eq!(after, serde_json::json!([{ "clip": "1", "figure": "0", "statistic": "max" }]));
    assert_ne!(after, before);
}

fn it_fits_a_narrow_screen(page: &Page) {
    for width in [1280, 768, 400] {
        page.assert_fits(width);
    }
}

fn it_is_dark_where_the_reader_wants_it(page: &Page) {
    let ground = "getComputedStyle(document.body).backgroundColor";
    page.emulate("screen", "light");
    assert_eq!(page.ask(ground), "rgb(255, 255, 255)");
    page.emulate("screen", "dark");
    assert_eq!(page.ask(ground), "rgb(18, 23, 29)");
}

fn it_prints(page: &Page) {
    page.emulate("print", "dark");
    let display = |what: &str| {
        page.ask(&format!("getComputedStyle(document.querySelector('{what}')).display"))
    };
    assert_eq!(display(".player"), "none");
    assert_eq!(display(".still"), "block", "a still stands in for the playback");
    let ground = page.ask("getComputedStyle(document.body).backgroundColor");
    assert_eq!(ground, "rgb(255, 255, 255)", "paper is light");
    let pdf = page.pdf();
    assert!(pdf.starts_with(b"%PDF") && pdf.len() > 50_000, "{} bytes", pdf.len());
}
