//! Charts of the distribution of errors.

use maud::{Markup, html};
use sinew_evaluation::MethodName;
use sinew_evaluation::detail::Spread;

use super::axis::Axis;
use super::frame::{Frame, chart, horizontal_axis, vertical_axis};
use super::legend::class;
use super::path::{line, px};
use super::quantity::Quantity;

const HEIGHT: f64 = 280.0;

/// Draws the distribution function of one quantity, with a line per method.
pub(crate) fn distribution(spreads: &[(MethodName, Spread)], quantity: Quantity) -> Markup {
    let frame = Frame::of_height(HEIGHT, 44.0);
    let curves: Vec<(MethodName, Vec<(f64, f64)>)> = spreads
        .iter()
        .map(|(method, spread)| {
            let histogram = match quantity {
                Quantity::Angular => &spread.angular_deg,
                Quantity::Linear => &spread.linear_cm,
            };
            (*method, histogram.cumulative())
        })
        .collect();
    // The smallest thousandth of the errors is omitted: it is not of interest, and would fill half of the axis.
    let ends = curves.iter().flat_map(|(_, curve)| {
        let low = curve.iter().find(|(_, share)| *share >= 1e-3);
        low.into_iter().chain(curve.last())
    });
    let (low, high) = ends.fold((f64::INFINITY, 0.0_f64), |(low, high), (error, _)| {
        (low.min(*error), high.max(*error))
    });
    let (low, high) = if low < high { (low, high) } else { (0.1, 10.0) };
    let error = Axis::logarithmic([low, high], [frame.left, frame.right]);
    let share = Axis::exact([0.0, 100.0], [frame.bottom, frame.top]);
    let title = format!("Share of {} errors below (%)", quantity.name());
    let medians: Vec<String> = curves
        .iter()
        .filter_map(|(method, curve)| {
            let (median, _) = curve.iter().find(|(_, share)| *share >= 0.5)?;
            Some(format!("{method}: half are below {median:.2} {}", quantity.unit()))
        })
        .collect();
    chart(
        HEIGHT,
        &title,
        &medians.join(", "),
        &html! {
            (vertical_axis(frame, &share))
            (horizontal_axis(frame, &error, &format!("{} error ({}), logarithmic", quantity.name(), quantity.unit())))
            @for (method, curve) in &curves {
                @let visible = curve.iter().filter(|(error, _)| *error >= low);
                g class=(class(*method)) {
                    path class="stroke" d=(line(visible.map(|(e, s)| (error.at(*e), share.at(100.0 * s))))) {}
                }
            }
            line class="axis" x1=(px(frame.left)) x2=(px(frame.right)) y1=(px(frame.bottom)) y2=(px(frame.bottom)) {}
        },
    )
}
