//! Formats the study as tables and as JSON.

use std::fmt::Write as _;

use serde_json::{Value, json};
use sinew_pose_metrics::spatial::{Measure, Metric, Weighting};

use super::super::classes::TwoClasses;
use super::super::cost::Cost;
use super::super::summary::Summary;
use super::super::tables::{Difference, about, table};
use super::{Pair, Pairing, Plan, Rates, Study};
use crate::recordings::Class;

/// Reason why writing cannot fail.
const WRITTEN: &str = "a string takes everything";

/// Returns the paper's result for a measure, in percent; for walking and running only.
pub(crate) fn paper(classes: &TwoClasses, measure: Measure) -> Option<f64> {
    let of_measure = match (measure.metric, measure.weighting) {
        (Metric::Angles, Weighting::Alike) => Some(60.0),
        (Metric::Line, Weighting::Alike) => Some(65.0),
        _ => None,
    };
    of_measure.filter(|_| classes.classes == [Class::Walk, Class::Run])
}
/// Summarizes a rate over pairs.
pub(crate) fn over_pairs(rates: &[Rates], rate: impl Fn(&Rates) -> f64) -> Option<Summary> {
    Summary::of(&rates.iter().map(rate).collect::<Vec<_>>())
}

/// Formats the tables: rates, differences.
pub fn tables(plan: &Plan<'_>, study: &Study, costs: &[Cost]) -> String {
    let mut text = about(plan.classes, plan.rig, &plan.measures);
    let [first, second] = plan.classes.classes.map(Class::name);
    let word = plan.classes.group_word();
    writeln!(
        text,
        "{} pairs of each kind, seed {}; percent of poses in the cluster of their sequence: means and standard deviations \
         over all pairs (in brackets, how many have two clusters; the others count as one cluster)\n\
         whole: a {first} and a {second}, all poses; balanced: the mean of both sequences' shares, as in all that follow\n\
         cut: the longer one's middle, as long as the shorter one\n\
         one {word}: {first} and {second} of one {word}, cut; both {first}: two of {first}, of two {word}s, cut\n",
        plan.pairs, plan.seed,
    )
    .expect(WRITTEN);
    writeln!(text, "{}", rates(plan, study, costs)).expect(WRITTEN);
    if let Some(base) = plan.measures.first() {
        writeln!(text, "\nagainst {base}, balanced, by pair, with the sign test's p")
            .expect(WRITTEN);
        writeln!(text, "{}", differences(plan, study, *base)).expect(WRITTEN);
    }
    text
}

fn shown(rates: &[Rates], rate: impl Fn(&Rates) -> f64) -> String {
    over_pairs(rates, rate).map_or_else(String::new, |summary| summary.percent())
}

fn rates(plan: &Plan<'_>, study: &Study, costs: &[Cost]) -> comfy_table::Table {
    let [first, _] = plan.classes.classes.map(Class::name);
    let (one, two) = (format!("one {}", plan.classes.group_word()), format!("both {first}"));
    let mut header =
        vec!["clusters by", "whole, poses", "paper", "whole, balanced", "cut", &one, &two];
    if !costs.is_empty() {
        header.push("ns a distance");
    }
    let row = |name: String, paper: Option<f64>, of: &dyn Fn(Pairing) -> (Vec<Rates>, String)| {
        let (whole, found) = of(Pairing::Whole);
        let mut row = vec![
            name,
            shown(&whole, |rates| rates.poses),
            paper.map_or_else(String::new, |percent| format!("{percent:.0}")),
            format!("{}{found}", shown(&whole, |rates| rates.balanced)),
        ];
        row.extend([Pairing::Cut, Pairing::OneGroup, Pairing::OneClass].map(|pairing| {
            let (rates, found) = of(pairing);
            format!("{}{found}", shown(&rates, |rates| rates.balanced))
        }));
        row.resize(header.len(), String::new());
        row
    };
    let mut rows = vec![
        row("one cluster".to_owned(), None, &|pairing| {
            let pairs = study.pairs.iter().filter(|(own, _)| *own == pairing);
            let pairs = pairs.flat_map(|(_, pairs)| pairs);
            (pairs.map(|pair| super::rates(&pair.in_one(), pair)).collect(), String::new())
        }),
        row("chance".to_owned(), None, &|pairing| {
            let own = study.outcomes.iter().filter(|outcome| outcome.pairing == pairing);
            (own.flat_map(|outcome| outcome.by_chance.clone()).collect(), String::new())
        }),
    ];
    for (index, measure) in plan.measures.iter().enumerate() {
        let mut row = row(measure.to_string(), paper(plan.classes, *measure), &|pairing| {
            study.of(*measure, pairing).map_or_else(Default::default, |outcome| {
                let found = outcome.clusterings.iter().flatten().count();
                (outcome.rates.clone(), format!(" ({found})"))
            })
        });
        if let (Some(cost), Some(last)) = (costs.get(index), row.last_mut()) {
            *last = format!("{:.0}", cost.distance_ns);
        }
        rows.push(row);
    }
    table(&header, rows)
}

fn differences(plan: &Plan<'_>, study: &Study, base: Measure) -> comfy_table::Table {
    let header = ["measure", "whole", "better : worse", "p", "cut", "better : worse", "p"];
    let row = |measure: &Measure| {
        let mut row = vec![measure.to_string()];
        for pairing in [Pairing::Whole, Pairing::Cut] {
            let rates = |measure| study.of(measure, pairing).map_or(&[][..], |o| &o.rates);
            let pairs = rates(*measure).iter().zip(rates(base));
            let difference = Difference::of(pairs.map(|(a, b)| (a.balanced, b.balanced)));
            row.extend([difference.mean(), difference.how_often(), difference.p()]);
        }
        row
    };
    table(&header, plan.measures.iter().filter(|measure| **measure != base).map(row))
}

/// Returns everything as JSON: settings, draws, every pair's clusters, and costs if there are any.
pub fn json(plan: &Plan<'_>, study: &Study, costs: &[Cost]) -> Value {
    let outcomes: Vec<Value> = study
        .outcomes
        .iter()
        .map(|outcome| {
            json!({
                "measure": outcome.measure.to_string(),
                "pairing": outcome.pairing,
                "poses": over_pairs(&outcome.rates, |rates| rates.poses),
                "balanced": over_pairs(&outcome.rates, |rates| rates.balanced),
                "clusterings": outcome.clusterings,
                "rates": outcome.rates,
                "by_chance": outcome.by_chance,
            })
        })
        .collect();
    let pair = |pair: &Pair| {
        let both = pair.sequences.iter().zip(&pair.poses);
        let of = both.map(|(own, poses)| {
            json!({ "name": plan.classes.sequences[*own].name, "poses": [poses.start, poses.end] })
        });
        of.collect::<Vec<_>>()
    };
    let pairs: Vec<Value> = study
        .pairs
        .iter()
        .map(|(pairing, pairs)| {
            json!({ "pairing": pairing, "pairs": pairs.iter().map(pair).collect::<Vec<_>>() })
        })
        .collect();
    json!({
        "schema": "sinew-study-cluster/1",
        "data": plan.classes.data_set,
        "root": plan.rig.joint(0),
        "line_steps": plan.measures.first().map(|measure| measure.steps),
        "seed": plan.seed,
        "pairs": pairs,
        "outcomes": outcomes,
        "costs": super::super::cost::json(&plan.measures, costs),
    })
}
