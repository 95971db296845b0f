//! What was measured beside its budget, as tables of aligned columns.

use std::fmt::Write;

use crate::budget::{Budget, Instructions, Measured, REFERENCE, ratio};

/// What the images take.
pub(crate) fn images(measured: &Measured, budget: Option<&Budget>) -> String {
    let mut text = format!(
        "{:<16} {:>9} {:>11} {:>8} {:>14} {:>8}\n",
        "image", "show, B", "program, B", "budget", "static RAM, B", "budget"
    );
    for ((image, size), show_bytes) in measured.images.iter().zip(&measured.shows_bytes) {
        let most = budget.and_then(|budget| budget.images.get(image));
        let _ = writeln!(
            text,
            "{image:<16} {show_bytes:>9} {:>11} {:>8} {:>14} {:>8}",
            size.program_bytes,
            cell(most.map(|most| most.program_bytes)),
            size.static_ram_bytes,
            cell(most.map(|most| most.static_ram_bytes))
        );
    }
    text
}

/// What a tick takes in the emulated board, by method, with ratios to [`REFERENCE`].
pub(crate) fn instructions(measured: &Measured, budget: Option<&Budget>) -> String {
    let mut text = format!(
        "{:<20} {:<8} {:>12} {:>8} {:>14} {:>8}\n",
        "method",
        "part",
        "instructions",
        "budget",
        format!("to {REFERENCE}"),
        "at most"
    );
    let reference = measured.method(REFERENCE);
    for (method, counts) in &measured.methods {
        let most = budget.and_then(|budget| budget.methods.get(method));
        let ratios = budget.and_then(|budget| budget.ratios_to_world.get(method));
        for (part, count, most, reference, at_most) in [
            (
                "control",
                counts.control,
                most.map(|most| most.control),
                reference.map(|reference| reference.control),
                ratios.map(|ratios| ratios.control),
            ),
            (
                "observe",
                counts.observe,
                most.map(|most| most.observe),
                reference.map(|reference| reference.observe),
                None,
            ),
            (
                "tick",
                counts.tick(),
                None,
                reference.map(Instructions::tick),
                ratios.map(|ratios| ratios.tick),
            ),
        ] {
            let to_reference =
                cell(reference.map(|reference| format!("{:.3}", ratio(count, reference))));
            let _ = writeln!(
                text,
                "{method:<20} {part:<8} {count:>12} {:>8} {to_reference:>14} {:>8}",
                cell(most),
                cell(at_most)
            );
        }
    }
    text
}

/// A number, or a dash where there is none.
fn cell(number: Option<impl ToString>) -> String {
    number.map_or_else(|| "-".to_owned(), |number| number.to_string())
}
