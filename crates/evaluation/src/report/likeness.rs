//! Writes the three errors of clips on a rig: tracking, retargeting and total.

use comfy_table::{CellAlignment, Table, presets::ASCII_MARKDOWN};

use super::super::Evaluation;

/// Returns the table of the three errors, by clip and method; `None` if no clip has a performer.
pub(super) fn likeness(evaluation: &Evaluation) -> Option<String> {
    let mut table = Table::new();
    table.load_style(ASCII_MARKDOWN);
    table.set_header([
        "clip",
        "method",
        "tracking mean",
        "max",
        "retargeting mean",
        "max",
        "total mean",
        "max",
    ]);
    let results = evaluation.figures.iter().flat_map(|figure| &figure.methods);
    for (index, clip) in evaluation.clips.iter().enumerate() {
        for result in results.clone() {
            let (errors, likeness) = (&result.clips[index], &result.likeness[index]);
            if likeness.total.is_empty() {
                continue;
            }
            let tracking = [errors.all.angular_mean_deg(), errors.all.angular_max_deg()];
            let of_performer = [likeness.retargeting, likeness.total]
                .map(|angles| [angles.mean_deg(), angles.largest_deg]);
            let numbers = tracking.into_iter().chain(of_performer.into_iter().flatten());
            let names = [clip.name.clone(), result.method.label().to_owned()];
            table.add_row(names.into_iter().chain(numbers.map(|deg| format!("{deg:.2}"))));
        }
    }
    for column in 2..8 {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    (!table.is_empty()).then(|| {
        format!(
            "\nThree errors, deg. Tracking: the simulated rig against its own target, all bodies. Retargeting: the target's\n\
             limbs against the performer's; the same for all methods. Total: the simulated rig's limbs against the performer's.\n\
             \n{table}\n"
        )
    })
}
