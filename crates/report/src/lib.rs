//! An evaluation as one page that needs nothing but a browser, and its pictures as files.
//!
//! - `page` and `tables` write the page of an evaluation; [`chart`] and [`scene`] draw; script and style are in
//!   `assets/`.
//! - [`rig`], [`feasibility`] and [`recording`] are pages of a rig to move, of what a show asks of it, and of how it
//!   was played. `course` packs their traces.
//! - [`weights`], [`moments`] and [`blend`] draw joints' weights, poses in a row, and the map of two clips.
//! - `comparison` is the paper's Figure 4; `words` holds what a page says of the figure and of other rigs.

mod animation;
pub mod blend;
pub mod chart;
mod comparison;
mod course;
pub mod feasibility;
pub mod file;
mod head;
mod labels;
pub mod moments;
mod page;
mod palette;
mod pareto;
mod playback;
mod png;
pub mod recording;
pub mod rig;
pub mod scene;
mod still;
mod sweep;
mod tables;
mod text;
mod view;
pub mod weights;

use std::path::Path;
use std::{fs, io};

use maud::{Markup, html};

pub use comparison::Comparison;
pub use playback::Playback;
pub use sweep::{Grid, Sweep, SweepError};

use chart::{Quantity, Statistic};
use sinew_evaluation::detail::{Detail, Spread};
use sinew_evaluation::optimum::Optimum;
use sinew_evaluation::{Evaluation, FigureResult, MethodName};
use text::Words;

/// What the page shows.
#[derive(Debug, Clone, Copy)]
pub struct Report<'a> {
    /// The command that made it.
    pub command: &'a str,
    /// What was set, such as the plant: name and value.
    pub settings: &'a [(&'a str, String)],
    /// What was done to the clips or the rig before: skipped, filled, found.
    pub notices: &'a [String],
    /// The result.
    pub evaluation: &'a Evaluation,
    /// Time from one frame to the next, in seconds.
    pub dt_s: f64,
    /// The paper's Figure 4; none of other rigs.
    pub comparison: Option<&'a Comparison>,
    /// The nearest poses of every figure, of the same scales; none of other rigs.
    pub optimum: Option<&'a Optimum>,
    /// One clip, or motion of a rig, as it was followed.
    pub playback: Option<&'a Playback>,
    /// A sweep beside the evaluation.
    pub sweep: Option<&'a Sweep>,
}

impl Report<'_> {
    /// The page: one HTML text with everything in it.
    pub fn html(&self) -> String {
        page::page(self).into_string()
    }

    /// Writes `index.html`, every picture as SVG and PNG, and `playback.svg`, which moves, into a folder.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        fs::write(folder.join("index.html"), self.html())?;
        for (name, picture) in self.pictures() {
            let svg = alone(&picture.0);
            fs::write(folder.join(format!("{name}.png")), png::png(&svg))?;
            fs::write(folder.join(format!("{name}.svg")), svg)?;
        }
        let words = Words::of(self.evaluation);
        if let Some(picture) =
            self.playback.and_then(|playback| animation::animation(playback, words))
        {
            fs::write(folder.join("playback.svg"), alone(&picture.0))?;
        }
        Ok(())
    }

    /// The pictures with the names of their files: what the page shows first of its choices.
    fn pictures(&self) -> Vec<(String, Markup)> {
        let words = Words::of(self.evaluation);
        let mut pictures = Vec::new();
        if let Some(comparison) = self.comparison {
            pictures.push(("figure4".to_owned(), comparison.picture()));
        }
        for (place, figure) in self.evaluation.figures.iter().enumerate() {
            let scale = figure.scale;
            let mut add = |name: &str, charts: Vec<Markup>| {
                let methods = figure.methods.iter().map(|result| result.method);
                pictures.push((format!("{name}-x{scale}"), row(methods, &charts)));
            };
            let rows = tables::ratios(figure, words);
            if !rows.is_empty() {
                add("ratios", vec![chart::ratios(&words.subject(scale), &rows)]);
            }
            add("front", pareto::charts(figure, place, self).into());
            let both = Quantity::BOTH;
            let courses = courses(figure, 0);
            add(
                "course",
                both.map(|q| chart::course(&courses, self.dt_s, q, Statistic::Mean)).into(),
            );
            let spreads = spreads(figure);
            add("joints", both.map(|q| joints(self.evaluation, figure, q)).into());
            add("distribution", both.map(|q| chart::distribution(&spreads, q)).into());
        }
        for (index, grid) in
            self.sweep.iter().flat_map(|sweep| sweep.grids()).take(page::GRIDS).enumerate()
        {
            pictures.push((format!("sweep-{}", index + 1), chart::heat_map(&grid)));
        }
        let fronts = self.sweep.iter().flat_map(|sweep| sweep.fronts());
        for (index, front) in fronts.take(page::FRONTS).enumerate() {
            let charts: Vec<Markup> = front.charts.iter().map(chart::ParetoChart::draw).collect();
            pictures.push((format!("sweep-front-{}", index + 1), row(front.methods, &charts)));
        }
        pictures
    }
}

/// Charts side by side under the legend of their methods, as one picture.
fn row(methods: impl IntoIterator<Item = MethodName>, charts: &[Markup]) -> Markup {
    let width = chart::WIDTH * charts.len() as f64;
    let (legend, top) = chart::legend_lines(methods, width);
    let heights: Vec<f64> = charts.iter().map(|chart| height(&chart.0)).collect();
    let height = top + heights.iter().copied().fold(0.0, f64::max);
    html! {
        svg xmlns="http://www.w3.org/2000/svg" class="chart" viewBox={ "0 0 " (chart::px(width)) " " (chart::px(height)) } {
            (legend)
            @for (index, (chart, height)) in charts.iter().zip(heights).enumerate() {
                svg x=(chart::px(chart::WIDTH * index as f64)) y=(chart::px(top)) width=(chart::px(chart::WIDTH)) height=(chart::px(height)) {
                    (chart)
                }
            }
        }
    }
}

/// Height of a chart's box of view.
fn height(svg: &str) -> f64 {
    let view = svg.split_once("viewBox=\"").and_then(|(_, rest)| rest.split_once('"'));
    let height = view.and_then(|(view, _)| view.rsplit(' ').next()?.parse().ok());
    height.expect("every chart has a box of view")
}

/// A picture as a file of its own: with its colours, and charts on a ground. A stage is one.
fn alone(svg: &str) -> String {
    let (head, content) = svg.split_at(svg.find('>').expect("a picture is an element") + 1);
    let style = palette::picture();
    let ground = if svg.contains("class=\"stage\"") {
        ""
    } else {
        "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>"
    };
    let svg = format!("{head}<style>{style}</style>{ground}{content}\n");
    // Names out of files may hold what no XML can, not even escaped.
    let no_xml = |c: char| {
        c.is_control() && !matches!(c, '\t' | '\n' | '\r') || matches!(c, '\u{fffe}' | '\u{ffff}')
    };
    if svg.contains(no_xml) { svg.replace(no_xml, "\u{fffd}") } else { svg }
}

/// Errors over time of one clip with every method.
fn courses(
    figure: &FigureResult,
    clip: usize,
) -> Vec<(MethodName, &sinew_evaluation::detail::Course)> {
    figure.methods.iter().map(|result| (result.method, &result.details[clip].course)).collect()
}

/// The mean errors of every body of a figure.
fn joints(evaluation: &Evaluation, figure: &FigureResult, quantity: Quantity) -> Markup {
    let spreads = spreads(figure);
    let row = Words::of(evaluation).either(chart::ROW, chart::room(spreads.len()));
    chart::joints(&evaluation.bodies, &spreads, quantity, row)
}

/// How the errors of all clips spread, with every method.
fn spreads(figure: &FigureResult) -> Vec<(MethodName, Spread)> {
    let merged = |details: &[Detail]| {
        let mut spread = Spread::default();
        for detail in details {
            spread.merge(&detail.spread);
        }
        spread
    };
    figure.methods.iter().map(|result| (result.method, merged(&result.details))).collect()
}

#[cfg(test)]
mod tests;
