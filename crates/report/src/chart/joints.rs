//! Charts of the mean errors of each body.

use maud::{Markup, html};
use sinew_evaluation::MethodName;
use sinew_evaluation::detail::Spread;

use super::axis::Axis;
use super::frame::{Frame, WIDTH, chart, horizontal_axis};
use super::legend::{class, marker};
use super::path::px;
use super::quantity::Quantity;

/// Height of a body's row in charts of the figure.
pub(crate) const ROW: f64 = 29.0;
const BAR: f64 = 7.5;
/// Width of a letter of a name. The next constant is the maximum number of letters.
const LETTER: f64 = 6.9;
const LETTERS: usize = 23;

/// Returns the height of a row in which this number of bars does not touch the bars of the next row.
pub(crate) fn room(bars: usize) -> f64 {
    ROW.max(BAR * bars as f64 + 6.5)
}

/// Draws one quantity of one figure, with a bar per body and method. `row` is the height of a body's row.
pub(crate) fn joints(
    bodies: &[String],
    spreads: &[(MethodName, Spread)],
    quantity: Quantity,
    row: f64,
) -> Markup {
    let height = 30.0 + row * bodies.len() as f64 + 40.0;
    let names: Vec<String> = bodies.iter().map(|body| name(body)).collect();
    let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    // Room for the figure's names, and for longer names up to a limit.
    let left = (LETTER * longest as f64 + 12.0).max(92.0);
    let frame = Frame { left, top: 30.0, right: WIDTH - 14.0, bottom: height - 40.0 };
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
        format!("The largest is the {}'s: {largest:.2} {}", names[worst], quantity.unit());
    let middle = 0.5 * (spreads.len() as f64 - 1.0);
    chart(
        height,
        &title,
        &description,
        &html! {
            (horizontal_axis(frame, &axis, &format!("mean {} error ({})", quantity.name(), quantity.unit())))
            @for body in 0..bodies.len() {
                @let y = frame.top + row * (body as f64 + 0.5);
                text class="tick" x=(px(frame.left - 8.0)) y=(px(y + 4.0)) text-anchor="end" { (names[body]) }
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

/// Formats a body's name for readers. A name that is too long loses its middle, since names differ at their ends.
fn name(name: &str) -> String {
    let count = name.chars().count();
    if count > LETTERS {
        let half = (LETTERS - 1) / 2;
        let begin: String = name.chars().take(half).collect();
        let end: String = name.chars().skip(count - half).collect();
        return format!("{begin}…{end}");
    }
    match name
        .strip_suffix("_l")
        .map(|side| (side, "L"))
        .or(name.strip_suffix("_r").map(|side| (side, "R")))
    {
        Some((name, side)) => format!("{} {side}", name.replace('_', " ")),
        None => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_as_one_reads_them_and_fit() {
        assert_eq!(name("upper_arm_l"), "upper arm L");
        assert_eq!(name("wrist_roll_link"), "wrist_roll_link");
        let long = name("left_front_leg_of_the_lower_body_link");
        assert_eq!((long.as_str(), long.chars().count()), ("left_front_…r_body_link", 23));
    }
}
