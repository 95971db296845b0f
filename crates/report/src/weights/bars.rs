//! Draws a row per joint and a bar per method, on one logarithmic scale.

use maud::{Markup, html};
use sinew_pose_metrics::character::Character;
use sinew_pose_metrics::weights::Weighing;

use super::caption::class;
use crate::chart::{Axis, px};

/// Minimum and maximum height of rows: names remain readable, and a few joints do not fill a page.
const ROWS: [f64; 2] = [13.5, 24.0];

/// Width of a method's bars. The next constant is the width of the numbers after them.
const COLUMN: f64 = 150.0;
const NUMBER: f64 = 46.0;

/// Indentation of a joint's name per level of depth.
const INDENT: f64 = 5.0;

/// Width of a letter of a name.
const LETTER: f64 = 6.4;

/// Height of the heading. The next constant is the height of the space below the bars.
const TOP: f64 = 26.0;
const BOTTOM: f64 = 30.0;

/// Values on the scale, with their labels.
const POWERS: [(f64, &str); 7] = [
    (1.0, "1"),
    (1e-1, "10⁻¹"),
    (1e-2, "10⁻²"),
    (1e-3, "10⁻³"),
    (1e-4, "10⁻⁴"),
    (1e-5, "10⁻⁵"),
    (1e-6, "10⁻⁶"),
];

pub(super) struct Bars<'a> {
    character: &'a Character,
    weighings: &'a [Weighing],
    depths: Vec<f64>,
    row: f64,
    /// Width of the names.
    names: f64,
    axis: Axis,
    /// Lower end of the scale: a power of ten.
    low: f64,
}

impl<'a> Bars<'a> {
    /// Creates bars with this total height, limited by the maximum height of rows.
    pub(super) fn new(character: &'a Character, weighings: &'a [Weighing], height: f64) -> Self {
        let joints = character.joints();
        let depth = |joint: usize| {
            std::iter::successors(joints[joint].parent, |parent| joints[*parent].parent).count()
        };
        let depths: Vec<f64> = (0..joints.len()).map(|joint| depth(joint) as f64).collect();
        let width = |(joint, depth): (&sinew_pose_metrics::character::Joint, &f64)| {
            LETTER * joint.name.chars().count() as f64 + INDENT * depth
        };
        let names = joints.iter().zip(&depths).map(width).fold(0.0, f64::max) + 16.0;
        let [least, most] = ROWS;
        let row = ((height - TOP - BOTTOM) / joints.len() as f64).clamp(least, most);
        let above_zero = weighings.iter().flat_map(|w| &w.weights).copied().filter(|w| *w > 0.0);
        let smallest = above_zero.fold(1.0, f64::min);
        let (low, _) =
            POWERS[1..].iter().find(|(power, _)| *power <= smallest).unwrap_or(&POWERS[6]);
        let low = *low;
        let axis = Axis::logarithmic([low, 1.0], [0.0, COLUMN - NUMBER]);
        Self { character, weighings, depths, row, names, axis, low }
    }

    pub(super) fn width(&self) -> f64 {
        self.names + COLUMN * self.weighings.len() as f64 + 10.0
    }

    pub(super) fn height(&self) -> f64 {
        TOP + self.row * self.depths.len() as f64 + BOTTOM
    }

    pub(super) fn draw(&self) -> Markup {
        let bottom = self.height() - BOTTOM;
        let joints = self.character.joints();
        html! {
            @for (index, (joint, depth)) in joints.iter().zip(&self.depths).enumerate() {
                @let y = TOP + self.row * index as f64;
                @if index.is_multiple_of(2) {
                    rect class="band" x="0" y=(px(y)) width=(px(self.width() - 10.0)) height=(px(self.row)) {}
                }
                text class="fine" x=(px(6.0 + INDENT * depth)) y=(px(y + 0.5 * self.row + 3.6)) { (joint.name) }
            }
            @for (index, weighing) in self.weighings.iter().enumerate() {
                g class=(class(weighing.method)) transform={ "translate(" (px(self.names + COLUMN * index as f64)) " 0)" } {
                    text class="heading" x="0" y="14" { (weighing.method) }
                    (self.axis(bottom))
                    @for (joint, weight) in weighing.weights.iter().enumerate() {
                        @let y = TOP + self.row * (joint as f64 + 0.5);
                        @let end = self.axis.at(*weight);
                        rect class="weight" x="0" y=(px(y - 0.34 * self.row)) width=(px(end)) height=(px(0.68 * self.row)) {}
                        text class="fine" x=(px(COLUMN - 10.0)) y=(px(y + 3.6)) text-anchor="end" { (number(*weight)) }
                    }
                }
            }
        }
    }

    /// Draws the grid lines and labels of the powers of ten.
    fn axis(&self, bottom: f64) -> Markup {
        html! {
            @for (value, label) in POWERS.iter().filter(|(value, _)| *value >= self.low) {
                @let x = px(self.axis.at(*value));
                line class="grid" x1=(x) x2=(x) y1=(px(TOP)) y2=(px(bottom)) {}
                text class="fine muted" x=(x) y=(px(bottom + 13.0)) text-anchor="middle" { (label) }
            }
        }
    }
}

/// Formats a number with three digits.
fn number(weight: f64) -> String {
    let exponent = if weight > 0.0 { libm::floor(libm::log10(weight)) } else { 0.0 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "2 to 6")]
    let decimals = (2.0 - exponent).clamp(2.0, 6.0) as usize;
    format!("{weight:.decimals$}")
}
