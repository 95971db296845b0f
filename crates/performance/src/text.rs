//! Formats numbers and units: angles in deg, lengths in mm.

use sinew_retarget::feasibility::{Excess, Kind, Limits, Report};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Link};

/// Formats a position with one decimal.
pub fn position(slides: bool, position: f64) -> String {
    plain(&format!("{:.1}", in_unit(slides, position)))
}

/// Formats a change of a joint, with its unit.
pub fn change(slides: bool, change: f64) -> String {
    let unit = Kind::Range.unit(slides);
    format!("{}{unit}", number(in_unit(slides, change)))
}

/// Formats a change; `None` if it rounds to 0.
pub fn visible_change(slides: bool, size: f64) -> Option<String> {
    (number(in_unit(slides, size)) != "0").then(|| change(slides, size))
}

fn in_unit(slides: bool, position: f64) -> f64 {
    if slides { 1000.0 * position } else { position.to_degrees() }
}

/// Returns a sentence with the numbers of dofs whose limits are unknown, for the limits that are checked; `None` if
/// all are known.
pub fn unknown(mechanism: &Mechanism, limits: &Limits, report: &Report) -> Option<String> {
    let moved = |link: &&Link| !matches!(link.joint, JointModel::Fixed | JointModel::Free);
    let count = |is_free: &dyn Fn(&Link) -> bool| -> usize {
        let links = mechanism.bodies.iter().filter(moved).filter(|link| is_free(link));
        links.map(|link| link.joint.kind().dof_count()).sum()
    };
    // A rig without masses has no torques.
    let is_heavy = report.peaks.iter().any(|peaks| peaks.effort > 0.0);
    let counts = [
        ("range", count(&|link| link.ranges.is_empty())),
        ("speed", count(&|link| link.speed.is_infinite())),
        ("torque", count(&|link| is_heavy && link.effort.is_infinite())),
    ];
    let told: Vec<_> = counts
        .iter()
        .filter(|(_, count)| *count > 0)
        .map(|(what, count)| format!("{count} of {what}"))
        .collect();
    let (all, told) = (limits.dofs.len(), told.join(", "));
    (!told.is_empty()).then(|| format!("Without a limit, of {all} degrees of freedom: {told}."))
}

/// Formats a number with about three digits.
pub fn number(x: f64) -> String {
    let digits = match x.abs() {
        size if size >= 99.95 => 0,
        size if size >= 9.995 => 1,
        size if size >= 0.9995 => 2,
        _ => 3,
    };
    plain(&format!("{x:.digits$}"))
}

/// Uses a true minus sign, and writes zero without sign and decimals.
fn plain(text: &str) -> String {
    if text.trim_start_matches(['-', '0', '.']).is_empty() {
        return "0".into();
    }
    text.replace('-', "−")
}

/// Describes an excess of a limit: "5.31 of 4.00 rad/s, 133 %", or "42.1° of 40.0°, 2.10° beyond". `rounding`: the
/// largest error of the checked motion, rad and m.
pub fn excess(slides: bool, excess: &Excess, rounding: [f64; 2]) -> String {
    let unit = excess.kind.unit(slides);
    if matches!(excess.kind, Kind::Range | Kind::LinkedRange) {
        let [value, limit] = [excess.value, excess.limit].map(|x| position(slides, x));
        let beyond = (excess.value - excess.limit).abs();
        let is_rounding = beyond <= rounding[usize::from(slides)];
        let within = if is_rounding { ", within the show's own error" } else { "" };
        let beyond = number(in_unit(slides, beyond));
        return format!("{value}{unit} of {limit}{unit}, {beyond}{unit} beyond{within}");
    }
    let shown =
        |x: f64| number(if excess.kind == Kind::Following { in_unit(slides, x) } else { x });
    let (value, limit) = (shown(excess.value), shown(excess.limit));
    if excess.limit > 0.0 {
        format!("{value} of {limit}{unit}, {:.0} %", 100.0 * excess.value / excess.limit)
    } else {
        format!("{value} of {limit}{unit}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_and_no_zero_below_zero() {
        let shown: Vec<_> = [-0.0001, 0.0123, -1.5, 12.34, 123.4].map(number).into();
        assert_eq!(shown, ["0", "0.012", "−1.50", "12.3", "123"]);
    }

    #[test]
    fn a_change_is_told_from_the_last_digit_shown_on() {
        let shown = |change_deg: f64| visible_change(false, change_deg.to_radians());
        assert_eq!([shown(0.0), shown(0.0004)], [None, None]);
        assert_eq!(shown(0.0006).as_deref(), Some("0.001°"));
        assert_eq!(visible_change(true, 1e-3).as_deref(), Some("1.00 mm"));
    }

    #[test]
    fn an_excess_says_by_how_much() {
        let of = |kind, value, limit| Excess {
            dof: 0,
            kind,
            from_s: 0.0,
            to_s: 0.1,
            worst_s: 0.1,
            value,
            limit,
        };
        assert_eq!(
            excess(false, &of(Kind::Speed, 5.0, 4.0), [0.0; 2]),
            "5.00 of 4.00 rad/s, 125 %"
        );
        let low = of(Kind::Range, -0.011, -0.01);
        let told = "−11.0 mm of −10.0 mm, 1.00 mm beyond";
        assert_eq!(excess(true, &low, [1.0, 0.0]), told);
        let within = format!("{told}, within the show's own error");
        assert_eq!(excess(true, &low, [0.0, 0.0011]), within);
    }
}
