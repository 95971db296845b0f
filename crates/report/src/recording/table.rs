//! Tables of a recording: states and faults in the order of time, and the tracking errors of each joint.

use maud::{Markup, html};
use sinew_performance::text;

use super::rig::Joint;
use super::watch::{JointSummary, Span, Watch};
use crate::joint_table::joint_table;

/// Maximum number of listed faults. The plots contain all of them.
const LISTED: usize = 200;

/// Returns the list of states and faults, in the order of time.
pub(super) fn course(watch: &Watch) -> Markup {
    let (states, faults) = (watch.states.iter(), watch.faults.iter().take(LISTED));
    let mut all: Vec<(f64, Markup)> =
        states.map(|state| (state.from_s, self::state(state))).collect();
    all.extend(faults.map(|(at_s, fault)| (*at_s, fault_text(fault))));
    all.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    html! {
        @if watch.faults.len() > LISTED {
            p class="small" { "The first " (LISTED) " of " (watch.faults.len()) " faults." }
        }
        ol id="excesses" tabindex="0" aria-label="States and faults in time" {
            @for (at_s, what) in all {
                li {
                    button type="button" data-at=(format!("{at_s:.3}")) {
                        span class="when" { (format!("{at_s:.2} s")) }
                        span { (what) }
                    }
                }
            }
        }
    }
}

/// Returns the text of a fault or a warning, with its kind.
fn fault_text(fault: &str) -> Markup {
    let warning = fault.strip_prefix("warning ").map(|warning| ("Warning: ", warning));
    let (kind, what) = warning.unwrap_or(("Fault: ", fault));
    html! { b class="flag" { (kind) (what) } }
}

fn state(state: &Span) -> Markup {
    html! { (state.name) small { " for " (format!("{:.2} s", state.to_s - state.from_s)) } }
}

/// Returns the table of all joints.
pub(super) fn joints(joints: &[Joint], watch: &Watch) -> Markup {
    let head = [
        "Joint",
        "Mean error",
        "Largest error",
        "Torque, N\u{a0}m",
        "Current, A",
        "Warmest, °C",
        "Swing",
        "Limited",
    ];
    let joints = joints.iter().zip(watch.told());
    joint_table(&head, &html! { @for (joint, told) in joints { (row(joint, told)) } })
}

fn row(joint: &Joint, told: &JointSummary) -> Markup {
    let unit = if joint.slides { " N" } else { "" };
    // A value that was never read is 0.
    let known = |number: f64, text: String| if number > 0.0 { text } else { "–".to_owned() };
    html! {
        tr {
            th scope="row" { button type="button" aria-pressed="false" { (joint.name) } }
            @if told.ticks == 0 || joint.columns.servo.is_none() {
                td colspan="7" class="small" {
                    @if told.ticks == 0 { "no show ran" } @else { "no servo moves it" }
                }
            } @else {
                td { (text::change(joint.slides, told.error_mean())) }
                td {
                    button type="button" data-at=(format!("{:.3}", told.error_most_s)) {
                        (text::change(joint.slides, told.error_most))
                    }
                    small { "at " (format!("{:.2} s", told.error_most_s)) }
                }
                td { (text::number(told.effort)) (unit) }
                td { (known(told.current_a, text::number(told.current_a))) }
                td { (known(told.celsius, format!("{:.0}", told.celsius))) }
                td class="unit" {
                    @let swing = text::change(joint.slides, told.swing.peak_to_peak());
                    @if told.is_swinging { b class="flag" { (swing) } } @else { (swing) }
                }
                td { (told.limited()) }
            }
        }
    }
}
