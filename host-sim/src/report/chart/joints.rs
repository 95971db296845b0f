//! Mean errors of the bodies, one by one.

use maud::{Markup, html};

use super::legend::{class, marker};
use super::{Axis, Frame, Quantity, WIDTH, chart, horizontal_axis, px};
use crate::evaluate::MethodName;
use crate::evaluate::detail::Spread;

const ROW: f64 = 29.0;
const BAR: f64 = 7.5;

/// One quantity of one figure, a bar per body and method.
pub(in crate::report) fn joints(
    bodies: &[String],
    spreads: &[(MethodName, Spread)],
    quantity: Quantity,
) -> Markup {
    let height = 30.0 + ROW * bodies.len() as f64 + 40.0;
    let frame = Frame { left: 92.0, top: 30.0, right: WIDTH - 14.0, bottom: height - 40.0 };
    let means = |body: usize| {
        spreads.iter().map(move |(method, spread)| (*method, quantity.mean(&spread.bodies[body])))
    };
    let all = (0..bodies.len()).flat_map(means);
    let (worst, largest) = (0..bodies.len())
        .flat_map(|body| means(body).map(move |(_, mean)| (body, mean)))
        .fold((0, 0.0), |worst, one| if one.1 > worst.1 { one } else { worst });
    debug_assert_eq!(all.count(), bodies.len() * spreads.len());
    let axis = Axis::from_zero(largest, [frame.left, frame.right]);
    let title = format!("Mean {} error by body ({})", quantity.name(), quantity.unit());
    let description =
        format!("The largest is the {}'s: {largest:.2} {}", name(&bodies[worst]), quantity.unit());
    let middle = 0.5 * (spreads.len() as f64 - 1.0);
    chart(
        height,
        &title,
        &description,
        &html! {
            (horizontal_axis(frame, &axis, &format!("mean {} error ({})", quantity.name(), quantity.unit())))
            @for body in 0..bodies.len() {
                @let y = frame.top + ROW * (body as f64 + 0.5);
                text class="tick" x=(px(frame.left - 8.0)) y=(px(y + 4.0)) text-anchor="end" { (name(&bodies[body])) }
                @for (index, (method, mean)) in means(body).enumerate() {
                    @let y = y + BAR * (index as f64 - middle);
                    g class=(class(method)) {
                        line class="bar" x1=(px(frame.left)) x2=(px(axis.at(mean))) y1=(px(y)) y2=(px(y)) {}
                        (marker(method, axis.at(mean), y))
                    }
                }
            }
            line class="axis" x1=(px(frame.left)) x2=(px(frame.left)) y1=(px(frame.top)) y2=(px(frame.bottom)) {}
        },
    )
}

/// A body's name as one reads it.
fn name(name: &str) -> String {
    match name
        .strip_suffix("_l")
        .map(|side| (side, "L"))
        .or(name.strip_suffix("_r").map(|side| (side, "R")))
    {
        Some((name, side)) => format!("{} {side}", name.replace('_', " ")),
        None => name.to_owned(),
    }
}
