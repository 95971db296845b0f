//! Writes tables of methods on rigs with random errors.

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};

use crate::metrics::Errors;
use crate::pareto::on_front;
use crate::robustness::{MeanError, Robustness};
use crate::trial::Trial;

/// Returns the table of all rigs with their medians, and for each other method the number of rigs on which the
/// last method is better. If the projection has several weights, a second table compares angle and distance.
pub fn robustness_tables(result: &Robustness) -> String {
    let mut text = format!("{}\n", table(result));
    for line in wins(result) {
        text.extend([line.as_str(), "\n"]);
    }
    if result.variants.len() > result.methods.len() {
        text += "\nmedians over the rigs, and on how many of them an error is below those of all methods without projection\n\n";
        text.extend([front(result).to_string().as_str(), "\n"]);
    }
    text
}

fn cell(means: [f64; 3]) -> String {
    let [angular_deg, linear_cm, weighted_cm] = means;
    format!("{angular_deg:.3} / {linear_cm:.3} / {weighted_cm:.3}")
}

fn means(errors: &Errors) -> [f64; 3] {
    MeanError::ALL.map(|error| error.of(errors))
}

fn table(result: &Robustness) -> Table {
    let methods = &result.methods;
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    let heading = ["rig".to_owned()].into_iter();
    table.set_header(heading.chain(methods.iter().map(ToString::to_string)));
    for (seed, trials) in (1..).zip(&result.trials) {
        let cells = trials.iter().take(methods.len()).map(|trial| match trial {
            Ok(errors) => cell(means(errors)),
            Err(_) => "lost".to_owned(),
        });
        let seed: u64 = seed;
        table.add_row([seed.to_string()].into_iter().chain(cells));
    }
    let medians = (0..methods.len())
        .map(|method| cell(MeanError::ALL.map(|error| result.median(method, error))));
    table.add_row(["median".to_owned()].into_iter().chain(medians));
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Returns the table that compares the errors of angle and distance.
fn front(result: &Robustness) -> Table {
    use MeanError::{Angular, Linear};
    let Robustness { variants, trials, .. } = result;
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header(["", "deg", "cm", "Pareto-optimal", "angle below", "distance below", "both"]);
    let others: Vec<usize> =
        (0..variants.len()).filter(|variant| !variants[*variant].projects()).collect();
    let is_below = |trials: &Vec<Trial>, variant: usize, error: MeanError| {
        let own = error.of_trial(&trials[variant]);
        others.iter().all(|other| own < error.of_trial(&trials[*other]))
    };
    let medians: Vec<[f64; 2]> = (0..variants.len())
        .map(|variant| [Angular, Linear].map(|error| result.median(variant, error)))
        .collect();
    for (index, (variant, on_front)) in variants.iter().zip(on_front(&medians)).enumerate() {
        let count = |errors: &[MeanError]| {
            if !variant.projects() || others.is_empty() {
                return String::new();
            }
            let all =
                |trials: &&Vec<Trial>| errors.iter().all(|error| is_below(trials, index, *error));
            format!("{} of {}", trials.iter().filter(all).count(), trials.len())
        };
        let [angular_deg, linear_cm] = medians[index];
        table.add_row([
            variant.name.clone(),
            format!("{angular_deg:.3}"),
            format!("{linear_cm:.3}"),
            if on_front { "yes" } else { "" }.to_owned(),
            count(&[Angular]),
            count(&[Linear]),
            count(&[Angular, Linear]),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// Returns a line for each other method: the number of rigs on which the last method is better.
fn wins(result: &Robustness) -> Vec<String> {
    let Some((last, others)) = result.methods.split_last() else { return Vec::new() };
    let better = |trials: &[Trial], other: usize| match (&trials[others.len()], &trials[other]) {
        (Ok(ours), Ok(theirs)) => {
            let [ours, theirs] = [means(ours), means(theirs)];
            ours[0] < theirs[0] && ours[1] < theirs[1]
        }
        (Ok(_), Err(_)) => true,
        (Err(_), _) => false,
    };
    others
        .iter()
        .enumerate()
        .map(|(index, other)| {
            let count = result.trials.iter().filter(|trials| better(trials, index)).count();
            format!(
                "{last} is below {other} in mean angular and linear error on {count} of {} rigs",
                result.trials.len()
            )
        })
        .collect()
}
