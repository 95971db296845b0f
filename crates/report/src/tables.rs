//! Tables of errors. For the paper's figure they are its tables 1 to 4, with the paper's numbers below ours.

use maud::{Markup, html};
use sinew_evaluation::paper::{self, Kind};
use sinew_evaluation::{ErrorTotals, Errors, FigureResult, MethodName, MethodResult};

use super::chart::Ratio;
use super::text::Words;

const COLUMNS: [(&str, &str); 4] =
    [("angular", "°"), ("linear", "cm"), ("angular", "°"), ("linear", "cm")];

type Group = (&'static str, fn(&Errors) -> &ErrorTotals);

const GROUPS: [Group; 2] =
    [("All joints", |errors| &errors.all), ("Leaf joints", |errors| &errors.leaf)];

/// Returns a table; `None` if it should be normalised, but Local was not evaluated.
pub(super) fn table(figure: &FigureResult, kind: Kind, words: Words<'_>) -> Option<Markup> {
    let local = figure.method(MethodName::Local);
    if kind == Kind::Normalised {
        local?;
    }
    let published = words.published(figure);
    let decimals = kind.decimals(words.either(false, true));
    let caption = caption(&words.subject(figure.scale), published, kind);
    Some(html! {
        figure class="table" {
            figcaption { (caption) }
            div class="scroll" tabindex="0" role="region" aria-label=(caption) {
                table {
                    thead {
                        tr {
                            td {}
                            th scope="colgroup" colspan="2" class="span" { "Mean error" }
                            th scope="colgroup" colspan="2" class="span" { "Maximum error" }
                            th scope="col" class="span" {
                                abbr title="Of whole poses: every joint’s error by how far it moves the skin" { "Weighted" }
                            }
                        }
                        tr {
                            th scope="col" { "Method" }
                            @for (name, unit) in COLUMNS {
                                th scope="col" class="number" {
                                    (name)
                                    @if kind == Kind::Numerical { " " span class="unit" { (unit) } }
                                }
                            }
                            th scope="col" class="number" {
                                "mean"
                                @if kind == Kind::Numerical { " " span class="unit" { "cm" } }
                            }
                        }
                    }
                    @for (group_name, group) in GROUPS {
                        tbody {
                            tr class="group" { th scope="rowgroup" colspan="6" { (group_name) } }
                            @for result in &figure.methods {
                                @let ours = group(&result.total).figures();
                                @let by = local.map(|local| group(&local.total).figures());
                                @let ours = match (kind, by) {
                                    (Kind::Normalised, Some(by)) => std::array::from_fn(|i| ours[i] / by[i]),
                                    _ => ours,
                                };
                                @let theirs = published.and_then(|figure| {
                                    let row = figure.row(kind, result.method)?;
                                    Some(if group_name == GROUPS[0].0 { row.all } else { row.leaf })
                                });
                                tr {
                                    th scope="row" { (result.method.label()) }
                                    @for column in 0..4 {
                                        (cell(ours[column], theirs.map(|row| row[column]), kind, decimals))
                                    }
                                    // The weighted error exists only for whole poses, and not in the paper.
                                    @if group_name == GROUPS[0].0 {
                                        (cell(weighted(result, local, kind), None, kind, decimals))
                                    } @else {
                                        td {}
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    })
}

/// Returns the mean importance-weighted error, or its ratio to Local's.
fn weighted(result: &MethodResult, local: Option<&MethodResult>, kind: Kind) -> f64 {
    let of = |result: &MethodResult| result.total.weighted.mean_cm();
    match (kind, local) {
        (Kind::Normalised, Some(local)) => of(result) / of(local),
        _ => of(result),
    }
}

/// Returns a cell with our number, the paper's number below it, and their difference.
fn cell(ours: f64, paper: Option<f64>, kind: Kind, decimals: usize) -> Markup {
    let number = |value: f64| format!("{value:.decimals$}");
    html! {
        td class="number" {
            span class="ours" { (number(ours)) }
            @if let Some(paper) = paper {
                span class="theirs" {
                    (number(paper))
                    @let difference = difference_percent(ours, paper);
                    @if let Some(difference) = difference {
                        " " span class="difference" {
                            (difference)
                            @if kind == Kind::Normalised && opposite(ours, paper) {
                                " " abbr class="opposite" title="On the other side of Local than the paper’s" { "≠" }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Returns the difference in percent; `None` if both are equal by definition.
fn difference_percent(ours: f64, paper: f64) -> Option<String> {
    let percent = (ours / paper - 1.0) * 100.0;
    if !percent.is_finite() || ours.to_bits() == paper.to_bits() {
        return None;
    }
    let sign = if percent < 0.0 { '−' } else { '+' };
    let decimals = usize::from(percent.abs() < 1.0);
    if percent.abs() < 0.05 {
        return Some("0 %".into());
    }
    Some(format!("{sign}{:.decimals$} %", percent.abs()))
}

/// Returns whether one ratio is better than Local and the other worse, both by more than the printed precision.
fn opposite(ours: f64, paper: f64) -> bool {
    const PRINTED: f64 = 5e-4;
    (ours - 1.0) * (paper - 1.0) < 0.0
        && (ours - 1.0).abs() > PRINTED
        && (paper - 1.0).abs() > PRINTED
}

fn caption(subject: &str, published: Option<&paper::Figure>, kind: Kind) -> Markup {
    html! {
        @if let Some(figure) = published { b { "Table " (figure.table(kind)) "." } " " }
        (subject) ": "
        @match kind {
            Kind::Normalised => "errors divided by Local’s",
            Kind::Numerical => "errors as they are",
        }
    }
}

/// Returns the means of tables 1 and 2 for a chart; empty if Local was not evaluated.
pub(super) fn ratios(figure: &FigureResult, words: Words<'_>) -> Vec<Ratio> {
    let Some(local) = figure.method(MethodName::Local) else {
        return Vec::new();
    };
    let published = words.published(figure);
    let mut rows = Vec::new();
    for (column, names) in
        [["angular, all", "angular, leaf"], ["linear, all", "linear, leaf"]].into_iter().enumerate()
    {
        for ((group, what), (_, totals)) in names.into_iter().enumerate().zip(GROUPS) {
            for result in &figure.methods {
                if result.method == MethodName::Local {
                    continue;
                }
                let paper = published.and_then(|figure| {
                    let row = figure.row(Kind::Normalised, result.method)?;
                    Some([row.all, row.leaf][group][column])
                });
                let ours = totals(&result.total).figures()[column]
                    / totals(&local.total).figures()[column];
                rows.push(Ratio { method: result.method, what, ours, paper });
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_on_the_other_side_of_local_is_marked() {
        assert!(opposite(0.98, 1.049) && opposite(1.6, 0.932));
        assert!(!opposite(0.98, 0.872) && !opposite(1.0002, 0.999) && !opposite(1.0, 1.0));
    }

    #[test]
    fn differences_are_relative_to_the_papers() {
        assert_eq!(difference_percent(1.1, 1.0).unwrap(), "+10 %");
        assert_eq!(difference_percent(0.5, 1.0).unwrap(), "−50 %");
        assert_eq!(difference_percent(0.998, 1.002).unwrap(), "−0.4 %");
        assert_eq!(difference_percent(1.0, 1.0), None);
    }
}
