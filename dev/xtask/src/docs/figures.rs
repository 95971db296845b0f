//! Figures that tables of the documentation have from `budget.toml`: the same there, or a fault.

use std::fs;

use anyhow::{Context as _, Result};

use super::Fault;
use super::page::Page;
use crate::budget::{Budget, FILE, Place};
use crate::step;

/// A table of a page.
struct Table {
    page: &'static str,
    /// Its first line.
    head: &'static str,
    /// Of each row the first cell, and the figures in the others: `SECTION.ROW.COLUMN ..`, or two of them and a stroke
    /// for their quotient.
    rows: &'static [(&'static str, &'static [&'static str])],
}

/// Instructions for 6, 18 and 32 bodies, and the estimate of cycles for 18.
macro_rules! of_sizes {
    ($row:literal) => {
        [concat!("instructions.", $row, ".6 18 32"), concat!("estimated_cycles.", $row, ".18")]
    };
}

/// Instructions of the ticks of a rig of so many servos, and the RAM of its tracker.
macro_rules! of_servos {
    ($joints:literal) => {
        [
            concat!("instructions.rig_world_coordinates_revolute.", $joints),
            concat!("instructions.rig_world_poses_revolute.", $joints),
            concat!("instructions.rig_recommended_coordinates_revolute.", $joints),
            concat!("instructions.rig_recommended_poses_revolute.", $joints),
            concat!("type_bytes.Tracker_without_latency.", $joints),
        ]
    };
}

/// A tick of the whole loop of so many servos.
macro_rules! of_loop {
    ($servos:literal) => {
        [
            concat!("instructions.loop_recommended.", $servos),
            concat!("estimated_cycles.loop_recommended.", $servos),
            concat!("painted_stack_bytes.loop_recommended.", $servos),
            concat!("static_stack_bytes.loop_tick.", $servos),
            concat!("type_bytes.loop_ram.", $servos),
            concat!("loop_flash_bytes.loop_tick.", $servos),
        ]
    };
}

/// Instructions and the estimate of cycles.
macro_rules! now {
    ($place:literal) => {
        [concat!("instructions.", $place), concat!("estimated_cycles.", $place)]
    };
}

/// What 20 servos cost, to as many balls.
macro_rules! to_balls {
    ($row:literal) => {
        [concat!("instructions.", $row, "_revolute.20 / instructions.", $row, "_ball.20")]
    };
}

const TABLES: [Table; 9] = [
    Table {
        page: "README.md",
        head: "| on a Cortex-M4F, 18 bodies, 57 degrees of freedom | instructions |",
        rows: &[
            ("inverse dynamics", &["instructions.rnea_free_root.18"]),
            (
                "the core's own tick of World Space Error, from poses to limited torques",
                &["instructions.tick_world.18"],
            ),
            (
                "a tick of `recommended`, the setting for real rigs, with all that a board adds",
                &["instructions.board_recommended.18"],
            ),
        ],
    },
    Table {
        page: "docs/boards.md",
        head: "| | |",
        rows: &[
            ("inverse dynamics (RNEA)", &["instructions.rnea_free_root.18"]),
            (
                "a tick of World, from poses to torques: differences, kinematics, errors, PD, RNEA, limits",
                &["instructions.tick_world.18"],
            ),
            ("a tick of Linear Compensation", &["instructions.tick_linear_compensation.18"]),
            ("a tick of `recommended`, as boards run it", &["instructions.board_recommended.18"]),
            (
                "a tick of World in a board's image, with its show's frame",
                &["show_instructions.world.tick"],
            ),
            (
                "deepest stack of the core's tick, World / Linear Compensation",
                &[
                    "painted_stack_bytes.tick_world.18",
                    "painted_stack_bytes.tick_linear_compensation.18",
                ],
            ),
            ("targets, measured states and workspace", &["type_bytes.state_and_workspace.18"]),
            ("code that such a tick can reach", &["image_bytes.core_alone.tick"]),
        ],
    },
    Table {
        page: "docs/methods.md",
        head: "| method | mean | to World | worst tick |",
        rows: &[
            (
                "local",
                &[
                    "show_instructions.local.tick",
                    "show_instructions.local.tick / show_instructions.world.tick",
                    "show_instructions.local.worst_tick",
                ],
            ),
            (
                "world",
                &[
                    "show_instructions.world.tick",
                    "show_instructions.world.tick / show_instructions.world.tick",
                    "show_instructions.world.worst_tick",
                ],
            ),
            (
                "linear_compensation",
                &[
                    "show_instructions.linear_compensation.tick",
                    "show_instructions.linear_compensation.tick / show_instructions.world.tick",
                    "show_instructions.linear_compensation.worst_tick",
                ],
            ),
            (
                "recommended",
                &[
                    "show_instructions.recommended.tick",
                    "show_instructions.recommended.tick / show_instructions.world.tick",
                    "show_instructions.recommended.worst_tick",
                ],
            ),
        ],
    },
    Table {
        page: "docs/speed.md",
        head: "| | 6 | 18 | 32 | cycles, 18 |",
        rows: &[
            ("inverse dynamics (RNEA)", &of_sizes!("rnea_free_root")),
            ("forward dynamics (ABA)", &of_sizes!("aba")),
            ("mass matrix (CRBA)", &of_sizes!("crba")),
            ("forward kinematics", &of_sizes!("forward_kinematics")),
            ("desired side: forward differences", &of_sizes!("forward_differences")),
            ("measured side: backward differences", &of_sizes!("backward_differences")),
            ("Local error", &of_sizes!("error_local")),
            ("World error", &of_sizes!("error_world")),
            ("Linear Compensation error", &of_sizes!("error_linear_compensation")),
            ("manifold projection", &of_sizes!("projection")),
            ("observer", &of_sizes!("observer")),
            ("tick, Local", &of_sizes!("tick_local")),
            ("tick, World", &of_sizes!("tick_world")),
            ("tick, Linear Compensation", &of_sizes!("tick_linear_compensation")),
            ("tick, Resolved Acceleration", &of_sizes!("tick_resolved_acceleration")),
            ("tick as boards run it, World", &of_sizes!("board_world")),
            ("tick as boards run it, `recommended`", &of_sizes!("board_recommended")),
        ],
    },
    Table {
        page: "docs/speed.md",
        head: "| servos | World, coordinates | World, poses | `recommended`, coordinates | `recommended`, poses | RAM, bytes |",
        rows: &[("6", &of_servos!("6")), ("12", &of_servos!("12")), ("20", &of_servos!("20"))],
    },
    Table {
        page: "docs/speed.md",
        head: "| | instructions, before | now | cycles, before | now | rounding, before / now | time of Pinocchio's, before / now |",
        rows: &[
            ("inverse dynamics (RNEA)", &now!("rnea_free_root.18")),
            ("forward dynamics (ABA)", &now!("aba.18")),
            ("mass matrix (CRBA)", &now!("crba.18")),
            ("manifold projection", &now!("projection.18")),
            ("observer", &now!("observer.18")),
            ("tick, World", &now!("tick_world.18")),
            ("tick, Linear Compensation", &now!("tick_linear_compensation.18")),
            ("tick as boards run it, `recommended`", &now!("board_recommended.18")),
            ("the same, every fourth tick left out", &now!("board_recommended_after_jumps.18")),
            ("20 servos, the core's tick of World", &now!("tick_world_revolute.20")),
            (
                "20 servos, `recommended`, coordinates",
                &now!("rig_recommended_coordinates_revolute.20"),
            ),
            ("the whole loop of 20 servos", &now!("loop_recommended.20")),
        ],
    },
    Table {
        page: "docs/speed.md",
        head: "| 20 joints | servos, to balls |",
        rows: &[
            ("inverse dynamics (RNEA)", &to_balls!("rnea")),
            ("the core's tick, World", &to_balls!("tick_world")),
            ("a tick, World, coordinates", &to_balls!("rig_world_coordinates")),
            ("a tick, World, poses", &to_balls!("rig_world_poses")),
            ("a tick, `recommended`, coordinates", &to_balls!("rig_recommended_coordinates")),
            ("a tick, `recommended`, poses", &to_balls!("rig_recommended_poses")),
        ],
    },
    Table {
        page: "docs/speed.md",
        head: "| servos of the loop | instructions | cycles | stack, painted | stack, at most | RAM, bytes | flash, bytes |",
        rows: &[("6", &of_loop!("6")), ("20", &of_loop!("20")), ("40", &of_loop!("40"))],
    },
    Table {
        page: "docs/speed.md",
        head: "| | bytes |",
        rows: &[
            (
                "stack of the core's tick, World / Linear Compensation, painted",
                &[
                    "painted_stack_bytes.tick_world.18",
                    "painted_stack_bytes.tick_linear_compensation.18",
                ],
            ),
            (
                "stack of any method, at most, by frame sizes and calls",
                &["static_stack_bytes.core_tick.18"],
            ),
            (
                "stack of a board's tick, World / `recommended`, painted",
                &["painted_stack_bytes.board_world.18", "painted_stack_bytes.board_recommended.18"],
            ),
            ("stack of a board's tick, at most", &["static_stack_bytes.board_tick.18"]),
            ("RAM: targets, measured states and workspace", &["type_bytes.state_and_workspace.18"]),
            ("RAM: the frames that are remembered", &["type_bytes.ForwardDifferences.18"]),
            ("RAM: a tracker with room for `recommended`", &["type_bytes.Tracker.18"]),
            (
                "flash: code that a tick of World or Linear Compensation can reach, with its constants",
                &["image_bytes.core_alone.tick"],
            ),
            (
                "flash: the image with constructors, vectors and start-up",
                &["image_bytes.core_alone.flash"],
            ),
        ],
    },
];

pub(super) fn check(pages: &[Page]) -> Result<Vec<Fault>> {
    let text = fs::read_to_string(step::root().join(FILE)).context(FILE)?;
    let budget = Budget::parse(&text)?;
    let mut faults = Vec::new();
    for table in &TABLES {
        let page = pages.iter().find(|page| page.path == std::path::Path::new(table.page));
        let page = page.with_context(|| format!("there is no {}", table.page))?;
        faults.extend(table.faults(page, &|place| budget.accepted(place))?);
    }
    Ok(faults)
}

impl Table {
    /// The rows of the page's table that are not as accepted, and those that nobody knows.
    fn faults(&self, page: &Page, accepted: &dyn Fn(&Place) -> Option<u64>) -> Result<Vec<Fault>> {
        let Self { page: name, head, rows } = self;
        let lines = || (1..).zip(&page.lines).map(|(number, (line, _))| (number, line.as_str()));
        let mut table = lines().skip_while(|(_, line)| line != head);
        table.next().with_context(|| format!("{name} has no table `{head}`"))?;
        let found: Vec<_> = table.skip(1).take_while(|(_, line)| line.starts_with('|')).collect();
        let mut faults = Vec::new();
        for (index, (line, text)) in found.iter().enumerate() {
            let mut cells = text.trim_matches('|').splitn(2, '|');
            let first = cells.next().unwrap_or_default().trim();
            let what = match rows.get(index) {
                Some((known, places)) if *known == first => {
                    let expected = numbers(places, accepted)?;
                    let shown = shown(cells.next().unwrap_or_default());
                    (shown != expected).then(|| {
                        format!("{FILE} has {}, not {}", expected.join(" | "), shown.join(" | "))
                    })
                }
                _ => Some(format!("`{first}`: no row that {} knows", file!())),
            };
            faults.extend(what.map(|what| Fault { path: page.path.clone(), line: *line, what }));
        }
        for (first, _) in rows.iter().skip(found.len()) {
            let what = format!("there is no row `{first}`");
            faults.push(Fault { path: page.path.clone(), line: 1, what });
        }
        Ok(faults)
    }
}

/// The figures of places, as pages show them.
fn numbers(places: &[&str], accepted: &dyn Fn(&Place) -> Option<u64>) -> Result<Vec<String>> {
    let figure = |place: &str| -> Result<u64> {
        let known = Place::parse(place).and_then(|place| accepted(&place));
        known.with_context(|| format!("{FILE} has no {place}"))
    };
    let mut numbers = Vec::new();
    for place in places {
        if let Some((above, below)) = place.split_once(" / ") {
            numbers.push(format!("{:.2}", figure(above)? as f64 / figure(below)? as f64));
            continue;
        }
        let (row, columns) =
            place.rsplit_once('.').with_context(|| format!("{place}: no place"))?;
        for column in columns.split(' ') {
            numbers.push(with_commas(figure(&format!("{row}.{column}"))?));
        }
    }
    Ok(numbers)
}

/// `12,345`.
fn with_commas(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// The numbers in cells. What is in italics is of something else.
fn shown(cells: &str) -> Vec<String> {
    let is_number = |word: &&str| word.starts_with(|first: char| first.is_ascii_digit());
    cells.split([' ', '|']).filter(is_number).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_drifted_or_is_missing_is_a_fault() {
        let table = Table {
            page: "docs/a.md",
            head: "| | n |",
            rows: &[("a", &["s.a.6 18"]), ("b", &["s.b.6 / s.a.6", "s.b.18"]), ("c", &["s.c.6"])],
        };
        let accepted = |place: &Place| match (place.row.as_str(), place.column.as_str()) {
            ("a", "6") => Some(1_234),
            ("b", "6") => Some(2_468),
            (_, "18") => Some(7),
            _ => None,
        };
        let faults = |text: &str| -> Vec<(usize, String)> {
            let page = Page::new("docs/a.md".into(), text);
            let faults = table.faults(&page, &accepted).unwrap();
            faults.into_iter().map(|fault| (fault.line, fault.what)).collect()
        };
        let head = "text\n\n| | n |\n|---|---|\n";
        let found = faults(&format!("{head}| a | 1,234 / 7 B |\n| b | 2.00 | 8 |\n\n| c | 1 |\n"));
        let drifted = "budget.toml has 2.00 | 7, not 2.00 | 8".to_owned();
        assert_eq!(found, [(6, drifted), (1, "there is no row `c`".to_owned())]);
        let found = faults(&format!("{head}| d | 1 |\n"));
        assert!(found[0].1.starts_with("`d`: no row"), "{found:?}");
        // A place that was never measured.
        let page = Page::new(
            "docs/a.md".into(),
            "| | n |\n|---|---|\n| a | 1,234 / 7 |\n| b | 2.00 | 7 |\n| c | 1 |\n",
        );
        assert!(table.faults(&page, &accepted).is_err());
    }
}
