//! Formats the study as a table and as JSON.

use std::fmt::Write as _;

use comfy_table::Table;
use serde_json::{Value, json};

use super::{Outcome, PAPER_LOWEST_RATIO, Pair, Plan};
use crate::spatial::sample::Sample;
use crate::tables::{aligned, table};

/// Reason why writing cannot fail.
const WRITTEN: &str = "a string takes everything";

/// Formats three tables: r under every condition; and, for the first condition, r by the largest turn of a joint and r
/// by the length of the line.
pub fn tables(plan: &Plan<'_>, outcomes: &[Outcome]) -> String {
    let mut text = String::new();
    let root = plan.root.unwrap_or(&plan.recordings.skeleton.joints[0].name);
    writeln!(
        text,
        "r = L(geodesic) / L(line) of {} pairs of poses each, seed {}, {} joints seen from {root}, N = {}",
        plan.pairs,
        plan.seed,
        plan.recordings.skeleton.joints.len(),
        plan.steps,
    )
    .expect(WRITTEN);
    writeln!(text, "{}", conditions(outcomes)).expect(WRITTEN);
    if let Some(Outcome { condition, pairs }) = outcomes.first() {
        let name = &condition.name;
        writeln!(text, "\n{name}: pairs by the largest turn of a joint between them")
            .expect(WRITTEN);
        let turn_deg = |pair: &Pair| pair.turn_rad.to_degrees();
        writeln!(text, "{}", groups(pairs, "turn deg", &[45.0, 60.0, 75.0, 90.0], turn_deg))
            .expect(WRITTEN);
        writeln!(text, "\n{name}: pairs by the length of the line").expect(WRITTEN);
        writeln!(text, "{}", groups(pairs, "line m", &[0.5, 1.0, 1.5, 2.0], |pair| pair.line_m))
            .expect(WRITTEN);
    }
    text
}

fn conditions(outcomes: &[Outcome]) -> Table {
    let mut table = table([
        "pairs",
        "lowest r",
        "5 %",
        "25 %",
        "median",
        "mean",
        "highest",
        "straight / line",
        "line m",
        "iterations",
        "converged",
    ]);
    let paper = ["the paper: walking".to_owned(), format!("{PAPER_LOWEST_RATIO:.2}")];
    table.add_row(paper.into_iter().chain(std::iter::repeat_n(String::new(), 9)));
    for Outcome { condition, pairs } in outcomes {
        let ratios = ratios(pairs);
        let of = |what: &dyn Fn(&Pair) -> f64| Sample::new(pairs.iter().map(what));
        let quantiles = [0.0, 0.05, 0.25, 0.5].map(|share| ratios.quantile(share));
        let mut row = vec![condition.name.clone()];
        row.extend(quantiles.map(|value| shown(value, 3)));
        row.push(shown(ratios.mean(), 3));
        row.push(shown(ratios.quantile(1.0), 3));
        row.push(shown(of(&|pair| pair.positions_m / pair.line_m).mean(), 3));
        row.push(shown(of(&|pair| pair.line_m).mean(), 2));
        row.push(shown(of(&|pair| pair.iterations as f64).quantile(0.5), 0));
        row.push(shown(of(&|pair| f64::from(u8::from(pair.converged)) * 100.0).mean(), 0) + " %");
        table.add_row(row);
    }
    aligned(table)
}

/// Formats pairs in groups of the quantity by which they are sorted.
fn groups(pairs: &[Pair], name: &str, steps: &[f64], of: impl Fn(&Pair) -> f64) -> Table {
    let mut table = table([name, "pairs", "lowest r", "median", "mean"]);
    let ends = |index: usize| {
        let low = index.checked_sub(1).map(|below| steps[below]);
        (low.unwrap_or(0.0), steps.get(index).copied().unwrap_or(f64::INFINITY))
    };
    for (low, high) in (0..=steps.len()).map(ends) {
        let within = |pair: &&Pair| (low..high).contains(&of(pair));
        let ratios = Sample::new(pairs.iter().filter(within).map(Pair::ratio));
        let range =
            if high.is_finite() { format!("{low} to {high}") } else { format!("from {low}") };
        table.add_row([
            range,
            ratios.sorted().len().to_string(),
            shown(ratios.quantile(0.0), 3),
            shown(ratios.quantile(0.5), 3),
            shown(ratios.mean(), 3),
        ]);
    }
    aligned(table)
}

fn ratios(pairs: &[Pair]) -> Sample {
    Sample::new(pairs.iter().map(Pair::ratio))
}

fn shown(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(String::new, |value| format!("{value:.decimals$}"))
}

/// Returns everything as JSON: every pair of every condition.
pub fn json(plan: &Plan<'_>, outcomes: &[Outcome]) -> Value {
    let pair = |pair: &Pair| {
        json!({
            "ends": pair.ends,
            "turn_rad": pair.turn_rad,
            "positions_m": pair.positions_m,
            "line_m": pair.line_m,
            "geodesic_m": pair.geodesic_m,
            "ratio": pair.ratio(),
            "iterations": pair.iterations,
            "converged": pair.converged,
        })
    };
    let outcome = |outcome: &Outcome| {
        let pairs: Vec<Value> = outcome.pairs.iter().map(pair).collect();
        json!({
            "condition": outcome.condition.name,
            "steps": outcome.condition.steps,
            "pairs": pairs,
        })
    };
    json!({
        "schema": "sinew-study-geodesic-ratio/1",
        "seed": plan.seed,
        "root": plan.root,
        "paper": { "lowest": PAPER_LOWEST_RATIO },
        "conditions": outcomes.iter().map(outcome).collect::<Vec<_>>(),
    })
}
