//! Formats the study as tables and as JSON.

use std::fmt::Write as _;

use serde_json::{Value, json};
use sinew_pose_metrics::spatial::{Measure, Metric, Weighting};

use super::super::classes::TwoClasses;
use super::super::cost::Cost;
use super::super::summary::Summary;
use super::super::tables::{Difference, about, table};
use super::{LeaveOut, Outcome, Plan, Rates, Study, Tally};
use crate::recordings::Class;

/// Reason why writing cannot fail.
const WRITTEN: &str = "a string takes everything";

/// Returns the paper's result for a measure, in percent; for walking and running only.
pub(crate) fn paper(classes: &TwoClasses, measure: Measure) -> Option<f64> {
    let of_measure = match (measure.metric, measure.weighting) {
        (Metric::Angles, Weighting::Alike) => Some(90.0),
        (Metric::Line, Weighting::Alike) => Some(100.0),
        _ => None,
    };
    of_measure.filter(|_| classes.classes == [Class::Walk, Class::Run])
}
impl Outcome {
    /// Summarizes a rate over all draws.
    pub(crate) fn over_draws(&self, rate: impl Fn(&Rates) -> f64) -> Option<Summary> {
        Summary::of(&self.draws.iter().map(rate).collect::<Vec<_>>())
    }

    /// Returns the share of correctly classified poses for each group of a class.
    pub(crate) fn of_groups<'a>(
        &self,
        classes: &'a TwoClasses,
        class: usize,
    ) -> Vec<(&'a str, Option<f64>)> {
        let rate = |group: &'a str| {
            let sequences = classes.sequences.iter().zip(&self.sequences);
            let own = sequences.filter(|(own, _)| own.class == class && own.group == group);
            (group, own.map(|(_, tally)| *tally).sum::<Tally>().rate())
        };
        classes.groups(class).into_iter().map(rate).collect()
    }
}

/// Formats the tables: rates, differences, rates by group.
pub fn tables(plan: &Plan<'_>, study: &Study, costs: &[Cost]) -> String {
    let mut text = about(plan.classes, plan.rig, &plan.measures);
    let word = plan.classes.group_word();
    writeln!(
        text,
        "{} draws of {each} + {each} sequences, seed {}; percent told right: means and standard deviations over the draws",
        plan.draws,
        plan.seed,
        each = plan.each,
    )
    .expect(WRITTEN);
    for leave in LeaveOut::ALL {
        let other = if leave == LeaveOut::Sequence { "sequence" } else { word };
        writeln!(text, "\nby the nearest pose of another {other}").expect(WRITTEN);
        writeln!(text, "{}", rates(plan, study, leave, costs)).expect(WRITTEN);
    }
    if let Some(base) = plan.measures.first() {
        writeln!(
            text,
            "\nagainst {base}: poses told right, by draw, and by sequence with the sign test's p"
        )
        .expect(WRITTEN);
        writeln!(text, "{}", differences(plan, study, *base)).expect(WRITTEN);
    }
    writeln!(text, "\nby the nearest pose of another {word}: poses told right, by {word}")
        .expect(WRITTEN);
    writeln!(text, "{}", groups(plan, study)).expect(WRITTEN);
    text
}

fn rates(plan: &Plan<'_>, study: &Study, leave: LeaveOut, costs: &[Cost]) -> comfy_table::Table {
    let [first, second] = plan.classes.classes.map(Class::name);
    let mut header = vec!["measure", "poses", first, second, "sequences"];
    if leave == LeaveOut::Sequence {
        header.push("paper");
        if !costs.is_empty() {
            header.extend(["ns a distance", "ns a pose"]);
        }
    }
    let row = |(index, measure): (usize, &Measure)| {
        let outcome = study.of(*measure, leave);
        let shown = |rate: &dyn Fn(&Rates) -> f64| {
            let summary = outcome.and_then(|outcome| outcome.over_draws(rate));
            summary.map_or_else(String::new, |summary| summary.percent())
        };
        let mut row = vec![
            measure.to_string(),
            shown(&|rates| rates.poses),
            shown(&|rates| rates.of_class[0]),
            shown(&|rates| rates.of_class[1]),
            shown(&|rates| rates.sequences),
        ];
        if leave == LeaveOut::Sequence {
            row.push(
                paper(plan.classes, *measure)
                    .map_or_else(String::new, |percent| format!("{percent:.0}")),
            );
            if let Some(cost) = costs.get(index) {
                row.push(format!("{:.0}", cost.distance_ns));
                row.push(format!("{:.0}", cost.pose_ns));
            }
        }
        row
    };
    let mut rows = vec![one_class(plan, study)];
    rows[0].resize(header.len(), String::new());
    rows.extend(plan.measures.iter().enumerate().map(row));
    table(&header, rows)
}

/// Formats the result of assigning all poses to the more frequent class.
fn one_class(plan: &Plan<'_>, study: &Study) -> Vec<String> {
    let larger: Vec<[f64; 3]> = study
        .draws
        .iter()
        .map(|draw| {
            let of_class = |class: usize| {
                let own = draw.iter().map(|own| &plan.classes.sequences[*own]);
                own.filter(|own| own.class == class).map(|own| own.frames.len()).sum::<usize>()
            };
            let counts = [of_class(0), of_class(1)];
            let is_first = counts[0] >= counts[1];
            let share = counts[0].max(counts[1]) as f64 / (counts[0] + counts[1]) as f64;
            [share, f64::from(u8::from(is_first)), f64::from(u8::from(!is_first))]
        })
        .collect();
    let shown = |column: usize| {
        let values: Vec<f64> = larger.iter().map(|row| row[column]).collect();
        Summary::of(&values).map_or_else(String::new, |summary| summary.percent())
    };
    vec!["all alike".to_owned(), shown(0), shown(1), shown(2), "50.0 ± 0.0".to_owned()]
}

fn differences(plan: &Plan<'_>, study: &Study, base: Measure) -> comfy_table::Table {
    let word = plan.classes.group_word();
    let header =
        ["measure", "not of", "by draw", "better : worse", "by sequence", "better : worse", "p"];
    let mut rows = Vec::new();
    for leave in LeaveOut::ALL {
        let other = if leave == LeaveOut::Sequence { "the sequence" } else { word };
        for measure in plan.measures.iter().filter(|measure| **measure != base) {
            let (Some(own), Some(first)) = (study.of(*measure, leave), study.of(base, leave))
            else {
                continue;
            };
            let draws = own.draws.iter().zip(&first.draws).map(|(a, b)| (a.poses, b.poses));
            let sequences = own.sequences.iter().zip(&first.sequences);
            let drawn = sequences.filter_map(|(a, b)| Some((a.rate()?, b.rate()?)));
            let (by_draw, by_sequence) = (Difference::of(draws), Difference::of(drawn));
            rows.push(vec![
                measure.to_string(),
                other.to_owned(),
                by_draw.mean(),
                by_draw.how_often(),
                by_sequence.mean(),
                format!("{} of {}", by_sequence.how_often(), by_sequence.count),
                by_sequence.p(),
            ]);
        }
    }
    table(&header, rows)
}

fn groups(plan: &Plan<'_>, study: &Study) -> comfy_table::Table {
    let names: Vec<String> = plan.measures.iter().map(ToString::to_string).collect();
    let mut header = vec!["class", plan.classes.group_word(), "sequences"];
    header.extend(names.iter().map(String::as_str));
    let mut rows = Vec::new();
    for (index, class) in plan.classes.classes.into_iter().enumerate() {
        let of: Vec<_> = plan
            .measures
            .iter()
            .filter_map(|measure| study.of(*measure, LeaveOut::Group))
            .map(|outcome| outcome.of_groups(plan.classes, index))
            .collect();
        for (place, group) in plan.classes.groups(index).into_iter().enumerate() {
            let members = plan.classes.members(index).into_iter();
            let own = members.filter(|own| plan.classes.sequences[*own].group == group).count();
            let mut row = vec![class.name().to_owned(), group.to_owned(), own.to_string()];
            row.extend(of.iter().map(|rates| {
                rates[place].1.map_or_else(String::new, |rate| format!("{:.1}", 100.0 * rate))
            }));
            rows.push(row);
        }
    }
    table(&header, rows)
}

/// Returns everything as JSON: settings, draws, rates of every draw and every sequence, and costs if there are any.
pub fn json(plan: &Plan<'_>, study: &Study, costs: &[Cost]) -> Value {
    let outcomes: Vec<Value> = study
        .outcomes
        .iter()
        .map(|outcome| {
            json!({
                "measure": outcome.measure.to_string(),
                "leave": outcome.leave,
                "poses": outcome.over_draws(|rates| rates.poses),
                "sequences": outcome.over_draws(|rates| rates.sequences),
                "draws": outcome.draws,
                "by_sequence": outcome.sequences,
            })
        })
        .collect();
    let sequences: Vec<Value> = plan
        .classes
        .sequences
        .iter()
        .map(|own| {
            let class = plan.classes.classes[own.class];
            json!({ "name": own.name, "class": class, "group": own.group, "poses": own.frames.len() })
        })
        .collect();
    json!({
        "schema": "sinew-study-classify/1",
        "data": plan.classes.data_set,
        "root": plan.rig.joint(0),
        "line_steps": plan.measures.first().map(|measure| measure.steps),
        "seed": plan.seed,
        "each": plan.each,
        "sequences": sequences,
        "draws": study.draws,
        "outcomes": outcomes,
        "costs": super::super::cost::json(&plan.measures, costs),
    })
}
