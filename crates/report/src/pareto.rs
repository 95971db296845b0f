//! The front of an evaluation: every method's mean linear error over its mean angular error, with the nearest
//! poses.

use maud::{Markup, html};
use sinew_evaluation::optimum::{Curve, Optimum, RootConstraint, WEIGHTS_M};
use sinew_evaluation::pareto::on_front;
use sinew_evaluation::{ErrorTotals, Errors, FigureResult};

use super::chart::{ParetoChart, Reference, Spot};
use super::report::Report;
use super::text::Words;

type Group = (&'static str, fn(&Errors) -> &ErrorTotals);

/// Groups of joints whose distances are shown. The angles are always those of all joints: a leaf can turn without
/// moving another body, but its position depends on the angles of other joints.
const GROUPS: [Group; 2] =
    [("all joints", |errors| &errors.all), ("leaf joints", |errors| &errors.leaf)];

/// Weights that are written beside a curve.
const NAMED_M: [f64; 4] = [10.0, 0.5, 0.2, 0.05];

/// Returns the charts of the figure at index `place` of the evaluation.
pub(super) fn charts(figure: &FigureResult, place: usize, report: &Report<'_>) -> [Markup; 2] {
    let words = Words::of(report.evaluation);
    let curves = report.optimum.map_or(&[][..], |optimum| &optimum.scales[place]);
    GROUPS.map(|(name, group)| {
        let means =
            |errors: &Errors| [errors.all.angular_mean_deg(), group(errors).linear_mean_cm()];
        let of_methods: Vec<_> = figure.methods.iter().map(|result| means(&result.total)).collect();
        let spots = figure.methods.iter().zip(&of_methods).zip(on_front(&of_methods));
        let spots = spots.map(|((result, means), on_front)| Spot {
            method: Some(result.method),
            name: result.method.label().to_owned(),
            label: Some(result.method.label().to_owned()),
            means: *means,
            on_front,
        });
        let front = ParetoChart {
            title: format!("Mean linear error of {name} (cm)"),
            condition: words.subject(figure.scale),
            spots: spots.collect(),
            joined: Vec::new(),
            references: curves.iter().map(|curve| reference(curve, means)).collect(),
        };
        front.draw()
    })
}

fn reference(curve: &Curve, means: impl Fn(&Errors) -> [f64; 2]) -> Reference {
    let (name, dashed) = match curve.held {
        RootConstraint::Free => ("nearest pose, root free", false),
        RootConstraint::Position => ("root position held", true),
        RootConstraint::Pose => ("nearest pose, pelvis bolted", false),
    };
    let points: Vec<_> = curve.points.iter().map(|point| means(&point.errors)).collect();
    let same = points.iter().flatten().all(|error| *error < 1e-9);
    let labels = match curve.held {
        RootConstraint::Position => Vec::new(),
        // All weights give one point: the clip's own pose.
        _ if same => vec![("nearest pose".to_owned(), points[0])],
        _ => {
            let named = curve.points.iter().zip(&points);
            let named = named.filter(|(point, _)| NAMED_M.contains(&point.weight_m));
            named.map(|(point, means)| (format!("{} m", point.weight_m), *means)).collect()
        }
    };
    Reference { name, dashed, means: points, labels }
}

/// Explains the charts in words.
pub(super) fn explanation(optimum: Option<&Optimum>) -> Markup {
    let [most_m, .., least_m] = WEIGHTS_M;
    html! {
        p {
            "The nearer to the lower left, the better. A ring marks a Pareto-optimal method: no other one has both errors smaller."
            @if optimum.is_some() {
                " The line is what the bones alone allow, without any dynamics: the pose of this figure that is nearest to the \
                 clip’s, where a turn of 1 rad counts as much as a distance of " (most_m) " m (left) to " (least_m) " m (right)."
            }
        }
        @if let Some(optimum) = optimum {
            p class="small" {
                "Nearest is meant in squares, over all bodies: the mean of a method may be a little below the line, and that with the \
                 root’s position held below that with it free."
                @if optimum.every > 1 { " Of the line, one in " (optimum.every) " frames was sought." }
                @if optimum.unsolved > 0 { " " (optimum.unsolved) " searches were given up before their end." }
            }
        }
    }
}
