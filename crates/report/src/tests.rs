//! Tests of the report of a rig.

use sinew_evaluation::exercise::{ExerciseSettings, make_exercises};
use sinew_evaluation::{MethodName, Protocol, evaluate};
use sinew_figure::plant::PlantKind;

use super::scene::Mannequin;
use super::scene::fixture::arm;
use super::text::Words;
use super::*;

/// Calls `read` with a report of 2 s of the arm's motions, with every method for rigs.
fn with_report(read: impl FnOnce(&Report<'_>)) {
    let arm = arm();
    let settings =
        ExerciseSettings { shares: vec![0.6], seconds: 2.0, ..ExerciseSettings::default() };
    let takes = make_exercises("six<", &arm, &settings).unwrap();
    let all = MethodName::ALL.into_iter().filter(|method| *method != MethodName::Accumulated);
    let mut protocol = Protocol {
        scales: vec![1.0],
        methods: all.collect(),
        seconds: Some(2.0),
        ..Protocol::default()
    };
    protocol.setup.plant.kind = PlantKind::Articulated;
    let evaluation = evaluate(&takes, &protocol, |_| ()).unwrap();
    let playback = Playback::record(&takes[1], Mannequin::of_rig(&arm), &protocol, 1).unwrap();
    read(&Report {
        command: "sinew evaluate",
        settings: &[],
        notices: &["a note".into()],
        evaluation: &evaluation,
        dt_s: settings.rate_hz.recip(),
        comparison: None,
        optimum: None,
        playback: Some(&playback),
        sweep: None,
    });
}

/// Returns the visible text of a page, without scripts and their data.
fn text(page: &str) -> String {
    let body = &page[page.find("<body>").unwrap()..];
    let parts = body.split("<script");
    parts.map(|part| part.split_once("</script>").map_or(part, |(_, rest)| rest)).collect()
}

#[test]
fn a_page_of_a_rig_speaks_of_the_rig_alone() {
    with_report(|report| {
        let page = text(&report.html()).to_lowercase();
        for word in ["paper", "pelvis", "hands", "clip ", "clips", "figure ×", "of the figure"] {
            let place = page.find(word);
            let around = |at: usize| page[..at].chars().rev().take(60).collect::<String>();
            assert!(
                place.is_none(),
                "{word} behind, backwards: {}",
                place.map_or_else(String::new, around)
            );
        }
        for words in
            ["rig six&lt; follows its motions", "rig six&lt;: errors divided by", "results"]
        {
            assert!(page.contains(words), "{words}");
        }
        assert!(page.contains("2 motions, 1,9"), "two of 2 s at 500 Hz");
    });
}

#[test]
fn pictures_of_a_rig_show_all_its_parts() {
    with_report(|report| {
        let names: Vec<String> = report.pictures().into_iter().map(|(name, _)| name).collect();
        for name in ["ratios-x1", "front-x1", "course-x1", "joints-x1", "distribution-x1"] {
            assert!(names.iter().any(|found| found == name), "{name} is not among {names:?}");
        }
        assert!(!names.iter().any(|name| name == "figure4"));
        let playback = report.playback.unwrap();
        let moving = animation::animation(playback, Words::of(report.evaluation)).unwrap().0;
        assert!(moving.contains("followed with Recommended by rig six&lt;."), "{}", &moving[..400]);
        // A base, six joints and no trunk; desired and actual parts.
        let moments = moving.matches("class=\"moment").count();
        assert_eq!(moving.matches("class=\"part\"").count(), 2 * 7 * moments);
        for part in moving.split("translate(").skip(1) {
            let place: Vec<f64> =
                part.split(')').next().unwrap().split(' ').map(|x| x.parse().unwrap()).collect();
            let inside = (0.0..scene::STAGE_WIDTH).contains(&place[0])
                && (0.0..scene::STAGE_HEIGHT).contains(&place[1]);
            assert!(inside, "a part at {place:?}");
        }
    });
}
