//! Formats the study as tables and as JSON.

use std::fmt::Write as _;

use comfy_table::Table;
use serde_json::{Value, json};

use super::anatomy::Group;
use super::errors::Means;
use super::method::Method;
use super::run::{Outcome, Plan, Study};
use super::timing::StepTime;
use crate::tables::{aligned, table};

/// Reason why writing cannot fail.
const WRITTEN: &str = "a string takes everything";

/// Mean and standard deviation over seeds.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Spread {
    mean: f64,
    /// `None` for a single sample.
    deviation: Option<f64>,
}

impl Spread {
    fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let deviation = (values.len() > 1).then(|| (squares / (count - 1.0)).sqrt());
        Self { mean, deviation }
    }

    fn shown(self, decimals: usize) -> String {
        match self.deviation {
            Some(deviation) => format!("{:.decimals$} ± {deviation:.decimals$}", self.mean),
            None => format!("{:.decimals$}", self.mean),
        }
    }
}

impl Study {
    /// Returns the outcomes of a method, one for each seed.
    fn of(&self, latent: usize, method: Method) -> impl Iterator<Item = &Outcome> {
        self.outcomes.iter().filter(move |o| o.latent == latent && o.method == method)
    }

    fn spread(&self, latent: usize, method: Method, of: impl Fn(&Outcome) -> f64) -> Spread {
        Spread::of(&self.of(latent, method).map(of).collect::<Vec<_>>())
    }

    fn means(&self, outcome: &Outcome, group: Option<Group>) -> Means {
        outcome.errors.means(&self.groups, group)
    }

    fn position_cm(&self, outcome: &Outcome, group: Option<Group>) -> f64 {
        self.means(outcome, group).position_cm.unwrap_or(0.0)
    }

    /// Returns the mean distance of a group's joints for each method, in centimetres, over the seeds; `None` if no
    /// joint of the group can move.
    pub fn distances_cm(&self, latent: usize, group: Option<Group>) -> Vec<(Method, Option<f64>)> {
        let mean = |method: Method| {
            let distances = self.of(latent, method).map(|o| self.means(o, group).position_cm);
            distances.collect::<Option<Vec<f64>>>().map(|values| Spread::of(&values).mean)
        };
        self.weights.iter().map(|(method, _)| (*method, mean(*method))).collect()
    }
}

/// Formats the tables: errors and losses, differences seed by seed, times.
pub fn tables(plan: &Plan<'_>, study: &Study, times: &[StepTime]) -> String {
    let mut text = about(plan);
    for latent in &plan.latents {
        writeln!(text, "\n{latent} latent units: joint positions (cm), rotations (deg)")
            .expect(WRITTEN);
        writeln!(text, "{}", errors(study, *latent)).expect(WRITTEN);
        writeln!(text, "\n{latent} latent units: mean distance of all joints against another method's (cm), seed by seed").expect(WRITTEN);
        writeln!(text, "{}", differences(study, *latent)).expect(WRITTEN);
    }
    if !times.is_empty() {
        text += "\nmedian processor times of a step on one thread (ms)\n";
        writeln!(text, "{}", time_table(times)).expect(WRITTEN);
    }
    text
}

fn about(plan: &Plan<'_>) -> String {
    let poses = plan.poses;
    let schedule = &plan.schedule;
    let list = |subjects: &std::collections::BTreeSet<String>| {
        subjects.iter().map(String::as_str).collect::<Vec<_>>().join(", ")
    };
    let seeds = match plan.seeds {
        1 => "seed 1".to_owned(),
        last => format!("seeds 1 to {last}; means and standard deviations over the seeds"),
    };
    let mesh = if plan.character.is_some() { "" } else { "; no mesh, so no weights by it" };
    format!(
        "{} joints, {} recordings; train: {} poses of {}; test: {} poses of {}{mesh}\n\
         {} steps of {} poses, {seeds}\n",
        poses.skeleton.joints.len(),
        poses.recordings,
        poses.train.len(),
        list(&poses.train_subjects),
        poses.test.len(),
        list(&poses.test_subjects),
        schedule.steps,
        schedule.batch,
    )
}

fn errors(study: &Study, latent: usize) -> Table {
    let groups = Group::ALL.map(|group| format!("{} cm", group.as_str()));
    let header = ["loss".to_owned(), "all cm".to_owned()].into_iter().chain(groups);
    let more = ["local deg", "global deg", "own loss, train", "own loss, test"].map(str::to_owned);
    let mut table = table(header.chain(more));
    for (method, _) in &study.weights {
        let spread = |of: &dyn Fn(&Outcome) -> f64| study.spread(latent, *method, of);
        let of_group = |group| spread(&|o| study.position_cm(o, group)).shown(2);
        let mut row = vec![method.label().to_owned(), of_group(None)];
        row.extend(Group::ALL.map(|group| of_group(Some(group))));
        row.push(spread(&|o| study.means(o, None).local_deg).shown(2));
        row.push(spread(&|o| study.means(o, None).global_deg).shown(2));
        row.push(spread(&|o| o.train_loss).shown(4));
        row.push(spread(&|o| o.test_loss).shown(4));
        table.add_row(row);
    }
    aligned(table)
}

/// Formats by how much a row's error is smaller than a column's, and for how many seeds.
fn differences(study: &Study, latent: usize) -> Table {
    let against = [Method::Uniform, Method::ForwardKinematics];
    let heading = |method: Method| format!("less {}", method.label());
    let mut table = table(["loss".to_owned()].into_iter().chain(against.map(heading)));
    for (method, _) in &study.weights {
        let cell = |other: Method| {
            if other == *method {
                return String::new();
            }
            let distance_cm = |outcome| study.position_cm(outcome, None);
            let of = |method| study.of(latent, method).map(distance_cm);
            let values: Vec<f64> = of(*method).zip(of(other)).map(|(a, b)| a - b).collect();
            let below = values.iter().filter(|difference| **difference < 0.0).count();
            format!("{}, below on {below} of {}", Spread::of(&values).shown(3), values.len())
        };
        table.add_row([method.label().to_owned()].into_iter().chain(against.map(cell)));
    }
    aligned(table)
}

fn time_table(times: &[StepTime]) -> Table {
    let header = ["latent", "loss", "step", "of uniform", "loss", "gradient", "optimiser"];
    let mut table = table(header.map(str::to_owned));
    for time in times {
        let uniform = times.iter().find(|t| t.latent == time.latent && t.method == Method::Uniform);
        let ratio = uniform.map_or(1.0, |uniform| time.step_ms / uniform.step_ms);
        let form = time.form.map_or_else(String::new, |form| format!(", {}", form.label()));
        let mut row = vec![time.latent.to_string(), format!("{}{form}", time.method.label())];
        row.push(format!("{:.2}", time.step_ms));
        row.push(format!("{ratio:.2}"));
        row.extend([time.loss_ms, time.gradient_ms, time.update_ms].map(|ms| format!("{ms:.2}")));
        table.add_row(row);
    }
    aligned(table)
}

/// Returns everything as JSON: settings, errors of every joint of every network, and times if there are any.
pub fn json(plan: &Plan<'_>, study: &Study, times: &[StepTime]) -> Value {
    let poses = plan.poses;
    let outcomes: Vec<Value> = study
        .outcomes
        .iter()
        .map(|outcome| {
            let groups: serde_json::Map<String, Value> = Group::ALL
                .iter()
                .map(|group| (group.as_str().to_owned(), json!(study.means(outcome, Some(*group)))))
                .collect();
            json!({
                "latent": outcome.latent,
                "loss": outcome.method,
                "seed": outcome.seed,
                "train_loss": outcome.train_loss,
                "test_loss": outcome.test_loss,
                "all": study.means(outcome, None),
                "groups": groups,
                "joints": outcome.errors,
            })
        })
        .collect();
    let weights: serde_json::Map<String, Value> =
        study.weights.iter().map(|(method, w)| (method.as_str().to_owned(), json!(w))).collect();
    json!({
        "schema": "sinew-study-autoencoder/1",
        "schedule": plan.schedule,
        "data": {
            "recordings": poses.recordings,
            "train": { "poses": poses.train.len(), "subjects": poses.train_subjects },
            "test": { "poses": poses.test.len(), "subjects": poses.test_subjects },
        },
        "joints": study.joints,
        "groups": study.groups,
        "weights": weights,
        "outcomes": outcomes,
        "times": times,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_the_samples() {
        let spread = Spread::of(&[1.0, 2.0, 4.0, 5.0]);
        assert_eq!(spread.shown(3), "3.000 ± 1.826");
        assert_eq!(Spread::of(&[2.0]).shown(2), "2.00", "one seed tells nothing of others");
    }
}
