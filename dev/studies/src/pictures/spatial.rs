//! Pictures of the studies of spatial measures.

use std::io;
use std::path::{Path, PathBuf};

use maud::Markup;
use sinew_pose_metrics::spatial::{Metric, Weighting};
use sinew_report::chart::{Histograms, Panel, Plane, planes};
use sinew_report::file::write_all;

use crate::spatial::components::{self, Figure, RecordingGroup};
use crate::spatial::geodesic_ratio::{Outcome, PAPER_LOWEST_RATIO, Pair};

/// Writes the histograms of the ratios of geodesics to lines into a folder, as SVG and PNG, and returns their paths.
///
/// # Errors
/// An I/O error.
pub fn write_geodesic_ratio(outcomes: &[Outcome], folder: &Path) -> io::Result<Vec<PathBuf>> {
    let turns = [0.0, 60.0, 90.0, f64::INFINITY];
    let panels = outcomes.iter().filter(|outcome| outcome.condition.is_shown()).map(|outcome| {
        let within = |range: &[f64]| {
            let pairs = outcome.pairs.iter();
            let within = |turn_rad: f64| (range[0]..range[1]).contains(&turn_rad.to_degrees());
            pairs.filter(|pair| within(pair.turn_rad)).map(Pair::ratio).collect()
        };
        Panel {
            title: format!("{}: {} pairs", outcome.condition.name, outcome.pairs.len()),
            values: turns.windows(2).map(within).collect(),
            mark: Some((PAPER_LOWEST_RATIO, "lowest of the paper".to_owned())),
        }
    });
    let picture = Histograms {
        title: "Geodesic against line, by the largest turn of a joint",
        axis: "r = L(geodesic) / L(line)",
        range: [0.7, 1.0],
        bin: 0.01,
        kinds: &[("local", "below 60°"), ("egocentric", "60° to 90°"), ("world", "from 90°")],
        panels: panels.collect(),
    };
    write_all(&[("geodesic-ratio".to_owned(), picture.draw())], folder)
}

/// Writes pictures of both embedded walks, and of the histograms of first components' shares, into a folder, as SVG
/// and PNG, and returns their paths. `walkers` are the names of both walks.
///
/// # Errors
/// An I/O error.
pub fn write_mds(
    study: &components::Study,
    walkers: [&str; 2],
    folder: &Path,
) -> io::Result<Vec<PathBuf>> {
    let mut pictures = vec![("mds-walks".to_owned(), walks(study, walkers))];
    let title = "Share of the first component: multidimensional scaling";
    pictures.push(("mds-shares".to_owned(), shares(study, title, |one| one.mds)));
    let title = "Share of the first component: Isomap";
    pictures.push(("isomap-shares".to_owned(), shares(study, title, |one| one.isomap)));
    write_all(&pictures, folder)
}

/// Measures that the paper compares.
const SHOWN: [(Metric, &str); 2] =
    [(Metric::Angles, "joint angles"), (Metric::Line, "geodesic line")];

fn walks(study: &components::Study, walkers: [&str; 2]) -> Markup {
    let plane = |(metric, name): (Metric, &str)| {
        let of = study
            .walks
            .iter()
            .find(|(measure, _)| measure.metric == metric && measure.weighting == Weighting::Alike);
        let (_, embedding) = of.expect("all measures are there");
        let places: Vec<[f64; 2]> =
            embedding.places.iter().map(|place| [place[0], place[1]]).collect();
        let (first, second) = places.split_at(study.first_frames);
        let shares: Vec<String> = (embedding.spectrum.shares.iter().take(2))
            .map(|share| format!("{:.0} %", 100.0 * share))
            .collect();
        Plane {
            title: format!("{name}, in {}", metric.unit()),
            subtitle: format!("components: {}", shares.join(", ")),
            ways: vec![first.to_vec(), second.to_vec()],
        }
    };
    let things = [("local", walkers[0]), ("world", walkers[1])];
    planes("Two recordings in one embedding: the first two components", &things, &SHOWN.map(plane))
}

fn shares(study: &components::Study, title: &str, of: Figure) -> Markup {
    let is_there = |part: &RecordingGroup| study.recordings.iter().any(|one| one.part() == *part);
    let parts: Vec<RecordingGroup> = RecordingGroup::ALL.into_iter().filter(is_there).collect();
    let panel = |(metric, name): (Metric, &str)| {
        let values = parts.iter().map(|part| {
            let own = study.recordings.iter().filter(|one| one.part() == *part);
            components::Study::figures(own, metric, Weighting::Alike, of)
                .into_iter()
                .map(|x| 100.0 * x)
                .collect()
        });
        let mode = components::mode_of_paper(metric).map(|mode| 100.0 * mode);
        Panel {
            title: name.to_owned(),
            values: values.collect(),
            mark: mode.map(|mode| (mode, format!("mode of the paper: {mode:.0} %"))),
        }
    };
    let kinds: Vec<_> = parts.iter().map(|part| (class(*part), part.name())).collect();
    Histograms {
        title,
        axis: "share of the first component (%)",
        range: [0.0, 100.0],
        bin: 5.0,
        kinds: &kinds,
        panels: SHOWN.map(panel).into(),
    }
    .draw()
}

/// Returns the colour class of a part. It is that of a control method, since no chart shows both.
const fn class(part: RecordingGroup) -> &'static str {
    match part {
        RecordingGroup::Cmu31 => "local",
        RecordingGroup::CmuOthers => "egocentric",
        RecordingGroup::Bandai => "world",
        RecordingGroup::BuiltIn => "accumulated",
    }
}
