//! Extracts values of an evaluation's result for charts, with every method.

use maud::Markup;
use sinew_evaluation::detail::{Detail, Spread};
use sinew_evaluation::{Evaluation, FigureResult, MethodName};

use super::chart::{self, Quantity};
use super::text::Words;

/// Returns the errors over time of one clip with every method.
pub(super) fn courses(
    figure: &FigureResult,
    clip: usize,
) -> Vec<(MethodName, &sinew_evaluation::detail::ErrorTrace)> {
    figure.methods.iter().map(|result| (result.method, &result.details[clip].trace)).collect()
}

/// Draws the mean errors of every body of a figure.
pub(super) fn joints(evaluation: &Evaluation, figure: &FigureResult, quantity: Quantity) -> Markup {
    let spreads = spreads(figure);
    let row = Words::of(evaluation).either(chart::ROW, chart::room(spreads.len()));
    chart::joints(&evaluation.bodies, &spreads, quantity, row)
}

/// Returns the distributions of the errors over all clips, with every method.
pub(super) fn spreads(figure: &FigureResult) -> Vec<(MethodName, Spread)> {
    let merged = |details: &[Detail]| {
        let mut spread = Spread::default();
        for detail in details {
            spread.merge(&detail.spread);
        }
        spread
    };
    figure.methods.iter().map(|result| (result.method, merged(&result.details))).collect()
}
