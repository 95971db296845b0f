//! A stage with two mannequins: the desired and the actual positions of the bodies.

use core::ops::Range;

use glam::DVec3;
use maud::{Markup, html};

use super::camera::{Camera, Projected};
use super::ground::Ground;
use super::mannequin::{MEASURED_GIRTH, Mannequin};
use super::outline::capsule;
use crate::chart::px;
use crate::labels::{self, Circle, Label, Rectangle};

pub const STAGE_WIDTH: f64 = 480.0;
pub const STAGE_HEIGHT: f64 = 500.0;

/// Region for labels: away from the edges, and below the title.
const LABELS: labels::Ground = labels::Ground {
    bounds: Rectangle {
        left: 10.0,
        top: 62.0,
        right: STAGE_WIDTH - 10.0,
        bottom: STAGE_HEIGHT - 10.0,
    },
    letter: 8.0,
    line: 20.0,
    below: 5.5,
    gap: 5.0,
};

/// Two figures in one picture with one camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage<'a> {
    /// Prefix of the picture's identifiers, which must be unique on a page.
    pub id: &'a str,
    /// Camera of the picture.
    pub camera: Camera,
    /// Ground around the camera's target.
    pub ground: Ground,
    /// Desired positions of the bodies: a mannequin and its points.
    pub desired: (&'a Mannequin, &'a [DVec3]),
    /// Actual positions of the bodies: a mannequin with the same parts, and its points.
    pub measured: (&'a Mannequin, &'a [DVec3]),
}

/// A part in the picture.
pub(super) struct Drawn {
    pub(super) ends: [Circle; 2],
    pub(super) depth_m: f64,
}

impl Stage<'_> {
    /// Draws stage, shadows and figures, as the content of an SVG.
    pub fn draw(&self) -> Markup {
        let (desired, measured) = self.figures();
        let groups = self.order(&desired, &measured);
        html! {
            (self.backdrop())
            path class="shadow" d=(self.shadow(self.desired, 1.0)) {}
            path class="shadow" d=(self.shadow(self.measured, MEASURED_GIRTH)) {}
            @for group in groups {
                @for part in group.clone() { (self.part("desired", WHITE, part, &desired[part])) }
                @for part in group { (self.part("measured", RED, part, &measured[part])) }
            }
        }
    }

    /// Draws stage, shadow and only the desired figure. `shades` are its colours from the lit side to the dark
    /// side.
    pub fn draw_desired(&self, shades: [&str; 3]) -> Markup {
        let parts = self.parts(self.desired, 1.0);
        html! {
            (self.backdrop())
            path class="shadow" d=(self.shadow(self.desired, 1.0)) {}
            @for part in self.order(&parts, &parts).into_iter().flatten() {
                (self.part("desired", shades, part, &parts[part]))
            }
        }
    }

    /// Returns the parts of both figures.
    pub(super) fn figures(&self) -> (Vec<Drawn>, Vec<Drawn>) {
        (self.parts(self.desired, 1.0), self.parts(self.measured, MEASURED_GIRTH))
    }

    /// Returns groups of parts from the farthest to the nearest. Corresponding parts of the two figures are in one
    /// group, which keeps the figures from hiding each other by accident.
    pub(super) fn order(&self, desired: &[Drawn], measured: &[Drawn]) -> Vec<Range<usize>> {
        let trunk = self.desired.0.trunk();
        let others = (trunk..desired.len()).map(|part| part..part + 1);
        let mut groups: Vec<Range<usize>> =
            (trunk > 0).then_some(0..trunk).into_iter().chain(others).collect();
        let depth_m = |group: &Range<usize>| {
            let both = desired[group.clone()].iter().chain(&measured[group.clone()]);
            both.map(|part| part.depth_m).sum::<f64>() / group.len() as f64
        };
        groups.sort_by(|a, b| depth_m(b).total_cmp(&depth_m(a)));
        groups
    }

    /// Draws the stage without figures.
    pub(crate) fn backdrop(&self) -> Markup {
        let clip = format!("{}-stage", self.id);
        html! {
            clipPath id=(clip) {
                rect width=(px(STAGE_WIDTH)) height=(px(STAGE_HEIGHT)) rx="10" {}
            }
            rect class="stage" width=(px(STAGE_WIDTH)) height=(px(STAGE_HEIGHT)) rx="10" {}
            g clip-path={ "url(#" (clip) ")" } { (self.ground.draw(&self.camera)) }
        }
    }

    /// Returns the position of a point in the picture.
    pub(crate) fn place(&self, point_m: DVec3) -> (f64, f64) {
        let Projected { x, y, .. } = self.camera.project(point_m);
        (x, y)
    }

    /// Returns positions for texts near the points that they name in the picture.
    pub(crate) fn labels(&self, texts: Vec<(String, (f64, f64))>) -> Vec<Label> {
        labels::place(texts, &self.drawn(), &LABELS)
    }

    /// Returns circles that cover both figures.
    fn drawn(&self) -> Vec<Circle> {
        let (desired, measured) = self.figures();
        let along = |part: &Drawn| {
            let [a, b] = part.ends;
            [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(|share| Circle {
                x: a.x + share * (b.x - a.x),
                y: a.y + share * (b.y - a.y),
                r: a.r + share * (b.r - a.r),
            })
        };
        desired.iter().chain(&measured).flat_map(along).collect()
    }

    fn parts(&self, (mannequin, points): (&Mannequin, &[DVec3]), thinner: f64) -> Vec<Drawn> {
        let girth = mannequin.girth() * thinner;
        let circle = |point_m: DVec3, radius_m: f64| {
            let seen = self.camera.project(point_m);
            (Circle { x: seen.x, y: seen.y, r: radius_m * girth * seen.scale }, seen.depth_m)
        };
        mannequin
            .parts()
            .iter()
            .map(|(a, b, from, to, r_from, r_to)| {
                let (start, near) = circle(points[*a].lerp(points[*b], *from), *r_from);
                let (end, far) = circle(points[*a].lerp(points[*b], *to), *r_to);
                Drawn { ends: [start, end], depth_m: 0.5 * (near + far) }
            })
            .collect()
    }

    /// Draws a part, lit from the upper left across its axis.
    fn part(&self, figure: &str, shades: [&str; 3], part: usize, drawn: &Drawn) -> Markup {
        let [a, b] = drawn.ends;
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let length = libm::sqrt(dx * dx + dy * dy).max(1e-6);
        let (nx, ny) = (dy / length, -dx / length);
        // The side of the light; for a part that points at the viewer, the light's own direction.
        let [light_x, light_y] = LIGHT;
        let towards_light = light_x * nx + light_y * ny;
        let (nx, ny) = if length < 0.5 * a.r.max(b.r) {
            (light_x, light_y)
        } else if towards_light < 0.0 {
            (-nx, -ny)
        } else {
            (nx, ny)
        };
        let (x, y, r) = (0.5 * (a.x + b.x), 0.5 * (a.y + b.y), a.r.max(b.r));
        let id = format!("{}-{figure}-{part}", self.id);
        html! {
            linearGradient id=(id) gradientUnits="userSpaceOnUse"
                x1=(px(x + nx * r)) y1=(px(y + ny * r)) x2=(px(x - nx * r)) y2=(px(y - ny * r)) {
                @for (offset, color) in ["0", "0.5", "1"].into_iter().zip(shades) {
                    stop offset=(offset) stop-color=(color) {}
                }
            }
            path class={ "part " (figure) } fill={ "url(#" (id) ")" } d=(capsule(a, b)) {}
        }
    }

    /// Returns the figure's shadow under a light from directly above. It is one path, to avoid darker areas where
    /// parts overlap.
    pub(super) fn shadow(
        &self,
        (mannequin, points): (&Mannequin, &[DVec3]),
        thinner: f64,
    ) -> String {
        let girth = mannequin.girth() * thinner;
        let below = |point_m: DVec3, radius_m: f64| {
            let seen = self.camera.project(DVec3::new(point_m.x, self.ground.height_m, point_m.z));
            Circle { x: seen.x, y: seen.y, r: radius_m * girth * seen.scale * 0.55 }
        };
        mannequin
            .parts()
            .iter()
            .map(|(a, b, from, to, r_from, r_to)| {
                capsule(
                    below(points[*a].lerp(points[*b], *from), *r_from),
                    below(points[*a].lerp(points[*b], *to), *r_to),
                )
            })
            .collect()
    }
}

/// Direction to the light in the picture, y down: up and a little to the left.
pub(super) const LIGHT: [f64; 2] = [-0.45, -0.89];

/// Colours from the lit side to the dark side.
pub const WHITE: [&str; 3] = ["#ffffff", "#e4e8ee", "#98a2b0"];
pub(crate) const RED: [&str; 3] = ["#ff7b68", "#d8301e", "#7e120a"];
