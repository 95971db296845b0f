//! What the images may take: the committed budget, and how a measurement compares with it.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;

/// The budget's place in the workspace.
pub(crate) const FILE: &str = "firmware/budget.toml";

/// The method that ratios are to.
pub(crate) const REFERENCE: &str = "world";

/// Instructions per tick of a method, as measured or at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Instructions {
    pub(crate) control: u64,
    pub(crate) observe: u64,
}

impl Instructions {
    /// The whole tick.
    pub(crate) fn tick(self) -> u64 {
        self.control.saturating_add(self.observe)
    }
}

/// What an image takes beside its show, as measured or at most: the program in flash, and static RAM.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Size {
    pub(crate) program_bytes: u64,
    pub(crate) static_ram_bytes: u64,
}

/// At most so many times the instructions of [`REFERENCE`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Ratios {
    pub(crate) control: f64,
    pub(crate) tick: f64,
}

/// The committed limits.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Budget {
    pub(crate) methods: BTreeMap<String, Instructions>,
    pub(crate) ratios_to_world: BTreeMap<String, Ratios>,
    pub(crate) images: BTreeMap<String, Size>,
}

/// What was measured, in the order of the boards and of their methods.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Measured {
    pub(crate) methods: Vec<(String, Instructions)>,
    pub(crate) images: Vec<(String, Size)>,
    /// What the show of each image takes of its flash.
    pub(crate) shows_bytes: Vec<u64>,
}

impl Measured {
    /// The counts of a method.
    pub(crate) fn method(&self, name: &str) -> Option<Instructions> {
        self.methods.iter().find(|(measured, _)| measured == name).map(|(_, counts)| *counts)
    }
}

impl Budget {
    /// Reads the text of [`FILE`].
    pub(crate) fn parse(text: &str) -> Result<Self> {
        let budget: Self = toml::from_str(text).context(FILE)?;
        for (method, ratios) in &budget.ratios_to_world {
            for (part, ratio) in [("control", ratios.control), ("tick", ratios.tick)] {
                ensure!(
                    ratio.is_finite() && ratio > 0.0,
                    "{FILE}: {part} of {method} in [ratios_to_world] is {ratio}; it must be a positive number"
                );
            }
        }
        Ok(budget)
    }

    /// What takes too much or has no budget, a line for each; nothing if all is well.
    pub(crate) fn exceeded_by(&self, measured: &Measured) -> Vec<String> {
        let over = self.limits(measured).into_iter().filter(|limit| limit.measured > limit.most);
        let mut problems = unmatched("methods", &measured.methods, &self.methods);
        problems.extend(unmatched("images", &measured.images, &self.images));
        problems.extend(over.map(|Limit { what, unit, measured, most }| {
            format!("{what} takes {measured} {unit}, its budget is {most}")
        }));
        for (method, most) in &self.ratios_to_world {
            let (Some(counts), Some(reference)) =
                (measured.method(method), measured.method(REFERENCE))
            else {
                problems.push(format!(
                    "[ratios_to_world] lists {method}, and it or {REFERENCE} was not measured"
                ));
                continue;
            };
            for (part, count, reference, most) in [
                ("control", counts.control, reference.control, most.control),
                ("the tick", counts.tick(), reference.tick(), most.tick),
            ] {
                let ratio = ratio(count, reference);
                if ratio > most {
                    problems.push(format!(
                        "{part} of {method} takes {count} instructions, {ratio:.3} times the {reference} of \
                         {REFERENCE}; at most {most} times are allowed"
                    ));
                }
            }
        }
        problems
    }

    /// Which budgets are more than 10 % above what they limit, a line for each.
    pub(crate) fn too_generous_for(&self, measured: &Measured) -> Vec<String> {
        self.limits(measured)
            .into_iter()
            .filter(|limit| (limit.measured as f64) < 0.9 * limit.most as f64)
            .map(|Limit { what, unit, measured, most }| {
                format!("{what} takes {measured} of {most} {unit}: lower its budget")
            })
            .collect()
    }

    /// All that was measured and has a budget.
    fn limits(&self, measured: &Measured) -> Vec<Limit> {
        let limit = |part, of: &str, unit, measured, most| Limit {
            what: format!("{part} of {of}"),
            unit,
            measured,
            most,
        };
        let mut limits = Vec::new();
        for (method, counts) in &measured.methods {
            if let Some(most) = self.methods.get(method) {
                let unit = "instructions per tick";
                limits.push(limit("control", method, unit, counts.control, most.control));
                limits.push(limit("observe", method, unit, counts.observe, most.observe));
            }
        }
        for (image, size) in &measured.images {
            if let Some(most) = self.images.get(image) {
                let (program, ram) = (most.program_bytes, most.static_ram_bytes);
                limits.push(limit("program", image, "bytes", size.program_bytes, program));
                limits.push(limit("static RAM", image, "bytes", size.static_ram_bytes, ram));
            }
        }
        limits
    }
}

/// A number and its budget.
struct Limit {
    what: String,
    unit: &'static str,
    measured: u64,
    most: u64,
}

/// How many times `reference` a count is.
pub(crate) fn ratio(count: u64, reference: u64) -> f64 {
    count as f64 / reference as f64
}

/// What was measured and has no budget, or has one and was not measured.
fn unmatched<T>(
    section: &str,
    measured: &[(String, T)],
    budget: &BTreeMap<String, T>,
) -> Vec<String> {
    let names = || measured.iter().map(|(name, _)| name);
    let no_budget = names()
        .filter(|name| !budget.contains_key(*name))
        .map(|name| format!("[{section}] does not list {name}: give it a budget"));
    let unmeasured = budget
        .keys()
        .filter(|name| !names().any(|known| known == *name))
        .map(|name| format!("[{section}] lists {name}, which was not measured"));
    no_budget.chain(unmeasured).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "
        [methods]
        world = { control = 1_000, observe = 2_000 }
        better = { control = 1_500, observe = 2_000 }
        [ratios_to_world]
        better = { control = 1.6, tick = 1.2 }
        [images]
        board = { program_bytes = 10_000, static_ram_bytes = 100 }";

    fn counts(control: u64, observe: u64) -> Instructions {
        Instructions { control, observe }
    }

    /// All within [`TEXT`], and nothing too generous.
    fn good() -> Measured {
        Measured {
            methods: vec![
                ("world".to_owned(), counts(1_000, 2_000)),
                ("better".to_owned(), counts(1_500, 2_000)),
            ],
            images: vec![(
                "board".to_owned(),
                Size { program_bytes: 9_001, static_ram_bytes: 100 },
            )],
            shows_bytes: vec![50_000],
        }
    }

    fn broken_by(change: impl FnOnce(&mut Measured)) -> Vec<String> {
        let mut measured = good();
        change(&mut measured);
        let budget = Budget::parse(TEXT).unwrap();
        [budget.exceeded_by(&measured), budget.too_generous_for(&measured)].concat()
    }

    #[test]
    fn what_is_within_the_budget_is_fine() {
        assert_eq!(broken_by(|_| ()), [""; 0]);
    }

    #[test]
    fn one_too_many_names_method_count_and_budget() {
        assert_eq!(
            broken_by(|measured| measured.methods[1].1.observe = 2_001),
            ["observe of better takes 2001 instructions per tick, its budget is 2000"]
        );
        assert_eq!(
            broken_by(|measured| measured.images[0].1.static_ram_bytes = 101),
            ["static RAM of board takes 101 bytes, its budget is 100"]
        );
    }

    #[test]
    fn a_budget_more_than_a_tenth_too_generous_is_to_be_lowered() {
        assert_eq!(broken_by(|measured| measured.methods[1].1.observe = 1_800), [""; 0]);
        assert_eq!(
            broken_by(|measured| measured.methods[1].1.observe = 1_799),
            ["observe of better takes 1799 of 2000 instructions per tick: lower its budget"]
        );
        assert_eq!(
            broken_by(|measured| measured.images[0].1.program_bytes = 8_999),
            ["program of board takes 8999 of 10000 bytes: lower its budget"]
        );
    }

    #[test]
    fn ratios_are_of_what_was_measured_and_may_be_smaller() {
        assert_eq!(
            broken_by(|measured| measured.methods[0].1 = counts(900, 1_900)),
            [
                "control of better takes 1500 instructions, 1.667 times the 900 of world; at most 1.6 times are \
                 allowed",
                "the tick of better takes 3500 instructions, 1.250 times the 2800 of world; at most 1.2 times are \
                 allowed"
            ]
        );
        let cheap = Budget::parse(&TEXT.replace("1_500", "1_000")).unwrap();
        let mut measured = good();
        measured.methods[1].1 = counts(1_000, 2_000);
        assert_eq!(cheap.exceeded_by(&measured), [""; 0]);
        assert_eq!(cheap.too_generous_for(&measured), [""; 0]);
    }

    #[test]
    fn what_is_only_listed_or_only_measured_is_an_error() {
        assert_eq!(
            broken_by(|measured| measured.methods[1].0 = "other".to_owned()),
            [
                "[methods] does not list other: give it a budget",
                "[methods] lists better, which was not measured",
                "[ratios_to_world] lists better, and it or world was not measured"
            ]
        );
        assert_eq!(
            broken_by(|measured| measured.images.clear()),
            ["[images] lists board, which was not measured"]
        );
    }

    #[test]
    fn a_file_that_says_something_else_is_refused() {
        for (good, bad) in [
            ("control = 1.6", "control = nan"),
            ("tick = 1.2", "tick = -1.2"),
            ("control = 1_500", "control = -1"),
            ("control = 1_500, ", ""),
            ("static_ram_bytes", "ram_bytes"),
            ("[ratios_to_world]", "[ratios_to_local]"),
        ] {
            let text = TEXT.replace(good, bad);
            assert_ne!(text, TEXT);
            let error = Budget::parse(&text).unwrap_err();
            assert!(format!("{error:#}").starts_with(FILE), "{bad}: {error:#}");
        }
    }

    #[test]
    fn the_committed_budget_can_be_read() {
        Budget::parse(include_str!("../../firmware/budget.toml")).unwrap();
    }
}
