//! A stage with two figures on it: where the bodies should be, and where they are.

use core::f64::consts::PI;
use core::ops::Range;

use glam::DVec3;
use maud::{Markup, html};

use super::camera::{Camera, Projected};
use super::mannequin::{MEASURED_GIRTH, PARTS, Points, TRUNK};
use super::outline::capsule;
use crate::report::chart::{line, px};
use crate::report::labels::{self, Circle, Ground, Label, Rectangle};

pub const STAGE_WIDTH: f64 = 480.0;
pub const STAGE_HEIGHT: f64 = 500.0;

/// Labels stay off the edges, and below the title.
const LABELS: Ground = Ground {
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

/// Radius of the ground, in metres.
const GROUND_M: f64 = 1.6;

/// Figures in one picture, seen by one camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage<'a> {
    /// A word that begins the picture's identifiers: no two pictures of a page may share it.
    pub id: &'a str,
    /// The camera.
    pub camera: Camera,
    /// Height of the ground.
    pub ground_m: f64,
    /// Where the bodies should be, and the girth of that figure.
    pub desired: (&'a Points, f64),
    /// Where they are, and the girth of that figure.
    pub measured: (&'a Points, f64),
}

/// A part in the picture.
pub(super) struct Drawn {
    pub(super) ends: [Circle; 2],
    pub(super) depth_m: f64,
}

impl Stage<'_> {
    /// Stage, shadows and figures, as the content of an SVG.
    pub fn draw(&self) -> Markup {
        let (desired, measured) = self.figures();
        let groups = Self::order(&desired, &measured);
        html! {
            (self.backdrop())
            path class="shadow" d=(self.shadow(self.desired.0, self.desired.1)) {}
            path class="shadow" d=(self.shadow(self.measured.0, self.measured.1 * MEASURED_GIRTH)) {}
            @for group in groups {
                @for part in group.clone() { (self.part("desired", WHITE, part, &desired[part])) }
                @for part in group { (self.part("measured", RED, part, &measured[part])) }
            }
        }
    }

    /// Stage, shadow and the desired figure alone, from the lit side to the dark one in these colours.
    pub fn draw_desired(&self, shades: [&str; 3]) -> Markup {
        let parts = self.parts(self.desired.0, self.desired.1);
        let mut order: Vec<usize> = (TRUNK..PARTS.len()).collect();
        let trunk_m = parts[..TRUNK].iter().map(|part| part.depth_m).sum::<f64>() / TRUNK as f64;
        order.sort_by(|a, b| parts[*b].depth_m.total_cmp(&parts[*a].depth_m));
        let behind = order.partition_point(|part| parts[*part].depth_m > trunk_m);
        order.splice(behind..behind, 0..TRUNK);
        html! {
            (self.backdrop())
            path class="shadow" d=(self.shadow(self.desired.0, self.desired.1)) {}
            @for part in order { (self.part("desired", shades, part, &parts[part])) }
        }
    }

    /// The parts of both figures.
    pub(super) fn figures(&self) -> (Vec<Drawn>, Vec<Drawn>) {
        (
            self.parts(self.desired.0, self.desired.1),
            self.parts(self.measured.0, self.measured.1 * MEASURED_GIRTH),
        )
    }

    /// Parts from the farthest to the nearest. A part of one figure stays with that of the other, so that the two
    /// never hide each other by accident.
    pub(super) fn order(desired: &[Drawn], measured: &[Drawn]) -> Vec<Range<usize>> {
        let others = (TRUNK..PARTS.len()).map(|part| part..part + 1);
        let mut groups: Vec<Range<usize>> = std::iter::once(0..TRUNK).chain(others).collect();
        let depth_m = |group: &Range<usize>| {
            let both = desired[group.clone()].iter().chain(&measured[group.clone()]);
            both.map(|part| part.depth_m).sum::<f64>() / group.len() as f64
        };
        groups.sort_by(|a, b| depth_m(b).total_cmp(&depth_m(a)));
        groups
    }

    /// The stage without anyone on it.
    pub(in crate::report) fn backdrop(&self) -> Markup {
        let clip = format!("{}-stage", self.id);
        html! {
            clipPath id=(clip) {
                rect width=(px(STAGE_WIDTH)) height=(px(STAGE_HEIGHT)) rx="10" {}
            }
            rect class="stage" width=(px(STAGE_WIDTH)) height=(px(STAGE_HEIGHT)) rx="10" {}
            g clip-path={ "url(#" (clip) ")" } { (self.ground()) }
        }
    }

    /// Place of a point in the picture.
    pub(in crate::report) fn place(&self, point_m: DVec3) -> (f64, f64) {
        let Projected { x, y, .. } = self.camera.project(point_m);
        (x, y)
    }

    /// Places for texts beside what they name in the picture.
    pub(in crate::report) fn labels(&self, texts: Vec<(String, (f64, f64))>) -> Vec<Label> {
        labels::place(texts, &self.drawn(), &LABELS)
    }

    /// Circles that cover both figures.
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

    fn parts(&self, points: &Points, girth: f64) -> Vec<Drawn> {
        let circle = |point_m: DVec3, radius_m: f64| {
            let seen = self.camera.project(point_m);
            (Circle { x: seen.x, y: seen.y, r: radius_m * girth * seen.scale }, seen.depth_m)
        };
        PARTS
            .iter()
            .map(|(a, b, from, to, r_from, r_to)| {
                let (start, near) = circle(points[*a].lerp(points[*b], *from), *r_from);
                let (end, far) = circle(points[*a].lerp(points[*b], *to), *r_to);
                Drawn { ends: [start, end], depth_m: 0.5 * (near + far) }
            })
            .collect()
    }

    /// A part with the light from above left, across its axis.
    fn part(&self, figure: &str, shades: [&str; 3], part: usize, drawn: &Drawn) -> Markup {
        let [a, b] = drawn.ends;
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let length = libm::sqrt(dx * dx + dy * dy).max(1e-6);
        let (nx, ny) = (dy / length, -dx / length);
        // The side that the light comes from; from a part that points at it, the middle of both.
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

    fn ground(&self) -> Markup {
        let center = DVec3::new(self.camera.target_m.x, self.ground_m, self.camera.target_m.z);
        let rim = (0..48).map(|index| {
            let (sin, cos) = libm::sincos(f64::from(index) * PI / 24.0);
            self.place(center + DVec3::new(sin, 0.0, cos) * GROUND_M)
        });
        let mut lines = String::new();
        // The grid stays where it is in the world: half metres.
        for step in -4..=4 {
            for across in [DVec3::X, DVec3::Z] {
                let along = DVec3::new(across.z, 0.0, across.x);
                let middle = libm::round(center.dot(across) * 2.0) * 0.5 + f64::from(step) * 0.5;
                let off = middle - center.dot(across);
                if off.abs() >= GROUND_M {
                    continue;
                }
                let half = libm::sqrt(GROUND_M * GROUND_M - off * off);
                let at = |way: f64| self.place(center + across * off + along * (half * way));
                lines += &line([at(-1.0), at(1.0)]);
            }
        }
        html! {
            path class="ground" d={ (line(rim)) "Z" } {}
            path class="ground-line" d=(lines) {}
        }
    }

    /// The figure's shadow under a light from straight above, as one path: where parts overlap it is not
    /// darker.
    pub(super) fn shadow(&self, points: &Points, girth: f64) -> String {
        let below = |point_m: DVec3, radius_m: f64| {
            let seen = self.camera.project(DVec3::new(point_m.x, self.ground_m, point_m.z));
            Circle { x: seen.x, y: seen.y, r: radius_m * girth * seen.scale * 0.55 }
        };
        PARTS
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

/// Towards the light in the picture, y down: above, a little to the left.
pub(super) const LIGHT: [f64; 2] = [-0.45, -0.89];

/// From the lit side to the dark one.
pub const WHITE: [&str; 3] = ["#ffffff", "#e4e8ee", "#98a2b0"];
pub(in crate::report) const RED: [&str; 3] = ["#ff7b68", "#d8301e", "#7e120a"];
