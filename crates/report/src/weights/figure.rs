//! Draws a character at rest with a disc at each joint.

use std::fmt::Write as _;

use glam::{DVec2, DVec3};
use maud::{Markup, html};
use sinew_pose_metrics::character::{Character, Mesh};
use sinew_pose_metrics::weights::Weighing;

use super::caption::{caption, class};
use crate::chart::{line, px};

/// Radius of the largest disc.
const LARGEST: f64 = 34.0;

/// Free width around the figure, since the largest disc may be at its edge.
const MARGIN: f64 = LARGEST;

/// Height of the caption.
const CAPTION: f64 = 26.0;

/// Minimum and maximum width of a figure.
const WIDTHS: [f64; 2] = [240.0, 420.0];

/// A horizontal view of the character from the side on which it is wider, without perspective.
pub(super) struct View<'a> {
    character: &'a Character,
    /// Positions of the joints in the picture.
    joints: Vec<DVec2>,
    /// Path of the skin.
    skin: String,
    width: f64,
}

impl<'a> View<'a> {
    /// Creates a view of this height.
    pub(super) fn new(character: &'a Character, height: f64) -> Self {
        let joints = character.joints().iter().map(|joint| joint.position_m);
        let vertices =
            character.mesh().into_iter().flat_map(|mesh| mesh.positions_m.iter().copied());
        let (low_m, high_m) = joints
            .clone()
            .chain(vertices)
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                (low.min(p), high.max(p))
            });
        let size_m = high_m - low_m;
        // From the front, or from the character's left.
        let right = if size_m.z > size_m.x { DVec3::NEG_Z } else { DVec3::X };
        let across_m = size_m.dot(right).abs();
        let [least, most] = WIDTHS;
        let free = height - CAPTION - 2.0 * MARGIN;
        let scale = ((most - 2.0 * MARGIN) / across_m).min(free / size_m.y).min(1e9);
        let width = (scale * across_m + 2.0 * MARGIN).max(least);
        let middle_m = 0.5 * (low_m + high_m);
        let place = |position_m: DVec3| {
            let from_middle_m = position_m - middle_m;
            let across = from_middle_m.dot(right) * scale;
            DVec2::new(0.5 * width + across, 0.5 * (height + CAPTION) - from_middle_m.y * scale)
        };
        let skin = character.mesh().map_or_else(String::new, |mesh| skin(mesh, place));
        Self { character, joints: joints.map(place).collect(), skin, width }
    }

    pub(super) fn width(&self) -> f64 {
        self.width
    }

    /// Defines the skin once for all figures.
    pub(super) fn definitions(&self) -> Markup {
        html! { defs { path id="skin" class="skin" d=(self.skin) {} } }
    }

    /// Draws skin, bones and discs. The area of a disc is proportional to its weight; `largest` is the weight of
    /// the largest disc.
    pub(super) fn draw(&self, weighing: &Weighing, largest: f64) -> Markup {
        let mut order: Vec<usize> = (0..self.joints.len()).collect();
        order.sort_by(|a, b| weighing.weights[*b].total_cmp(&weighing.weights[*a]));
        let bones = self.character.joints().iter().zip(&self.joints);
        let bones: String = bones
            .filter_map(|(joint, to)| Some([self.joints[joint.parent?], *to]))
            .map(|ends| line(ends.map(|end| (end.x, end.y))))
            .collect();
        html! {
            use href="#skin" {} path class="bone" d=(bones) {} g class=(class(weighing.method)) {@for joint in order {@let radius = LARGEST * libm::sqrt(weighing.weights[joint] / largest);
                    circle class="disc" cx=(px(self.joints[joint].x)) cy=(px(self.joints[joint].y)) r=(px(radius)) {
                        title { (self.character.joints()[joint].name) }
                    }
                }
            }
            text class="tick" x="10" y="22" { (caption(weighing.method)) }
        }
    }
}

/// Returns the triangles that face the viewer, as one path.
fn skin(mesh: &Mesh, place: impl Fn(DVec3) -> DVec2) -> String {
    let places: Vec<DVec2> = mesh.positions_m.iter().map(|p| place(*p)).collect();
    let mut path = String::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| places[vertex]);
        // y points down: a left turn in space is a right turn in the picture.
        if (b - a).perp_dot(c - a) < 0.0 {
            let ends = [a, b, c].map(|end| (end.x, end.y));
            write!(path, "{}Z", line(ends)).expect("a string takes everything");
        }
    }
    path
}
