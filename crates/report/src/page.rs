//! Writes the page of an evaluation.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use sinew_evaluation::paper::Kind;
use sinew_evaluation::{Evaluation, FigureResult, MethodName};

use super::chart::{self, Quantity, Statistic, legend};
use super::head::head;
use super::report::Report;
use super::results::{courses, joints, spreads};
use super::tables::{ratios, table};
use super::text::Words;
use super::{Comparison, Playback, Sweep, palette, pareto};

const SCRIPT: &str = concat!(include_str!("assets/page.js"), include_str!("assets/player.js"));

/// Maximum number of clips whose errors over time are on the page. With more, the page would be too large to open.
const CLIPS: usize = 60;

/// Maximum number of a sweep's maps on a page. The next constant is the maximum number of its fronts.
pub(super) const GRIDS: usize = 24;
pub(super) const FRONTS: usize = 12;

pub(super) fn page(report: &Report<'_>) -> Markup {
    let evaluation = report.evaluation;
    let words = Words::of(evaluation);
    html! {
        (DOCTYPE)
        html lang="en" {
            (head(&words.title(&summary(evaluation)), &(palette::page() + words.style())))
            body {
                a class="skip" href="#main" { "Skip to the results" }
                (header(report))
                main id="main" {
                    @if let Some(playback) = report.playback { (motion(playback, evaluation)) }
                    @if let Some(comparison) = report.comparison { (posture(comparison)) }
                    (results(evaluation))
                    (fronts(report))
                    (over_time(report))
                    (by_body(evaluation))
                    (distributions(evaluation))
                    @if let Some(sweep) = report.sweep { (swept(sweep)) }
                    (notes(report))
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

fn summary(evaluation: &Evaluation) -> String {
    let clips = evaluation.clips.len();
    format!(
        "{} {}{}, {} frames",
        thousands(clips),
        Words::of(evaluation).clip(),
        if clips == 1 { "" } else { "s" },
        thousands(evaluation.frames())
    )
}

fn header(report: &Report<'_>) -> Markup {
    let evaluation = report.evaluation;
    let words = Words::of(evaluation);
    let [_, tables] = words.tables();
    let sections = [
        ("playback", "Playback", report.playback.is_some()),
        ("posture", "Figure 4", report.comparison.is_some()),
        ("tables", tables, true),
        ("front", "Front", true),
        ("time", "Over time", true),
        ("bodies", "By body", true),
        ("distributions", "Distributions", true),
        ("sweep", "Sweep", report.sweep.is_some()),
        ("notes", "Notes", true),
    ];
    html! {
        header {
            p class="eyebrow" { "Sinew " (env!("CARGO_PKG_VERSION")) " · evaluation" }
            h1 { (words.heading()) }
            p class="lede" { (words.lede(&summary(evaluation), methods(evaluation).count())) }
            dl class="facts" {
                @for (name, value) in report.settings {
                    div { dt { (name) } dd { (value) } }
                }
                div class="wide" { dt { "Command" } dd { code { (report.command) } } }
                div class="wide" {
                    dt { (words.clip_title()) "s" }
                    dd { (clip_names(evaluation)) }
                }
            }
            nav aria-label="Sections" {
                @for (id, name, there) in sections {
                    @if there { a href={ "#" (id) } { (name) } }
                }
            }
        }
    }
}

fn clip_names(evaluation: &Evaluation) -> String {
    const SHOWN: usize = 24;
    let names: Vec<&str> = evaluation.clips.iter().map(|clip| clip.name.as_str()).collect();
    match names.get(..SHOWN) {
        Some(first) if names.len() > SHOWN => {
            format!("{} and {} more", first.join(", "), names.len() - SHOWN)
        }
        _ => names.join(", "),
    }
}

/// Formats a number with commas between thousands.
fn thousands(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

fn motion(playback: &Playback, evaluation: &Evaluation) -> Markup {
    let words = Words::of(evaluation);
    let mut scales: Vec<f64> = playback.runs.iter().map(|run| run.scale).collect();
    scales.dedup();
    let chosen = scales.last().copied().unwrap_or(1.0);
    let methods: Vec<MethodName> = playback
        .runs
        .iter()
        .filter(|run| run.scale.to_bits() == chosen.to_bits())
        .map(|r| r.method)
        .collect();
    // The last two methods, which differ most, are shown side by side.
    let views = if methods.len() > 1 { &methods[methods.len() - 2..] } else { &methods[..] };
    html! {
        section id="playback" {
            h2 { "Playback" }
            p {
                (words.clip_title()) " " b { (playback.clip) }
                @if playback.cut { ", its first " (format!("{:.0}", playback.desired.len() as f64 * playback.dt_s)) " s" }
                ". White is where the " (words.clip()) " has the bodies, red where the simulated " (words.figure())
                " has them, drawn thinner."
                @if let Some(side) = words.either(None, Some(playback.view.ground.grid_m)) {
                    " A square of the ground is " (length(side)) " wide."
                }
                span class="on-screen" {
                    " Drag to turn; the arrow keys turn the view that has the focus, plus and minus zoom, space plays."
                }
            }
            div class="player" id="player" {
                div class={ "views views-" (views.len()) } {
                    @for (index, view) in views.iter().enumerate() {
                        figure class="view" {
                            div class="view-head" {
                                label {
                                    span class="visually-hidden" { "Method of view " (index + 1) }
                                    select data-method {
                                        @for method in &methods {
                                            option value=(method.as_str()) selected[method == view] { (method.label()) }
                                        }
                                    }
                                }
                            }
                            canvas tabindex="0" role="application"
                                aria-label={ "Desired and actual " (words.figure()) ", view " (index + 1) ". Arrow keys turn, plus and minus zoom." } {}
                            dl class="readout" {
                                @for name in ["All bodies", words.either("Hands, feet, head", "Leaf bodies")] {
                                    div { dt { (name) } dd data-readout { "–" } }
                                }
                            }
                        }
                    }
                }
                div class="transport" {
                    button type="button" id="play" aria-label="Play" { "▶" }
                    input type="range" id="scrubber" min="0" max=(playback.desired.len().saturating_sub(1))
                        value=(playback.view.frame) step="1" aria-label="Time";
                    output id="clock" for="scrubber" { "0.00 s" }
                    div class="options" {
                        label { "Speed "
                            select id="speed" {
                                @for (value, name) in [("0.1", "0.1×"), ("0.25", "0.25×"), ("0.5", "0.5×"), ("1", "1×"), ("2", "2×")] {
                                    option value=(value) selected[value == "1"] { (name) }
                                }
                            }
                        }
                        label hidden[scales.len() < 2] { "Figure "
                            select id="figure" {
                                @for scale in &scales {
                                    option value=(scale) selected[scale.to_bits() == chosen.to_bits()] { "×" (scale) }
                                }
                            }
                        }
                        button type="button" id="nearer" aria-label="Nearer" { "+" }
                        button type="button" id="farther" aria-label="Farther" { "−" }
                        button type="button" id="reset" { "Reset view" }
                    }
                }
            }
            script type="application/json" id="playback-data" { (PreEscaped(playback.json())) }
            div class="still" { (super::still::still(playback, chosen, views)) }
        }
    }
}

/// Formats a length for readers.
fn length(length_m: f64) -> String {
    match length_m {
        1.0.. => format!("{length_m:.0} m"),
        0.01.. => format!("{:.0} cm", 100.0 * length_m),
        _ => format!("{:.1} mm", 1000.0 * length_m),
    }
}

fn posture(comparison: &Comparison) -> Markup {
    html! {
        section id="posture" {
            h2 { "Figure 4: one posture, two methods" }
            p { (comparison.caption()) }
            div class="pair" { @for panel in comparison.panels() { (panel) } }
        }
    }
}

fn results(evaluation: &Evaluation) -> Markup {
    let has_local = |figure: &FigureResult| figure.method(MethodName::Local).is_some();
    let words = Words::of(evaluation);
    let [heading, _] = words.tables();
    let is_compared = words.either(true, false);
    html! {
        section id="tables" {
            h2 { (heading) }
            @if is_compared {
                p {
                    "Ours, and beneath it the paper’s and how far ours is from it. The paper’s motion was never published: \
                     directions and rough sizes of the ratios can agree, not the numbers. "
                    span class="opposite" { "≠" } " marks a ratio on the other side of Local than the paper’s."
                }
            }
            @if !evaluation.figures.iter().all(has_local) {
                p { "Nothing is divided by Local: it is not among the methods." }
            }
            @let ratio_charts: Vec<Markup> = evaluation.figures.iter()
                .map(|figure| (figure.scale, ratios(figure, words)))
                .filter(|(_, rows)| !rows.is_empty())
                .map(|(scale, rows)| chart::ratios(&words.subject(scale), &rows))
                .collect();
            @if !ratio_charts.is_empty() {
                (legend(methods(evaluation).filter(|method| *method != MethodName::Local)))
                div class="pair" { @for chart in ratio_charts { (chart) } }
                p class="small" {
                    @if is_compared { "Filled: ours. Hollow: the paper’s. " }
                    "Left of 1 is better than Local."
                }
            }
            @for kind in [Kind::Normalised, Kind::Numerical] {
                div class="pair tables" {
                    @for figure in &evaluation.figures {
                        @if let Some(table) = table(figure, kind, words) { (table) }
                    }
                }
            }
        }
    }
}

fn methods(evaluation: &Evaluation) -> impl Iterator<Item = MethodName> {
    let first = evaluation.figures.first();
    first.into_iter().flat_map(|figure| figure.methods.iter().map(|result| result.method))
}

/// Returns a selection among the charts of a section. It is hidden if there is only one option, but the page's
/// script reads it in any case.
fn choice(name: &str, label: &str, options: &[(String, String)], chosen: usize) -> Markup {
    html! {
        label hidden[options.len() < 2] { (label) " "
            select data-choice=(name) {
                @for (index, (value, text)) in options.iter().enumerate() {
                    option value=(value) selected[index == chosen] { (text) }
                }
            }
        }
    }
}

fn scales(evaluation: &Evaluation) -> Vec<(String, String)> {
    let name =
        |(index, figure): (usize, &FigureResult)| (index.to_string(), format!("×{}", figure.scale));
    evaluation.figures.iter().enumerate().map(name).collect()
}

/// Returns the index of the figure that is shown first: the one on which the methods differ.
fn last(evaluation: &Evaluation) -> usize {
    evaluation.figures.len().saturating_sub(1)
}

fn over_time(report: &Report<'_>) -> Markup {
    let evaluation = report.evaluation;
    let words = Words::of(evaluation);
    let clips: Vec<(String, String)> = evaluation
        .clips
        .iter()
        .take(CLIPS)
        .enumerate()
        .map(|(index, clip)| (index.to_string(), clip.name.clone()))
        .collect();
    let statistics = [("mean", "mean of all bodies"), ("max", "largest of all bodies")]
        .map(|(value, text)| (value.to_owned(), text.to_owned()));
    html! {
        section id="time" class="choices" {
            h2 { "Errors over time" }
            @if evaluation.clips.len() > CLIPS {
                p { "Of " (evaluation.clips.len()) " " (words.clip()) "s, the first " (CLIPS) " can be chosen here." }
            }
            div class="options" {
                (choice("clip", words.clip_title(), &clips, 0))
                (choice("figure", "Figure", &scales(evaluation), last(evaluation)))
                (choice("statistic", "Show", &statistics, 0))
            }
            (legend(methods(evaluation)))
            @for (scale, figure) in evaluation.figures.iter().enumerate() {
                @for clip in 0..clips.len() {
                    @for statistic in Statistic::BOTH {
                        div class="pair" data-figure=(scale) data-clip=(clip) data-statistic=(statistic.name())
                            hidden[scale != last(evaluation) || clip != 0 || statistic != Statistic::Mean] {
                            @for quantity in Quantity::BOTH {
                                (chart::course(&courses(figure, clip), report.dt_s, quantity, statistic))
                            }
                        }
                    }
                }
            }
        }
    }
}

fn fronts(report: &Report<'_>) -> Markup {
    let evaluation = report.evaluation;
    html! {
        section id="front" class="choices" {
            h2 { "Angle against distance" }
            (pareto::explanation(report.optimum))
            div class="options" { (choice("figure", "Figure", &scales(evaluation), last(evaluation))) }
            @for (place, figure) in evaluation.figures.iter().enumerate() {
                div class="pair" data-figure=(place) hidden[place != last(evaluation)] {
                    @for chart in pareto::charts(figure, place, report) { (chart) }
                }
            }
        }
    }
}

/// Returns a pair of charts for each figure, of which one pair is shown.
fn by_figure(
    evaluation: &Evaluation,
    charts: impl Fn(&FigureResult, Quantity) -> Markup,
) -> Markup {
    html! {
        div class="options" { (choice("figure", "Figure", &scales(evaluation), last(evaluation))) }
        (legend(methods(evaluation)))
        @for (scale, figure) in evaluation.figures.iter().enumerate() {
            div class="pair" data-figure=(scale) hidden[scale != last(evaluation)] {
                @for quantity in Quantity::BOTH { (charts(figure, quantity)) }
            }
        }
    }
}

fn by_body(evaluation: &Evaluation) -> Markup {
    html! {
        section id="bodies" class="choices" {
            h2 { "Errors by body" }
            (by_figure(evaluation, |figure, quantity| joints(evaluation, figure, quantity)))
        }
    }
}

fn distributions(evaluation: &Evaluation) -> Markup {
    html! {
        section id="distributions" class="choices" {
            h2 { "How large the errors are" }
            p { "The share of all errors, of every body in every frame, that is smaller than a size: the farther left a line, the better." }
            (by_figure(evaluation, |figure, quantity| chart::distribution(&spreads(figure), quantity)))
        }
    }
}

fn swept(sweep: &Sweep) -> Markup {
    let grids = sweep.grids();
    let shown = grids.len().min(GRIDS);
    html! {
        section id="sweep" {
            h2 { "Sweep" }
            p {
                (thousands(sweep.cells())) " cells over "
                (sweep.parameters().collect::<Vec<_>>().join(", "))
                ". A map is two parameters that vary alone, the largest first. The darker, the larger; a crossed cell has no result."
                @if shown < grids.len() { " Of " (grids.len()) " maps, the first " (shown) " are shown." }
            }
            div class="pair" { @for grid in &grids[..shown] { (chart::heat_map(grid)) } }
            @let fronts = sweep.fronts();
            @if !fronts.is_empty() {
                p {
                    "Angle against distance, for figures, plants and disturbances that are the same. A ring marks a Pareto-optimal \
                     cell: no other one there has both errors smaller."
                    @if fronts.len() > FRONTS { " Of " (fronts.len()) " such tasks, the first " (FRONTS) " are shown." }
                }
                @for front in fronts.iter().take(FRONTS) {
                    (legend(front.methods.iter().copied()))
                    div class="pair" { @for chart in &front.charts { (chart.draw()) } }
                }
            }
        }
    }
}

fn notes(report: &Report<'_>) -> Markup {
    let words = Words::of(report.evaluation);
    html! {
        section id="notes" {
            h2 { "Notes" }
            dl class="notes" {
                @for method in methods(report.evaluation) {
                    div { dt { (method.label()) } dd { (words.explanation(method)) } }
                }
                div { dt { "Errors" } dd { (words.errors()) } }
                @if words.either(true, false) {
                    div { dt { "The paper" } dd {
                        "D. Notman, P. Carlisle and R. Manning tracked some 80 punches and 40 kicks of one actor, 22,560 frames, with a \
                         figure of 18 bodies in a game engine."
                    } }
                }
            }
            @if !report.notices.is_empty() {
                details {
                    summary { "What was done to the " (words.either("clips", "rig")) " before" }
                    ul class="small" { @for notice in report.notices { li { (notice) } } }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_apart() {
        assert_eq!(
            [0, 999, 1000, 22_736, 1_000_000].map(thousands),
            ["0", "999", "1,000", "22,736", "1,000,000"]
        );
    }
}
