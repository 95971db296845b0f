//! The committed file: the promises, and the numbers that were last accepted.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use toml_edit::{DocumentMut, InlineTable, Item, Table, value};

use super::figures::{FigureKey, Figures};

/// Path of the file in the workspace.
pub(crate) const FILE: &str = "dev/bench/budget.toml";

/// Relative change from which a number is reported.
const NOTABLE_CHANGE: f64 = 0.02;

/// A bound that is independent of earlier measurements.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Promise {
    /// Key of the figure.
    figure: String,
    /// Bound of the figure; if `times` is given, as a multiple of that figure.
    at_most: f64,
    /// Key of the figure of which the bound is a multiple; `None` if the bound is a number of its own.
    times: Option<String>,
    /// Reason for the bound.
    reason: String,
}

/// A promise with the measured number.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Verdict<'a> {
    pub(crate) promise: &'a Promise,
    pub(crate) place: FigureKey,
    pub(crate) measured: u64,
    /// Bound in the units of `measured`.
    pub(crate) bound: f64,
}

impl Verdict<'_> {
    pub(crate) fn holds(&self) -> bool {
        self.measured as f64 <= self.bound
    }

    /// Formats the bound as in the file.
    pub(crate) fn bound_text(&self) -> String {
        match &self.promise.times {
            None => self.promise.at_most.to_string(),
            Some(times) => format!("{} times {times}", self.promise.at_most),
        }
    }

    pub(crate) fn reason(&self) -> &str {
        &self.promise.reason
    }
}

/// Content of the committed file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Budget {
    promises: Vec<Promise>,
    #[serde(default)]
    measured: BTreeMap<String, BTreeMap<String, BTreeMap<String, u64>>>,
}

impl Budget {
    /// Parses the text of [`FILE`].
    pub(crate) fn parse(text: &str) -> Result<Self> {
        let budget: Self = toml::from_str(text).context(FILE)?;
        for promise in &budget.promises {
            ensure!(
                promise.at_most.is_finite() && promise.at_most > 0.0,
                "{FILE}: at most {} is promised of {}; it must be a positive number",
                promise.at_most,
                promise.figure
            );
            for place in std::iter::once(&promise.figure).chain(&promise.times) {
                ensure!(
                    FigureKey::parse(place).is_some(),
                    "{FILE}: `{place}` is no figure; it must be SECTION.ROW.COLUMN of [measured]"
                );
            }
        }
        Ok(budget)
    }

    /// Returns the number that was last accepted for a key.
    pub(crate) fn accepted(&self, place: &FigureKey) -> Option<u64> {
        self.measured.get(&place.section)?.get(&place.row)?.get(&place.column).copied()
    }

    /// Compares every promise with the measured number.
    ///
    /// # Errors
    /// If a promised figure was not measured: its promise would never be checked.
    pub(crate) fn verdicts<'a>(&'a self, measured: &Figures) -> Result<Vec<Verdict<'a>>> {
        let figure = |name: &str| -> Result<(FigureKey, u64)> {
            let place = FigureKey::parse(name).with_context(|| format!("`{name}` is no figure"))?;
            let number = measured
                .get(&place)
                .with_context(|| format!("{FILE} promises {name}, which was not measured"))?;
            Ok((place, number))
        };
        self.promises
            .iter()
            .map(|promise| {
                let (place, measured) = figure(&promise.figure)?;
                let unit = match &promise.times {
                    None => 1.0,
                    Some(times) => figure(times)?.1 as f64,
                };
                Ok(Verdict { promise, place, measured, bound: promise.at_most * unit })
            })
            .collect()
    }

    /// Returns a line for each number that differs from the accepted one by more than 2 %, is new, or was not
    /// measured again.
    pub(crate) fn changes(&self, measured: &Figures) -> Vec<String> {
        let mut changes = Vec::new();
        for (place, now) in measured.iter() {
            match self.accepted(place) {
                None => changes.push(format!("{place} is {now}, and {FILE} does not have it")),
                Some(before) if now.abs_diff(before) as f64 > before as f64 * NOTABLE_CHANGE => {
                    let by = change(before, now);
                    changes.push(format!("{place} has changed from {before} to {now} ({by})"));
                }
                Some(_) => (),
            }
        }
        for (section, rows) in &self.measured {
            for (row, columns) in rows {
                for column in columns.keys() {
                    let place = FigureKey::new(section, row, column);
                    if measured.get(&place).is_none() {
                        changes.push(format!("{place} is in {FILE}, and was not measured"));
                    }
                }
            }
        }
        changes
    }
}

/// Formats the relative change of a number in per cent.
pub(crate) fn change(before: u64, now: u64) -> String {
    format!("{:+.1} %", (now as f64 / before as f64 - 1.0) * 100.0)
}

/// Returns the text of the file with these figures as accepted. Promises and comments stay.
pub(crate) fn accepting(text: &str, measured: &Figures) -> Result<String> {
    let mut document: DocumentMut = text.parse().context(FILE)?;
    let all = table_in(document.as_table_mut(), "measured")?;
    all.set_implicit(true);
    let sections = measured.names(|place| Some(&place.section));
    all.retain(|section, _| sections.contains(&section));
    for section in sections {
        let rows = table_in(all, section)?;
        let names = measured.names(|place| (place.section == section).then_some(&place.row));
        rows.retain(|row, _| names.contains(&row));
        for name in names {
            let mut columns = InlineTable::new();
            for (place, number) in measured.iter() {
                if place.section == section && place.row == name {
                    let number = i64::try_from(number).context("a figure beyond 2^63")?;
                    columns.insert(&place.column, number.into());
                }
            }
            // In an existing row, the comments above belong to its key and are kept.
            match rows.get_mut(name) {
                Some(row) => *row = value(columns),
                None => _ = rows.insert(name, value(columns)),
            }
        }
    }
    Ok(document.to_string())
}

/// Returns the table with a name, and inserts it if it is missing.
fn table_in<'a>(within: &'a mut Table, name: &str) -> Result<&'a mut Table> {
    within
        .entry(name)
        .or_insert(Item::Table(Table::new()))
        .as_table_mut()
        .with_context(|| format!("{FILE}: `{name}` is no table"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
# What things take.
[[promises]]
figure = \"instructions.tick.18\"
at_most = 2_000
reason = \"promised\"

[[promises]]
figure = \"instructions.tick.32\"
at_most = 1.8
times = \"instructions.tick.18\"
reason = \"linear\"

# As executed.
[measured.instructions]
# Whole.
tick = { 18 = 1_000, 32 = 1_700 }
kernel = { 18 = 100 }
";

    fn figures(numbers: [u64; 3]) -> Figures {
        let [tick, large, kernel] = numbers;
        let mut figures = Figures::default();
        figures.add(FigureKey::new("instructions", "tick", "18"), tick);
        figures.add(FigureKey::new("instructions", "tick", "32"), large);
        figures.add(FigureKey::new("instructions", "kernel", "18"), kernel);
        figures
    }

    fn missed(numbers: [u64; 3]) -> Vec<String> {
        let budget = Budget::parse(TEXT).unwrap();
        let verdicts = budget.verdicts(&figures(numbers)).unwrap();
        let missed = verdicts.iter().filter(|verdict| !verdict.holds());
        missed.map(|verdict| format!("{} {}", verdict.place, verdict.bound_text())).collect()
    }

    #[test]
    fn the_estimate_of_a_tick_is_what_was_measured_and_hardly_more() {
        let text = std::fs::read_to_string(sinew_steps::step::root().join(FILE)).unwrap();
        let budget = Budget::parse(&text).unwrap();
        let [fixed, each] = sinew_firmware::controller::TICK_CYCLES;
        for servos in [6, 20, 40] {
            let place = FigureKey::new("estimated_cycles", "loop_recommended", &servos.to_string());
            let measured = budget.accepted(&place).unwrap() as f64;
            let share = f64::from(fixed + each * servos) / measured;
            assert!((1.0..1.03).contains(&share), "{servos} servos: {share}");
        }
    }

    #[test]
    fn promises_are_bounds_and_multiples_of_what_is_measured() {
        assert_eq!(missed([2_000, 3_600, 1]), [""; 0]);
        assert_eq!(missed([2_001, 3_600, 1]), ["instructions.tick.18 2000"]);
        assert_eq!(
            missed([1_000, 1_801, 1]),
            ["instructions.tick.32 1.8 times instructions.tick.18"]
        );
    }

    #[test]
    fn a_promise_of_what_was_not_measured_is_an_error() {
        let budget = Budget::parse(&TEXT.replace("tick.18\"\nat", "tock.18\"\nat")).unwrap();
        let error = budget.verdicts(&figures([1, 1, 1])).unwrap_err();
        assert_eq!(
            error.to_string(),
            "dev/bench/budget.toml promises instructions.tock.18, which was not measured"
        );
    }

    #[test]
    fn a_change_by_more_than_two_per_cent_is_told() {
        let budget = Budget::parse(TEXT).unwrap();
        assert_eq!(budget.changes(&figures([1_020, 1_700, 98])), [""; 0]);
        assert_eq!(
            budget.changes(&figures([1_021, 1_700, 97])),
            [
                "instructions.tick.18 has changed from 1000 to 1021 (+2.1 %)",
                "instructions.kernel.18 has changed from 100 to 97 (-3.0 %)"
            ]
        );
    }

    #[test]
    fn what_is_only_measured_or_only_accepted_is_told() {
        let budget = Budget::parse(&TEXT.replace("kernel", "other")).unwrap();
        assert_eq!(
            budget.changes(&figures([1_000, 1_700, 100])),
            [
                "instructions.kernel.18 is 100, and dev/bench/budget.toml does not have it",
                "instructions.other.18 is in dev/bench/budget.toml, and was not measured"
            ]
        );
    }

    #[test]
    fn accepting_changes_figures_alone() {
        let mut measured = figures([1_234, 1_700, 100]);
        measured.add(FigureKey::new("bytes", "flash", "image"), 7);
        let text = accepting(&TEXT.replace("kernel", "gone"), &measured).unwrap();
        let expected =
            TEXT.replace("{ 18 = 1_000, 32 = 1_700 }", "{ 18 = 1234, 32 = 1700 }").replace(
                "kernel = { 18 = 100 }\n",
                "kernel = { 18 = 100 }\n\n[measured.bytes]\nflash = { image = 7 }\n",
            );
        assert_eq!(text, expected);
        let budget = Budget::parse(&text).unwrap();
        assert_eq!(budget.changes(&measured), [""; 0]);
        assert_eq!(accepting(&text, &measured).unwrap(), text);
    }

    #[test]
    fn a_file_that_says_something_else_is_refused() {
        for (good, bad) in [
            ("at_most = 1.8", "at_most = nan"),
            ("at_most = 1.8", "at_most = -1"),
            ("at_most", "most"),
            ("times", "by"),
            ("instructions.tick.32", "tick.32"),
            ("18 = 100 ", "18 = -1 "),
        ] {
            let text = TEXT.replace(good, bad);
            assert_ne!(text, TEXT);
            let error = Budget::parse(&text).unwrap_err();
            assert!(format!("{error:#}").starts_with(FILE), "{bad}: {error:#}");
        }
    }

    #[test]
    fn the_committed_file_can_be_read() {
        Budget::parse(include_str!("../../../bench/budget.toml")).unwrap();
    }
}
