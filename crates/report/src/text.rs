//! The wording of the report. The paper's figure follows clips and is compared with the paper's results; a rig
//! follows motions of its own joints.

use maud::{Markup, html};
use sinew_evaluation::paper;
use sinew_evaluation::{Evaluation, FigureResult, MethodName};

/// The wording for an evaluation of the figure or of a rig.
#[derive(Debug, Clone, Copy)]
pub(super) struct Words<'a> {
    rig: Option<&'a str>,
}

impl<'a> Words<'a> {
    pub(super) fn of(evaluation: &'a Evaluation) -> Self {
        Self { rig: evaluation.rig.as_deref() }
    }

    /// Returns the first value for the figure, the second for a rig.
    pub(super) fn either<T>(self, of_figure: T, of_rig: T) -> T {
        if self.rig.is_none() { of_figure } else { of_rig }
    }

    /// Returns the word for the followed motion.
    pub(super) fn clip(self) -> &'static str {
        self.either("clip", "motion")
    }

    /// Returns the word for the followed motion, capitalized.
    pub(super) fn clip_title(self) -> &'static str {
        self.either("Clip", "Motion")
    }

    /// Returns the word for the figure or rig.
    pub(super) fn figure(self) -> &'static str {
        self.either("figure", "rig")
    }

    /// Returns the title of the page in a browser.
    pub(super) fn title(self, summary: &str) -> String {
        match self.rig {
            None => format!("Sinew evaluation: {summary}"),
            Some(rig) => format!("Sinew evaluation of {rig}: {summary}"),
        }
    }

    /// Returns additional styles of the page.
    pub(super) fn style(self) -> &'static str {
        self.either("", include_str!("assets/rig.css"))
    }

    /// Returns the first heading.
    pub(super) fn heading(self) -> Markup {
        html! {
            @match self.rig {
                None => "How closely a simulated figure follows a performance",
                Some(rig) => { "How closely rig " (rig) " follows its motions" }
            }
        }
    }

    /// Returns the introductory sentence about the evaluation.
    pub(super) fn lede(self, summary: &str, methods: usize) -> Markup {
        html! {
            (summary) ", tracked by a simulated " (self.figure()) " with "
            (methods)
            (if methods == 1 { " way" } else { " ways" }) " of measuring state error"
            @if self.rig.is_none() {
                ", and compared with Notman, Carlisle & Manning, "
                cite { "Methods for Measuring State Error for Control of Animated Human Figures" } " (2011)"
            }
            "."
        }
    }

    /// Returns the heading of the tables, and their name in the navigation.
    pub(super) fn tables(self) -> [&'static str; 2] {
        self.either(["Tables 1 to 4", "Tables 1–4"], ["Results", "Results"])
    }

    /// Returns a description of the figure of a scale.
    pub(super) fn subject(self, scale: f64) -> String {
        match self.rig {
            Some(rig) => format!("Rig {rig}"),
            None if (scale - 1.0).abs() < 1e-9 => "Figure of the clip’s dimensions".into(),
            None => format!("Figure of {scale} times the clip’s dimensions"),
        }
    }

    /// Returns a description of the figure of a scale, for use after a clip or a motion.
    pub(super) fn follower(self, scale: f64) -> String {
        match self.rig {
            Some(rig) => format!("rig {rig}"),
            None => format!("a figure of {scale} times its dimensions"),
        }
    }

    /// Returns the paper's numbers for a figure, if the evaluation uses the paper's figure and the paper has this
    /// scale.
    pub(super) fn published(self, figure: &FigureResult) -> Option<&'static paper::Figure> {
        self.rig.map_or_else(|| paper::Figure::of_scale(figure.scale), |_| None)
    }

    /// Returns an explanation of the errors.
    pub(super) fn errors(self) -> &'static str {
        self.either(
            "Every step, every body, in the world, against the clip in its own dimensions: the angle between desired and \
             actual rotation, the distance between desired and actual joint. Leaf joints are head, hands and feet.",
            "Every step, every body, in the world, against the motion: the angle between desired and actual rotation, the \
             distance between desired and actual joint. Leaf joints are those of the bodies that no joint hangs on.",
        )
    }

    /// Returns an explanation of a method.
    pub(super) fn explanation(self, method: MethodName) -> &'static str {
        match method {
            MethodName::Local => "Every body is compared with its goal in its parent's frame.",
            MethodName::World => "Every body is compared with its goal in the world.",
            MethodName::Egocentric => self.either(
                "Every body is compared with its goal in the pelvis’s frame.",
                "Every body is compared with its goal in the first body’s frame.",
            ),
            MethodName::Accumulated => {
                "Bodies beyond a chosen body are compared with their goals in that body’s frame, all others in the \
                 world."
            }
            MethodName::LinearCompensation => self.either(
                "As World, but a body’s goal is turned so that its child comes nearest to where the clip has it. That costs angle \
                 and gains distance, above all on figures of other dimensions.",
                "As World, but a body’s goal is turned so that its child comes nearest to where the motion has it. That costs \
                 angle and gains distance.",
            ),
            MethodName::ManifoldProjection => self.either(
                "As World, but the goal is the figure’s own pose that is nearest to the clip’s: all joints share the \
                 bending. With equal dimensions it equals World.",
                "As World, but the goal is the rig’s own pose that is nearest to the motion’s. The motions of this \
                 page consist of such poses, so this method equals World.",
            ),
            MethodName::ResolvedAcceleration => {
                "All joints together get the accelerations by which the errors of all bodies in the world follow one \
                 law."
            }
            MethodName::Recommended => {
                "Manifold Projection on targets aligned with the motion, with an observer that filters the sensors, \
                 predicts over a known delay, and cancels errors of the model."
            }
        }
    }
}
