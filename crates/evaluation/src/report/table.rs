//! Writes tables 1 to 4 of the paper, with the paper's numbers beside ours.

use std::fmt::Write as _;

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};

use super::super::paper::{self, Kind};
use super::super::{Errors, Evaluation, FigureResult, MethodName, MethodResult};
use super::likeness::likeness;

/// Returns all tables, each with its heading and with the importance-weighted error as the last column. Every
/// figure's numbers divided by Local's (the paper's tables 1 and 2) are first, then the numbers themselves (3 and
/// 4).
pub fn tables(evaluation: &Evaluation) -> String {
    let mut out = String::new();
    let write = |out: &mut String, text: std::fmt::Arguments<'_>| {
        out.write_fmt(text).expect("a string takes everything");
    };
    let clips = evaluation.clips.len();
    let first = evaluation.figures.first().and_then(|figure| figure.methods.first());
    let (n_all, n_leaf) = first.map_or((0, 0), |result| (result.total.all.n, result.total.leaf.n));
    write(
        &mut out,
        format_args!(
            "{clips} {}{}, {} frames; n_all = {n_all}, n_leaf = {n_leaf}\nplant: {}\njoints of the plant hold to {:.1} mm\n",
            if evaluation.rig.is_some() { "motion" } else { "clip" },
            if clips == 1 { "" } else { "s" },
            evaluation.frames(),
            evaluation.setup.plant.description(),
            widest_gap_m(evaluation) * 1000.0,
        ),
    );
    if let Some(base) = evaluation.base() {
        write(&mut out, format_args!("base of the rig: {base}\n"));
    }
    if let Some(line) = limited(evaluation) {
        write(&mut out, format_args!("{line}\n"));
    }
    let differences = evaluation.setup.differences();
    if !differences.is_empty() {
        write(&mut out, format_args!("setup: {}\n", differences.join(", ")));
    }
    if evaluation.figures.iter().any(|figure| published(evaluation, figure).is_some()) {
        write(&mut out, format_args!("in brackets: the paper's numbers\n"));
    }
    for kind in [Kind::Normalised, Kind::Numerical] {
        for figure in &evaluation.figures {
            let Some(table) = table(evaluation, figure, kind) else {
                continue;
            };
            write(&mut out, format_args!("\n{}\n{table}\n", heading(evaluation, figure, kind)));
        }
    }
    if !evaluation.figures.iter().all(|figure| figure.method(MethodName::Local).is_some()) {
        write(
            &mut out,
            format_args!("\nNothing is divided by Local: it is not among the methods.\n"),
        );
    }
    out.extend(likeness(evaluation));
    out
}

/// Returns a line with the share of desired torques that a rig's drives could not give, for each method; `None` if
/// there is no such case.
fn limited(evaluation: &Evaluation) -> Option<String> {
    evaluation.rig.as_ref()?;
    let methods = evaluation.figures.iter().flat_map(|figure| &figure.methods);
    let shares: Vec<String> = methods
        .filter(|result| result.total.limited > 0)
        .map(|result| {
            let percent = 100.0 * result.total.limited as f64 / result.total.all.n as f64;
            format!("{} {percent:.2} %", result.method.label())
        })
        .collect();
    (!shares.is_empty())
        .then(|| format!("torques cut by the drives' limits: {}", shares.join(", ")))
}

fn widest_gap_m(evaluation: &Evaluation) -> f64 {
    let results = evaluation.figures.iter().flat_map(|figure| &figure.methods);
    results.map(|result| result.total.widest_gap_m).fold(0.0, f64::max)
}

/// Returns the paper's numbers for a figure, if the evaluation uses the paper's figure and the paper has this
/// scale.
fn published(evaluation: &Evaluation, figure: &FigureResult) -> Option<&'static paper::Figure> {
    match evaluation.rig {
        None => paper::Figure::of_scale(figure.scale),
        Some(_) => None,
    }
}

fn heading(evaluation: &Evaluation, figure: &FigureResult, kind: Kind) -> String {
    let number = published(evaluation, figure)
        .map_or_else(String::new, |figure| format!("Table {}. ", figure.table(kind)));
    let scale = figure.scale;
    let figure = match &evaluation.rig {
        Some(rig) => format!("Rig {rig}"),
        None if (scale - 1.0).abs() < 1e-9 => "Figure of the clip's dimensions".to_owned(),
        None => format!("Figure of {scale} times the clip's dimensions"),
    };
    let what = match kind {
        Kind::Normalised => "errors divided by Local's",
        Kind::Numerical => "errors in deg (angular) and cm (linear, weighted)",
    };
    format!("{number}{figure}: {what}")
}

/// Returns the table of one figure; `None` if it should be normalised, but Local was not evaluated.
fn table(evaluation: &Evaluation, figure: &FigureResult, kind: Kind) -> Option<Table> {
    let local = figure.method(MethodName::Local);
    if kind == Kind::Normalised {
        local?;
    }
    let published = published(evaluation, figure);
    let decimals = kind.decimals(evaluation.rig.is_some());
    let number = |value: f64| format!("{value:.decimals$}");
    let header = [
        "joints",
        "method",
        "mean angular",
        "mean linear",
        "max angular",
        "max linear",
        "mean weighted",
    ];
    // All numbers of a column get the width of the number of the method Local. A number may have one digit fewer.
    let bracket_widths = published
        .and_then(|figure| figure.row(kind, MethodName::Local))
        .map_or([0; 4], |row| row.all.map(|value| number(value).len() + 2));
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN).set_header(header);
    for (joints, group) in [("all", group_all as Group), ("leaf", group_leaf as Group)] {
        for result in &figure.methods {
            let ours = group(&result.total);
            let ours = match (kind, local) {
                (Kind::Normalised, Some(local)) => {
                    let by = group(&local.total);
                    std::array::from_fn(|column| ours[column] / by[column])
                }
                _ => ours,
            };
            let published = published.map(|figure| {
                let row = figure.row(kind, result.method)?;
                Some(if joints == "all" { row.all } else { row.leaf })
            });
            let mut cells = vec![joints.to_owned(), result.method.label().to_owned()];
            for column in 0..4 {
                let ours = number(ours[column]);
                cells.push(match published {
                    Some(Some(row)) => format!("{ours} ({})", number(row[column])),
                    // Spaces replace the paper's missing number, so that our number is aligned with those of the other
                    // rows.
                    Some(None) => format!("{ours} {:1$}", "", bracket_widths[column]),
                    None => ours,
                });
            }
            // The weighted error exists only for whole poses, and not in the paper.
            let weighted = |result: &MethodResult| result.total.weighted.mean_cm();
            cells.push(match (joints, kind, local) {
                ("all", Kind::Normalised, Some(local)) => {
                    number(weighted(result) / weighted(local))
                }
                ("all", ..) => number(weighted(result)),
                _ => String::new(),
            });
            table.add_row(cells);
        }
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    Some(table)
}

type Group = fn(&Errors) -> [f64; 4];

fn group_all(errors: &Errors) -> [f64; 4] {
    errors.all.figures()
}

fn group_leaf(errors: &Errors) -> [f64; 4] {
    errors.leaf.figures()
}
