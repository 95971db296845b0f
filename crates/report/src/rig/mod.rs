//! A page about a rig: a 3D view, sliders that move it, and its loads in colour. The page is a single file and
//! needs no network.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::Serialize;
use sinew_rig::description::{BodyShape, ShapeKind};
use sinew_rig::mechanism::{JointModel, Link, Mechanism};
use sinew_rig::review::{DofReview, Review};

use super::head::head;
use super::palette;

const SCRIPT: &str = concat!(
    include_str!("assets/kinematics.js"),
    include_str!("assets/shapes.js"),
    include_str!("assets/stage.js"),
    include_str!("assets/data.js"),
    include_str!("assets/gravity.js"),
    include_str!("assets/view.js")
);
const STYLE: &str = include_str!("assets/view.css");

/// The renderer of rigs as an ES module, for pages that are served: it exports `kinematicsOf`, `stageOn` and `shade`.
pub const RENDERER: &str = concat!(
    include_str!("assets/kinematics.js"),
    include_str!("assets/shapes.js"),
    include_str!("assets/stage.js"),
    include_str!("assets/module.js")
);

/// Data for the page's script.
#[derive(Debug, Serialize)]
struct Data<'a> {
    bodies: Vec<Body<'a>>,
    dofs: Vec<DofData<'a>>,
}

/// A body in the form of `kinematics.js`.
#[derive(Debug, Serialize)]
pub struct Body<'a> {
    name: &'a str,
    parent: Option<usize>,
    kind: &'static str,
    axes: Vec<[f64; 3]>,
    position_m: [f64; 3],
    rotation_xyzw: [f64; 4],
    mass_kg: f64,
    center_m: [f64; 3],
    tips_m: Vec<[f64; 3]>,
    home: &'a [f64],
    shapes: Vec<Shape>,
}

/// A solid in the form of `shapes.js`, in the body's frame.
#[derive(Debug, Serialize)]
struct Shape {
    kind: &'static str,
    size: Option<[f64; 3]>,
    radius: Option<f64>,
    length: Option<f64>,
    position: [f64; 3],
    rotation: [f64; 4],
    color: Option<[f64; 3]>,
}

impl Shape {
    fn of(shape: &BodyShape) -> Self {
        let kind = match shape.kind {
            ShapeKind::Box => "box",
            ShapeKind::Sphere => "sphere",
            ShapeKind::Cylinder => "cylinder",
            ShapeKind::Capsule => "capsule",
        };
        Self {
            kind,
            size: shape.size_m,
            radius: shape.radius_m,
            length: shape.length_m,
            position: shape.position_m,
            rotation: shape.rotation_xyzw,
            color: shape.color_rgb,
        }
    }
}

/// A slider for a dof.
#[derive(Debug, Serialize)]
struct DofData<'a> {
    body: usize,
    axis: usize,
    name: &'a str,
    slides: bool,
    range: [f64; 2],
    limited: bool,
    home: f64,
    /// Continuous capacity, or else the limit in the file; `None` if neither is known.
    capacity: Option<f64>,
    worst: &'a [f64],
}

/// Returns the page of a rig.
pub fn page(name: &str, mechanism: &Mechanism, review: &Review) -> String {
    let data = serde_json::to_string(&data(mechanism, review)).expect("numbers and names only");
    markup(name, mechanism, review, &data.replace("</", "<\\/")).into_string()
}

fn markup(name: &str, mechanism: &Mechanism, review: &Review, data: &str) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            (head(&format!("{name} · Sinew rig"), &(palette::page() + STYLE)))
            body {
                a class="skip" href="#joints" { "Skip to the joints" }
                header class="rig" {
                    p class="eyebrow" { "Sinew " (env!("CARGO_PKG_VERSION")) " · rig" }
                    h1 { (name) }
                    p { (summary(mechanism, review)) }
                }
                main class="rig" {
                    section class="stage" aria-label="The rig in 3D" {
                        canvas id="stage" tabindex="0" role="img"
                            aria-label="The rig. Arrow keys turn the view, plus and minus zoom." {}
                        p class="hint" { "Drag or arrow keys: turn the view. Wheel or + and −: zoom." }
                        div class="buttons" {
                            button id="move" type="button" aria-pressed="false" { "Move the joints" }
                            button id="home" type="button" { "Home pose" }
                            button id="zero" type="button" { "Zero pose" }
                        }
                        p class="legend-of-loads" {
                            span class="swatch low" {} " light "
                            span class="swatch mid" {} " half of what it holds "
                            span class="swatch high" {} " more than it holds for long"
                        }
                    }
                    section id="joints" aria-label="Joints" {
                        h2 { "Joints" }
                        p class="hint" { "Load: the effort of the joint against gravity in this pose." }
                        ol id="sliders" {}
                    }
                    section class="findings" aria-label="Findings" {
                        h2 { "What the check found" }
                        ul {
                            @for finding in &review.findings {
                                li { strong { (finding.about) } ": " (finding.text) }
                            }
                        }
                    }
                }
                noscript { p { "The rig needs JavaScript to be drawn; nothing is fetched." } }
                script type="application/json" id="rig-data" { (PreEscaped(data)) }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

fn summary(mechanism: &Mechanism, review: &Review) -> String {
    let base = match mechanism.bodies.first().map(|base| base.joint) {
        Some(JointModel::Free) => "a driven base",
        _ => "a fixed base",
    };
    format!(
        "{} bodies, {} degrees of freedom, {:.3} kg, on {base}.",
        review.bodies, review.dofs, review.mass_kg
    )
}

/// Returns the bodies of a rig in the form of `kinematics.js`.
pub fn bodies<'a>(mechanism: &'a Mechanism) -> Vec<Body<'a>> {
    let body = |link: &'a Link| {
        let (kind, axes) = kind(link.joint);
        Body {
            name: &link.name,
            parent: link.parent,
            kind,
            axes,
            position_m: link.position_m.to_array(),
            rotation_xyzw: link.rotation.to_array(),
            mass_kg: link.mass_kg,
            center_m: link.center_of_mass_m.to_array(),
            tips_m: link.merged.iter().map(|part| part.position_m.to_array()).collect(),
            home: &link.home,
            shapes: link.shapes.iter().map(Shape::of).collect(),
        }
    };
    mechanism.bodies.iter().map(body).collect()
}

fn data<'a>(mechanism: &'a Mechanism, review: &'a Review) -> Data<'a> {
    let mut reviews = review.by_dof.iter();
    let mut dofs = Vec::new();
    for (body, link) in mechanism.bodies.iter().enumerate() {
        for axis in 0..link.joint.kind().dof_count() {
            let Some(review) = reviews.next() else { continue };
            // The drive of the base is not a joint of the rig.
            if link.joint != JointModel::Free {
                dofs.push(dof(link, body, axis, review));
            }
        }
    }
    Data { bodies: bodies(mechanism), dofs }
}

fn dof<'a>(link: &'a Link, body: usize, axis: usize, review: &'a DofReview) -> DofData<'a> {
    let ball = link.joint == JointModel::Spherical;
    // A ball joint has one limit for all directions.
    let given = link.ranges.get(if ball { 0 } else { axis }).copied();
    let range = match given {
        Some([_, most]) if ball => Some([-most, most]),
        given => given,
    };
    let any =
        if review.slides { [-0.1, 0.1] } else { [-std::f64::consts::PI, std::f64::consts::PI] };
    DofData {
        body,
        axis,
        name: &review.name,
        slides: review.slides,
        range: range.unwrap_or(any),
        limited: range.is_some(),
        home: if ball { 0.0 } else { link.home.get(axis).copied().unwrap_or(0.0) },
        capacity: review.servo.as_ref().map(|servo| servo.continuous).or(review.effort_limit),
        worst: &review.gravity_pose,
    }
}

fn kind(joint: JointModel) -> (&'static str, Vec<[f64; 3]>) {
    match joint {
        JointModel::Fixed => ("fixed", vec![]),
        JointModel::Revolute(axis) => ("revolute", vec![axis.to_array()]),
        JointModel::Prismatic(axis) => ("prismatic", vec![axis.to_array()]),
        JointModel::Universal(axes) => ("universal", axes.map(|axis| axis.to_array()).to_vec()),
        JointModel::Spherical => {
            ("spherical", vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        }
        JointModel::Free => ("free", vec![]),
    }
}
