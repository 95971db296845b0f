//! Pictures of the study of clusters: the share of correctly assigned poses, and the cluster of each pose.

use std::io;
use std::path::{Path, PathBuf};

use maud::Markup;
use sinew_pose_metrics::spatial::{Measure, Metric, Weighting};
use sinew_report::chart::{self, Row};
use sinew_report::file::write_all;

use super::classify::interval;
use crate::recordings::Class;
use crate::spatial::cluster::{self, Pairing, Plan, Study, over_pairs};

/// Number of pairs whose clusters are shown: the first ones that were drawn.
const SHOWN: usize = 4;

/// Writes the pictures into a folder, as SVG and PNG, and returns their paths.
///
/// # Errors
/// An I/O error.
pub fn write_cluster(plan: &Plan<'_>, study: &Study, folder: &Path) -> io::Result<Vec<PathBuf>> {
    let pictures = [
        ("cluster-rates".to_owned(), rates(plan, study)),
        ("cluster-poses".to_owned(), poses(plan, study)),
    ];
    write_all(&pictures, folder)
}

/// Draws the share of poses that are in the cluster of their sequence.
fn rates(plan: &Plan<'_>, study: &Study) -> Markup {
    let [first, second] = plan.classes.classes.map(Class::name);
    let word = plan.classes.group_word();
    let kinds = [
        ("local", format!("a {first} and a {second}, cut to one length")),
        ("world", format!("a {first} and a {second} of one {word}, cut")),
        ("accumulated", format!("two of {first}, of two {word}s, cut: no class to tell")),
    ];
    let pairings = [Pairing::Cut, Pairing::OneGroup, Pairing::OneClass];
    let row = |measure: &Measure| {
        let of = |pairing: &Pairing| {
            let rates = &study.of(*measure, *pairing)?.rates;
            over_pairs(rates, |rates| rates.balanced).map(|summary| interval(&summary))
        };
        Row {
            label: measure.to_string(),
            intervals: pairings.iter().map(of).collect(),
            paper: cluster::paper(plan.classes, *measure),
        }
    };
    let rows: Vec<Row> = plan.measures.iter().map(row).collect();
    chart::intervals("Poses in the cluster of their sequence (%)", &kinds, &rows)
}

/// Draws the clusters of some pairs.
fn poses(plan: &Plan<'_>, study: &Study) -> Markup {
    let drawn = study.pairs.iter().filter(|(pairing, _)| *pairing == Pairing::Cut);
    let pairs = drawn.flat_map(|(_, pairs)| pairs).take(SHOWN).enumerate();
    let alike = || plan.measures.iter().filter(|measure| measure.weighting == Weighting::Alike);
    let shown = alike().filter(|measure| measure.metric != Metric::Rotations);
    let pairs: Vec<chart::Pair> = pairs
        .map(|(number, pair)| {
            let strip = |measure: &Measure| {
                let outcome = study.of(*measure, Pairing::Cut)?;
                let of = outcome.clusterings[number].as_ref();
                let behind = of.map_or_else(
                    || "one cluster".to_owned(),
                    |_| format!("{:.0} %", 100.0 * outcome.rates[number].balanced),
                );
                let of = of.map_or_else(|| pair.in_one(), |clustering| clustering.of.clone());
                Some((measure.to_string(), of, behind))
            };
            chart::Pair {
                names: pair.sequences.map(|own| {
                    let own = &plan.classes.sequences[own];
                    let name = Path::new(&own.name).file_stem().unwrap_or_default();
                    format!("{} {}", plan.classes.classes[own.class].name(), name.to_string_lossy())
                }),
                first: pair.lengths()[0],
                strips: shown.clone().filter_map(strip).collect(),
            }
        })
        .collect();
    chart::strips("The first pairs' two clusters, cut to one length", &pairs)
}
