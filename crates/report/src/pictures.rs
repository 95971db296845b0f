//! Writes the report to files: the page, and every picture.

use std::path::Path;
use std::{fs, io};

use maud::{Markup, html};
use sinew_evaluation::MethodName;

use super::chart::{self, Quantity, Statistic};
use super::file::alone;
use super::report::Report;
use super::results::{courses, joints, spreads};
use super::text::Words;
use super::{animation, page, pareto, png, tables};

impl Report<'_> {
    /// Returns the page as one HTML text that includes all pictures, scripts and styles.
    pub fn html(&self) -> String {
        page::page(self).into_string()
    }

    /// Writes `index.html`, every picture as SVG and PNG, and the animated `playback.svg` to a folder.
    ///
    /// # Errors
    /// The error of the operating system.
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

    /// Returns the pictures with their file names. If the page offers a selection, the picture is its initial
    /// option.
    pub(super) fn pictures(&self) -> Vec<(String, Markup)> {
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

/// Returns charts side by side under the legend of their methods, as one picture.
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

/// Returns the height of a chart's `viewBox`.
fn height(svg: &str) -> f64 {
    let view = svg.split_once("viewBox=\"").and_then(|(_, rest)| rest.split_once('"'));
    let height = view.and_then(|(view, _)| view.rsplit(' ').next()?.parse().ok());
    height.expect("every chart has a box of view")
}
