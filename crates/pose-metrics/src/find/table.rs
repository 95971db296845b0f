//! Writes the found moments as a table, JSON and CSV.

use std::fmt::Write as _;

use comfy_table::{CellAlignment, Table, presets};
use serde::Serialize;

use super::library::{Library, Query};
use super::search::{Found, Moment};
use crate::spatial::{Measure, Weighting};

/// Returns an aligned table with a row per moment, and the cost of the search.
pub fn text(query: &Query, library: &Library, measure: Measure, found: &Found) -> String {
    let mut table = Table::new();
    let distance = format!("distance {}", measure.metric.unit());
    table.load_style(presets::NOTHING).set_header(["", "clip", "time s", "frame", &distance]);
    for (rank, row) in rows(query, library, found).enumerate() {
        let Row { clip, time_s, frame, distance, .. } = row;
        table.add_row([
            (rank + 1).to_string(),
            clip.to_owned(),
            format!("{time_s:.3}"),
            frame.to_string(),
            format!("{distance:.4}"),
        ]);
    }
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        if index != 1 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let work = &found.work;
    let mut text = String::new();
    let mut line = |line: &str| writeln!(text, "{line}").expect("a string takes everything");
    line(&format!("like {}, by {measure}", what(query)));
    line(&format!(
        "{} clips at {} Hz, {} places; of {} distances {} computed, {:.1} % spared",
        library.clips.len(),
        query.rate_hz,
        work.places,
        work.all,
        work.computed,
        100.0 * work.spared()
    ));
    line("");
    line(&table.trim_fmt());
    text
}

/// Describes the query in words.
fn what(query: &Query) -> String {
    let Query { name, start_s, rate_hz, .. } = query;
    if query.is_pose {
        format!("the pose of {name} at {start_s:.3} s")
    } else {
        let end_s = start_s + (query.poses.len() - 1) as f64 / rate_hz;
        format!("{name} from {start_s:.3} to {end_s:.3} s (root mean square over its frames)")
    }
}

#[derive(Serialize)]
struct Row<'a> {
    clip: &'a str,
    file: String,
    time_s: f64,
    frame: usize,
    distance: f64,
}

fn rows<'a>(
    query: &Query,
    library: &'a Library,
    found: &'a Found,
) -> impl Iterator<Item = Row<'a>> {
    let rate_hz = query.rate_hz;
    found.moments.iter().map(move |Moment { clip, pose, distance }| {
        let clip = &library.clips[*clip];
        let time_s = clip.seconds(*pose, rate_hz);
        Row {
            clip: &clip.name,
            file: clip.file.display().to_string(),
            time_s,
            frame: clip.frame(time_s),
            distance: *distance,
        }
    })
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    query: String,
    query_start_s: f64,
    query_frames: usize,
    metric: &'static str,
    weighted: bool,
    steps: u16,
    unit: &'static str,
    rate_hz: f64,
    clips: usize,
    left_out: usize,
    places: usize,
    distances: usize,
    computed: usize,
    moments: Vec<Row<'a>>,
}

/// Returns one JSON object, schema `sinew-find/1`: the query, the measure, the cost of the search, and the
/// moments, nearest first.
pub fn json(query: &Query, library: &Library, measure: Measure, found: &Found) -> String {
    let document = Document {
        schema: "sinew-find/1",
        query: query.file.display().to_string(),
        query_start_s: query.start_s,
        query_frames: query.poses.len(),
        metric: measure.metric.name(),
        weighted: measure.weighting == Weighting::Importance,
        steps: measure.steps,
        unit: measure.metric.unit(),
        rate_hz: query.rate_hz,
        clips: library.clips.len(),
        left_out: library.left_out.len(),
        places: found.work.places,
        distances: found.work.all,
        computed: found.work.computed,
        moments: rows(query, library, found).collect(),
    };
    let text = serde_json::to_string_pretty(&document).expect("all keys are texts");
    text + "\n"
}

/// Returns a row per moment, nearest first.
pub fn csv(query: &Query, library: &Library, found: &Found) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows(query, library, found) {
        writer.serialize(row).expect("memory takes everything");
    }
    let bytes = writer.into_inner().expect("memory takes everything");
    String::from_utf8(bytes).expect("names are UTF-8")
}
