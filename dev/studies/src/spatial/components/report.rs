//! Formats the study as tables and as JSON.

use std::fmt::Write as _;

use comfy_table::Table;
use serde_json::{Value, json};
use sinew_pose_metrics::spatial::{Metric, Weighting};

use super::{Figure, Plan, RecordingGroup, RecordingResult, Study, mode_of_paper};
use crate::recordings::{Class, Sequence};
use crate::spatial::mann_whitney;
use crate::spatial::sample::Sample;
use crate::tables::{aligned, table};

/// Reason why writing cannot fail.
const WRITTEN: &str = "a string takes everything";

/// Shares of the first component by both methods.
const WAYS: [Figure; 2] = [|one| one.mds, |one| one.isomap];

/// Formats three tables: the components of the two walks; the components of all recordings, for every measure; and, by
/// kind of recording, the angle metric compared with the geodesic line.
pub fn tables(plan: &Plan<'_>, study: &Study) -> String {
    let mut text = String::new();
    let walker = |walk: &Sequence| {
        let name = walk.file.rsplit('/').next().unwrap_or(&walk.file);
        format!("{name} ({} poses)", walk.frames.len())
    };
    let [first, second] = plan.walks.map(walker);
    let root = if plan.roots.is_empty() { "their roots".to_owned() } else { plan.roots.join(", ") };
    writeln!(text, "Poses seen from {root}, lines in {} steps, shares in %", plan.steps)
        .expect(WRITTEN);
    writeln!(text, "\n{first} and {second} in one embedding: components").expect(WRITTEN);
    writeln!(text, "{}", walks(study)).expect(WRITTEN);
    let poses: usize = study.recordings.iter().map(|one| one.frames).sum();
    writeln!(
        text,
        "\nFirst components of {} recordings, {poses} poses; Isomap joins every pose with its {} nearest",
        study.recordings.len(),
        plan.neighbours
    )
    .expect(WRITTEN);
    writeln!(text, "{}", measures(study)).expect(WRITTEN);
    writeln!(
        text,
        "\nFirst components under angles and under the line, and the test of Mann and Whitney between them"
    )
    .expect(WRITTEN);
    writeln!(text, "{}", groups(study)).expect(WRITTEN);
    text
}

fn walks(study: &Study) -> Table {
    let mut table = table(["measure", "first", "second", "third", "negative"]);
    for (measure, embedding) in &study.walks {
        let spectrum = &embedding.spectrum;
        let share = |index: usize| percent(spectrum.shares.get(index).copied());
        table.add_row([
            measure.to_string(),
            share(0),
            share(1),
            share(2),
            percent(Some(spectrum.negative_share)),
        ]);
    }
    aligned(table)
}

fn measures(study: &Study) -> Table {
    let mut table = table([
        "measure",
        "MDS 25 %",
        "median",
        "75 %",
        "mode",
        "of paper",
        "negative",
        "Isomap 25 %",
        "median",
        "75 %",
        "mode",
        "together",
    ]);
    let all = [Weighting::Alike, Weighting::Importance];
    for (metric, weighting) in Metric::ALL.into_iter().flat_map(|metric| all.map(|w| (metric, w))) {
        let of = |figure: Figure| {
            Sample::new(Study::figures(&study.recordings, metric, weighting, figure))
        };
        let quartiles = |sample: &Sample| {
            [0.25, 0.5, 0.75].map(|share| percent(sample.quantile(share))).into_iter()
        };
        let (mds, isomap) = (of(|c| c.mds), of(|c| c.isomap));
        let name = match weighting {
            Weighting::Alike => metric.name().to_owned(),
            Weighting::Importance => format!("{}, weighted", metric.name()),
        };
        let paper = if weighting == Weighting::Alike { mode_of_paper(metric) } else { None };
        let mut row = vec![name];
        row.extend(quartiles(&mds));
        row.push(whole_percent(mds.mode()));
        row.push(whole_percent(paper));
        row.push(percent(of(|c| c.mds_negative).quantile(0.5)));
        row.extend(quartiles(&isomap));
        row.push(whole_percent(isomap.mode()));
        row.push(percent(of(|c| c.together).mean()));
        table.add_row(row);
    }
    aligned(table)
}

/// Returns the kinds of recordings, with their names.
fn kinds(study: &Study) -> Vec<(String, Vec<&RecordingResult>)> {
    let mut kinds: Vec<(String, Vec<&RecordingResult>)> = Vec::new();
    let mut add = |name: &str, is: &dyn Fn(&RecordingResult) -> bool| {
        let own: Vec<&RecordingResult> = study.recordings.iter().filter(|one| is(one)).collect();
        if !own.is_empty() {
            kinds.push((name.to_owned(), own));
        }
    };
    add("all", &|_| true);
    for part in RecordingGroup::ALL {
        add(part.name(), &|one| one.part() == part);
        for (class, name) in [
            (Class::Walk, "walking"),
            (Class::Run, "running"),
            (Class::Punch, "punches"),
            (Class::Kick, "kicks"),
            (Class::Mixed, "both"),
            (Class::Other, "other motion"),
        ] {
            add(&format!("- {name}"), &|one| one.part() == part && one.class == class);
        }
    }
    for (low, high) in [(0, 30), (30, 60), (60, 120), (120, 240), (240, usize::MAX)] {
        let name = match high {
            usize::MAX => format!("from {low} poses"),
            _ => format!("{low} to {} poses", high - 1),
        };
        add(&name, &|one| (low..high).contains(&one.frames));
    }
    kinds
}

fn groups(study: &Study) -> Table {
    let mut table = table([
        "recordings",
        "number",
        "MDS angles",
        "mode",
        "line",
        "mode",
        "p",
        "Isomap angles",
        "mode",
        "line",
        "mode",
        "p",
    ]);
    let paper = |name: &str, p: &str| {
        let mode = |metric| whole_percent(mode_of_paper(metric));
        let both = [String::new(), mode(Metric::Angles), String::new(), mode(Metric::Line)];
        [name.to_owned(), "673".to_owned()].into_iter().chain(both).chain([p.to_owned()])
    };
    table.add_row(paper("the paper's", "< 1e-6").chain(std::iter::repeat_n(String::new(), 5)));
    for (name, own) in kinds(study) {
        let mut row = vec![name, own.len().to_string()];
        for figure in WAYS {
            let of = |metric| {
                let own = own.iter().copied();
                Study::figures(own, metric, Weighting::Alike, figure)
            };
            let (angles, line) = (of(Metric::Angles), of(Metric::Line));
            let p = mann_whitney::test(&angles, &line).map(|test| test.p);
            for values in [angles, line] {
                let sample = Sample::new(values);
                row.push(percent(sample.quantile(0.5)));
                row.push(whole_percent(sample.mode()));
            }
            row.push(p.map_or(String::new(), probability));
        }
        table.add_row(row);
    }
    aligned(table)
}

fn percent(share: Option<f64>) -> String {
    share.map_or(String::new(), |share| format!("{:.1}", 100.0 * share))
}

/// Formats a share in whole percent, the resolution of a mode.
fn whole_percent(share: Option<f64>) -> String {
    share.map_or(String::new(), |share| format!("{:.0}", 100.0 * share))
}

fn probability(p: f64) -> String {
    if p < 1e-3 { format!("{p:.0e}") } else { format!("{p:.3}") }
}

/// Returns everything as JSON: both walks' places, every recording under every measure.
pub fn json(plan: &Plan<'_>, study: &Study) -> Value {
    let walks: Vec<Value> = study
        .walks
        .iter()
        .map(|(measure, embedding)| {
            json!({
                "measure": measure.to_string(),
                "shares": embedding.spectrum.shares,
                "negative_share": embedding.spectrum.negative_share,
                "places": embedding.places,
            })
        })
        .collect();
    let recording = |one: &RecordingResult| {
        let components: serde_json::Map<String, Value> = plan
            .measures()
            .zip(&one.components)
            .map(|(measure, components)| (measure.to_string(), json!(components)))
            .collect();
        json!({
            "file": one.file,
            "data_set": one.data_set,
            "skeleton": one.kind,
            "class": one.class,
            "frames": one.frames,
            "measures": components,
        })
    };
    json!({
        "schema": "sinew-study-mds/1",
        "steps": plan.steps,
        "roots": plan.roots,
        "neighbours": plan.neighbours,
        "walks": {
            "files": plan.walks.map(|walk| &walk.file),
            "first_frames": study.first_frames,
            "embeddings": walks,
        },
        "recordings": study.recordings.iter().map(recording).collect::<Vec<_>>(),
    })
}
