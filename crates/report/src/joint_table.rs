//! The table of joints on pages of a rig.

use maud::{Markup, html};

/// Returns the table, with a column for each name in `head`.
pub(super) fn joint_table(head: &[&str], rows: &Markup) -> Markup {
    html! {
        div class="scroll" tabindex="0" role="region" aria-labelledby="joints-title" {
            table id="joints" {
                thead { tr { @for name in head { th scope="col" { (name) } } } }
                tbody { (rows) }
            }
        }
    }
}
