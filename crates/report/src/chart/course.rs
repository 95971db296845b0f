//! Charts of errors over the time of a clip.

use maud::{Markup, html};
use sinew_evaluation::MethodName;
use sinew_evaluation::detail::ErrorTrace;

use super::axis::Axis;
use super::frame::{Frame, chart, horizontal_axis, vertical_axis};
use super::legend::class;
use super::path::{line, px};
use super::quantity::Quantity;

const HEIGHT: f64 = 260.0;

/// A statistic over all bodies at one time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Statistic {
    /// The mean over all bodies.
    Mean,
    /// The largest error of any body.
    Max,
}

impl Statistic {
    pub(crate) const BOTH: [Self; 2] = [Self::Mean, Self::Max];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Max => "max",
        }
    }
}

/// Draws one quantity of one clip and figure, with a line per method.
pub(crate) fn course(
    courses: &[(MethodName, &ErrorTrace)],
    dt_s: f64,
    quantity: Quantity,
    statistic: Statistic,
) -> Markup {
    let frame = Frame::of_height(HEIGHT, 44.0);
    let lines: Vec<(MethodName, Vec<(f64, f64)>)> = courses
        .iter()
        .map(|(method, course)| (*method, points(course, dt_s, quantity, statistic)))
        .collect();
    let all = || lines.iter().flat_map(|(_, points)| points);
    let largest = all().map(|(_, error)| *error).fold(0.0, f64::max);
    let duration = all().map(|(time, _)| *time).fold(dt_s, f64::max);
    let time = Axis::exact([0.0, duration], [frame.left, frame.right]);
    let error = Axis::from_zero(largest, [frame.bottom, frame.top]);
    let title = match statistic {
        Statistic::Mean => format!("Mean {} error ({})", quantity.name(), quantity.unit()),
        Statistic::Max => format!("Largest {} error ({})", quantity.name(), quantity.unit()),
    };
    let description =
        format!("Over {duration:.1} seconds, at most {largest:.2} {}", quantity.unit());
    chart(
        HEIGHT,
        &title,
        &description,
        &html! {
            (vertical_axis(frame, &error))
            (horizontal_axis(frame, &time, "time (s)"))
            @for (method, points) in &lines {
                g class=(class(*method)) {
                    path class="stroke" d=(line(points.iter().map(|(t, e)| (time.at(*t), error.at(*e))))) {}
                }
            }
            line class="axis" x1=(px(frame.left)) x2=(px(frame.right)) y1=(px(frame.bottom)) y2=(px(frame.bottom)) {}
        },
    )
}

/// Maximum number of points that can be distinguished at a chart's width.
const POINTS: usize = 250;

/// Returns the middles of the stretches in seconds and their errors. Neighbouring stretches are joined to limit
/// the number of points.
fn points(
    course: &ErrorTrace,
    dt_s: f64,
    quantity: Quantity,
    statistic: Statistic,
) -> Vec<(f64, f64)> {
    let joined = course.stretches().len().div_ceil(POINTS).max(1);
    let seconds_each = course.steps_each() as f64 * dt_s;
    let stretches = course.stretches().chunks(joined).enumerate();
    stretches
        .map(|(index, stretches)| {
            let middle = (index * joined) as f64 + 0.5 * stretches.len() as f64;
            let error = match statistic {
                Statistic::Mean => {
                    // The last stretch may be shorter: the mean is weighted by the number of errors.
                    let n: u64 = stretches.iter().map(|stretch| stretch.n).sum();
                    let sum: f64 =
                        stretches.iter().map(|one| quantity.mean(one) * one.n as f64).sum();
                    sum / n as f64
                }
                Statistic::Max => stretches.iter().map(|one| quantity.max(one)).fold(0.0, f64::max),
            };
            (middle * seconds_each, error)
        })
        .collect()
}
