//! Tests of the report of a rig.

use sinew_evaluation::exercise::{ExerciseSettings, make_exercises};
use sinew_evaluation::{MethodName, Protocol, evaluate};
use sinew_figure::plant::PlantKind;
use sinew_report::scene::Mannequin;
use sinew_report::{Playback, Report};
use std::path::Path;

use crate::page::{Page, with_page};

fn write_report(folder: &Path) {
    let description = sinew_rig::new::arm(6).unwrap();
    let mechanism = description.mechanism().unwrap();
    let settings =
        ExerciseSettings { shares: vec![0.6], seconds: 2.0, ..ExerciseSettings::default() };
    let takes = make_exercises(&description.name, &mechanism, &settings).unwrap();
    let mut protocol = Protocol {
        scales: vec![1.0],
        methods: vec![MethodName::Local, MethodName::Recommended],
        seconds: Some(2.0),
        ..Protocol::default()
    };
    protocol.setup.plant.kind = PlantKind::Articulated;
    // Without this error of the masses, nothing red is visible.
    protocol.setup.disturbance.masses = 0.15;
    let evaluation = evaluate(&takes, &protocol, |_| ()).unwrap();
    let mannequin = Mannequin::of_rig(&mechanism);
    let report = Report {
        command: "sinew evaluate --rig arm.toml",
        settings: &[("Plant", "articulated".into())],
        notices: &[],
        evaluation: &evaluation,
        dt_s: settings.rate_hz.recip(),
        comparison: None,
        optimum: None,
        playback: Some(&Playback::record(&takes[1], mannequin, &protocol, 1).unwrap()),
        sweep: None,
    };
    report.write(folder).unwrap();
}

#[test]
#[ignore = "needs SINEW_CHROMIUM"]
fn a_builder_can_use_the_report_of_a_rig() {
    let folder = tempfile::tempdir().unwrap();
    write_report(folder.path());
    with_page(&folder.path().join("index.html"), |page| {
        the_rig_is_large_and_whole(page);
        there_is_no_choice_of_one(page);
        for width in [1280, 768, 400] {
            page.assert_fits(width);
        }
    });
}

/// Checks that the pixels of the rig, which are lighter or redder than the ground, fill a large part of the view and do
/// not reach its edges.
fn the_rig_is_large_and_whole(page: &Page) {
    let boxes = page.ask(
        "[...document.querySelectorAll('canvas')].map(c => {
            const data = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
            const box = [1, 1, 0, 0];
            for (let i = 0; i < data.length; i += 4) {
                const [r, g, b] = data.slice(i, i + 3);
                if (!(r > 120 && g < 130 && b < 110) && !(r > 200 && g > 200 && b > 200)) continue;
                const x = (i / 4 % c.width) / c.width, y = Math.floor(i / 4 / c.width) / c.height;
                box[0] = Math.min(box[0], x); box[1] = Math.min(box[1], y);
                box[2] = Math.max(box[2], x); box[3] = Math.max(box[3], y);
            }
            return box;
        })",
    );
    let boxes: Vec<[f64; 4]> = serde_json::from_value(boxes).unwrap();
    assert_eq!(boxes.len(), 2, "two methods side by side");
    for [left, top, right, bottom] in boxes {
        assert!((right - left).max(bottom - top) > 0.35, "{left} {top} {right} {bottom}");
        assert!(left > 0.02 && top > 0.02 && right < 0.98 && bottom < 0.98);
    }
}

fn there_is_no_choice_of_one(page: &Page) {
    let shown = page.ask(
        "[...document.querySelectorAll('select')].filter(s => s.offsetParent && s.options.length < 2).length",
    );
    assert_eq!(shown, 0);
}
