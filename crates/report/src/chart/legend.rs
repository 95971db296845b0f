//! Colours, dashes and markers of the methods, equal in every chart.

use maud::{Markup, html};
use sinew_evaluation::MethodName;

use super::path::px;

/// Returns the CSS classes of a method's colour and dashes.
pub(crate) fn class(method: MethodName) -> String {
    format!("method {}", method.as_str())
}

/// Draws a method's marker at a position.
pub(super) fn marker(method: MethodName, x: f64, y: f64) -> Markup {
    let corners: &[(f64, f64)] = match method {
        MethodName::Local => return html! { circle class="marker" cx=(px(x)) cy=(px(y)) r="4" {} },
        MethodName::World => &[(-3.6, -3.6), (3.6, -3.6), (3.6, 3.6), (-3.6, 3.6)],
        MethodName::LinearCompensation => &[(0.0, -4.8), (4.6, 3.4), (-4.6, 3.4)],
        MethodName::Egocentric => &[(0.0, -4.8), (4.8, 0.0), (0.0, 4.8), (-4.8, 0.0)],
        MethodName::Accumulated => &[(0.0, 4.8), (4.6, -3.4), (-4.6, -3.4)],
        MethodName::ManifoldProjection => {
            &[(0.0, -4.8), (4.6, -1.5), (2.8, 3.9), (-2.8, 3.9), (-4.6, -1.5)]
        }
        MethodName::ResolvedAcceleration => {
            &[(4.4, 0.0), (2.2, 3.8), (-2.2, 3.8), (-4.4, 0.0), (-2.2, -3.8), (2.2, -3.8)]
        }
        MethodName::Recommended => &[
            (0.0, -5.4),
            (1.4, -1.7),
            (5.2, -1.7),
            (2.2, 0.7),
            (3.3, 4.4),
            (0.0, 2.2),
            (-3.3, 4.4),
            (-2.2, 0.7),
            (-5.2, -1.7),
            (-1.4, -1.7),
        ],
    };
    let points: Vec<String> =
        corners.iter().map(|(dx, dy)| format!("{},{}", px(x + dx), px(y + dy))).collect();
    html! { polygon class="marker" points=(points.join(" ")) {} }
}

/// Returns a legend of the methods, for several charts together.
pub(crate) fn legend(methods: impl IntoIterator<Item = MethodName>) -> Markup {
    html! {
        ul class="legend" aria-label="Methods" {
            @for method in methods {
                li {
                    svg xmlns="http://www.w3.org/2000/svg" class="chart key" viewBox="0 0 36 14" aria-hidden="true" {
                        g class=(class(method)) {
                            path class="stroke" d="M1 7L35 7" {}
                            (marker(method, 18.0, 7.0))
                        }
                    }
                    (method.label())
                }
            }
        }
    }
}

/// Returns the legend of a chart that is a file of its own, in lines that fit a width, and its height.
pub(crate) fn legend_lines(
    methods: impl IntoIterator<Item = MethodName>,
    width: f64,
) -> (Markup, f64) {
    const LINE: f64 = 20.0;
    let (mut left, mut y) = (10.0, 12.0);
    let mut entries = Vec::new();
    for method in methods {
        // A letter is about 7 units wide.
        let length = 58.0 + 7.0 * method.label().len() as f64;
        if left + length > width && left > 10.0 {
            (left, y) = (10.0, y + LINE);
        }
        entries.push((method, left, y));
        left += length;
    }
    let legend = html! {
        @for (method, at, y) in entries {
            g class=(class(method)) {
                path class="stroke" d={ "M" (px(at)) " " (px(y)) "l34 0" } {}
                (marker(method, at + 17.0, y))
            }
            text class="tick" x=(px(at + 41.0)) y=(px(y + 4.0)) { (method.label()) }
        }
    };
    (legend, y + 14.0)
}
