//! Tables of the demands on each joint with its limits, and of the times of excesses.

use maud::{Markup, html};
use sinew_performance::text;
use sinew_retarget::feasibility::{DofLimits, DofPeaks, Excess, Kind};

use super::data::Drawn;
use crate::joint_table::joint_table;

/// Maximum number of listed excesses. The script draws all of them.
const LISTED: usize = 200;

/// Returns the table of all joints.
pub(super) fn joints(drawn: &Drawn<'_>) -> Markup {
    let head = [
        "Joint",
        "Range used, °",
        "Speed, rad/s",
        "Acceleration, rad/s²",
        "Torque, N\u{a0}m",
        "RMS, N\u{a0}m",
    ];
    let dofs = drawn.dofs.iter().enumerate();
    joint_table(&head, &html! { @for (place, dof) in dofs { (joint(drawn, place, dof.index)) } })
}

fn joint(drawn: &Drawn<'_>, place: usize, index: usize) -> Markup {
    let (limits, peaks) = (&drawn.limits.dofs[index], &drawn.report.peaks[index]);
    let of_kind = |kinds: &[Kind]| {
        let mut all = drawn.report.excesses.iter();
        all.any(|excess| excess.dof == index && kinds.contains(&excess.kind))
    };
    let cell = |value: f64, limit: f64, kind: Kind| {
        let unit = if limits.slides { kind.unit(true) } else { "" };
        peak(value, limit, unit, of_kind(&[kind]))
    };
    let continuous = limits.heat.map_or(f64::INFINITY, |heat| heat.continuous);
    html! {
        tr data-joint=(place) {
            th scope="row" { button type="button" aria-pressed="false" { (limits.name) } }
            (range(limits, peaks, drawn.dofs[place].turn, of_kind(&[Kind::Range, Kind::LinkedRange])))
            (cell(peaks.speed, limits.speed, Kind::Speed))
            (cell(peaks.acceleration, limits.acceleration, Kind::Acceleration))
            (cell(peaks.effort, limits.effort, Kind::Effort))
            (cell(peaks.effort_rms, continuous, Kind::Heat))
        }
    }
}

/// Returns the cell with the used part of a joint's range. `turn` is the limit of a ball joint's whole rotation.
fn range(limits: &DofLimits, peaks: &DofPeaks, turn: Option<f64>, is_exceeded: bool) -> Markup {
    let unit = if limits.slides { " mm" } else { "" };
    let text = |x: f64| text::position(limits.slides, x);
    let [least, most] = limits.range;
    let bar = (least.is_finite() && most.is_finite() && most > least).then(|| {
        let share = |x: f64| (100.0 * (x - least) / (most - least)).clamp(0.0, 100.0);
        let (from, to) = (share(peaks.least), share(peaks.most));
        format!("left: {from:.1}%; width: {:.1}%", to - from)
    });
    html! {
        td class=[is_exceeded.then_some("exceeded")] {
            @if turn.is_some() {
                "a ball"
            } @else {
                (text(peaks.least)) " to " (text(peaks.most)) (unit)
            }
            @if is_exceeded { " " span class="flag" { "exceeded" } }
            small {
                @if let Some(turn) = turn {
                    @if turn.is_finite() { "turn of " (text(turn)) } @else { "no limit" }
                } @else if least.is_finite() || most.is_finite() {
                    "of " (bound(least, &text, "−∞")) " to " (bound(most, &text, "∞")) (unit)
                } @else { "no limit" }
            }
            @if let Some(bar) = bar { span class="bar" aria-hidden="true" { i style=(bar) {} } }
        }
    }
}

fn bound(x: f64, text: &impl Fn(f64) -> String, infinite: &str) -> String {
    if x.is_finite() { text(x) } else { infinite.to_owned() }
}

/// Returns the cell with a peak value and its limit.
fn peak(value: f64, limit: f64, unit: &str, is_exceeded: bool) -> Markup {
    let bar = (limit.is_finite() && limit > 0.0)
        .then(|| format!("width: {:.1}%", (100.0 * value / limit).min(100.0)));
    html! {
        td class=[is_exceeded.then_some("exceeded")] {
            (text::number(value)) (unit)
            @if is_exceeded { " " span class="flag" { "exceeded" } }
            small {
                @if limit.is_finite() { "of " (text::number(limit)) (unit) } @else { "no limit" }
            }
            @if let Some(bar) = bar { span class="bar" aria-hidden="true" { i style=(bar) {} } }
        }
    }
}

/// Returns the list of excesses in the order of time. If there are too many, only the worst are listed.
pub(super) fn excesses(drawn: &Drawn<'_>) -> Markup {
    let all = &drawn.excesses;
    let mut listed: Vec<usize> = (0..all.len()).collect();
    listed.sort_by(|a, b| severity(&all[*b]).total_cmp(&severity(&all[*a])));
    listed.truncate(LISTED);
    listed.sort_by(|a, b| all[*a].from_s.total_cmp(&all[*b].from_s));
    html! {
        @if all.is_empty() {
            p { "Nothing is exceeded." }
        } @else {
            @if all.len() > LISTED {
                p class="small" { "The worst " (LISTED) " of " (all.len()) ", in time." }
            }
            ol id="excesses" tabindex="0" aria-label="Excesses in time" {
                @for index in listed {
                    @let excess = &all[index];
                    @let limits = &drawn.limits.dofs[excess.dof];
                    li {
                        button type="button" data-excess=(index) {
                            span class="when" { (format!("{:.2} s", excess.from_s)) }
                            span {
                                b { (limits.name) } ": " (excess.kind.name()) " "
                                (text::excess(limits.slides, excess, [0.0; 2]))
                                small { " for " (lasting(excess.to_s - excess.from_s)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn lasting(seconds: f64) -> String {
    if seconds < 0.005 { "an instant".into() } else { format!("{seconds:.2} s") }
}

/// Returns the severity of an excess: its ratio to the limit; for a range, 1 plus the distance beyond it.
fn severity(excess: &Excess) -> f64 {
    match excess.kind {
        Kind::Range | Kind::LinkedRange => 1.0 + (excess.value - excess.limit).abs(),
        _ => excess.value / excess.limit,
    }
}
