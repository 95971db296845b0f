//! Pictures of the auto-encoder's study: reconstructed poses, and errors by group of joints.

use std::io;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use maud::{Markup, html};
use sinew_figure::mapping::{self, Binding};
use sinew_mocap::{Clip, JointSample, Skeleton};
use sinew_report::chart::{self, px};
use sinew_report::file::write_all;
use sinew_report::scene::{
    Camera, Ground, Mannequin, Points, STAGE_HEIGHT, STAGE_WIDTH, Stage, posed, reach_m,
    side_view_rad,
};

use crate::autoencoder::{self, Example, Group, Method, Study};

/// Width and height of a figure in the picture of reconstructions.
const CELL: f64 = 130.0;
const CELL_HEIGHT: f64 = CELL * STAGE_HEIGHT / VIEW_WIDTH;
/// Width of the visible middle of the stage.
const VIEW_WIDTH: f64 = 380.0;
/// Distance between two figures.
const GAP: f64 = 4.0;

/// Writes the pictures of a study on `skeleton` into a folder, as SVG and PNG, and returns their paths: for each
/// number of latent units a chart of errors and the examples.
///
/// # Errors
/// An I/O error.
pub fn write_study(study: &Study, skeleton: &Skeleton, folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut latents: Vec<usize> = study.outcomes.iter().map(|outcome| outcome.latent).collect();
    latents.dedup();
    let mut pictures = Vec::new();
    for latent in latents {
        pictures.push((format!("autoencoder-errors-{latent}"), errors(study, latent)));
        // Only a skeleton that maps to the mannequin can be drawn.
        if let Some(drawn) = reconstructions(study, skeleton, latent) {
            pictures.push((format!("autoencoder-poses-{latent}"), drawn));
        }
    }
    write_all(&pictures, folder)
}

/// Returns the colour class of a method in charts. It is that of a control method, since no chart shows both.
const fn class(method: Method) -> &'static str {
    match method {
        Method::Uniform => "accumulated",
        Method::ForwardKinematics => "local",
        Method::Lengths => "world",
        Method::Cylinders => "linear_compensation",
        Method::Mesh => "manifold_projection",
    }
}

fn errors(study: &Study, latent: usize) -> Markup {
    let methods: Vec<Method> = study.weights.iter().map(|(method, _)| *method).collect();
    let kinds: Vec<_> = methods.iter().map(|method| (class(*method), method.label())).collect();
    let groups = std::iter::once(None).chain(Group::ALL.into_iter().map(Some));
    let rows: Vec<_> = groups
        .map(|group| {
            let values = study.distances_cm(latent, group);
            let values = values.into_iter().map(|(_, distance_cm)| distance_cm).collect();
            (group.map_or("all", Group::as_str), values)
        })
        .collect();
    let title = format!("Mean distance of reconstructed joints, {latent} latent units");
    chart::groups(&title, "cm", &kinds, &rows)
}

/// Draws a row of figures for each example, a column for each method: the original pose as outline, the
/// reconstruction inside.
fn reconstructions(study: &Study, skeleton: &Skeleton, latent: usize) -> Option<Markup> {
    let columns = study.weights.len() as f64;
    let rows = study.examples.len() as f64;
    let drawn = study.examples.iter().map(|example| row(example, skeleton, latent));
    let drawn: Vec<Vec<Cell>> = drawn.collect::<Option<_>>()?;
    let (width, height) = (columns * (CELL + GAP) - GAP, rows * (CELL_HEIGHT + GAP) - GAP);
    Some(html! {
        svg xmlns="http://www.w3.org/2000/svg" class="chart figure" role="img"
            viewBox={ "0 0 " (px(width)) " " (px(height)) }
            aria-label={ "Poses and what networks of " (latent) " latent units make of them" } {
            rect width=(px(width)) height=(px(height)) fill="#ffffff" {}
            @for (line, row) in drawn.iter().enumerate() {
                @for (column, cell) in row.iter().enumerate() {
                    @let x = column as f64 * (CELL + GAP);
                    @let y = line as f64 * (CELL_HEIGHT + GAP);
                    svg x=(px(x)) y=(px(y)) width=(px(CELL)) height=(px(CELL_HEIGHT))
                        viewBox={ (px(0.5 * (STAGE_WIDTH - VIEW_WIDTH))) " 0 " (px(VIEW_WIDTH)) " " (px(STAGE_HEIGHT)) } {
                        (cell.drawn)
                    }
                    @if line == 0 {
                        text class="stage-title" x=(px(x + 9.0)) y=(px(y + 20.0)) { (cell.method.label()) }
                    }
                    text class="stage-text" x=(px(x + 9.0)) y=(px(y + CELL_HEIGHT - 9.0)) {
                        (format!("{:.1} cm", cell.distance_cm))
                    }
                }
            }
        }
    })
}

/// A figure in the picture of reconstructions.
struct Cell {
    method: Method,
    drawn: Markup,
    /// Mean distance of all joints, cm.
    distance_cm: f64,
}

fn row(example: &Example, skeleton: &Skeleton, latent: usize) -> Option<Vec<Cell>> {
    let (mannequin, desired) = figure(skeleton, &example.original)?;
    let lowest = |points: &Points| points.iter().fold(f64::INFINITY, |low, point| low.min(point.y));
    let highest = |points: &Points| points.iter().fold(0.0, |high: f64, point| high.max(point.y));
    let (low, high) = (lowest(&desired), highest(&desired));
    let girth = mannequin.girth();
    // Hands and head have a thickness, and there is text above and below.
    let (upright_m, beside_m) = (high - low + 0.85 * girth, 2.0 * reach_m(&desired) + 0.3 * girth);
    let focal = 6.0 * (STAGE_HEIGHT / upright_m).min(VIEW_WIDTH / beside_m);
    let camera = Camera {
        target_m: DVec3::new(desired[0].x, 0.5 * (low + high), desired[0].z),
        yaw_rad: side_view_rad(&desired),
        pitch_rad: 0.2,
        distance_m: 6.0,
        focal,
        center: [0.5 * STAGE_WIDTH, 0.5 * STAGE_HEIGHT],
    };
    let of_latent = example.reconstructions.iter().filter(|(units, ..)| *units == latent);
    of_latent
        .map(|(_, method, pose)| {
            let (_, measured) = figure(skeleton, pose)?;
            let id = format!("pose-{latent}-{}-{}", example.index, method.as_str());
            let stage = Stage {
                id: &id,
                camera,
                ground: Ground::at(low - 0.04 * girth),
                desired: (&mannequin, &desired),
                measured: (&mannequin, &measured),
            };
            let distance_cm = autoencoder::distance_cm(skeleton, &example.original, pose);
            Some(Cell { method: *method, drawn: stage.draw(), distance_cm })
        })
        .collect()
}

/// Returns the mannequin in a pose, its pelvis at the origin.
fn figure(skeleton: &Skeleton, pose: &[DQuat]) -> Option<(Mannequin, Points)> {
    let binding = Binding::new(mapping::choose(skeleton).ok()?, skeleton).ok()?;
    let samples = skeleton.joints.iter().zip(pose);
    let frame = samples
        .map(|(joint, rotation)| JointSample { rotation: *rotation, position_m: joint.offset_m });
    let motion = binding.map(&Clip {
        name: String::new(),
        skeleton: skeleton.clone(),
        frame_time_s: 1.0,
        frames: vec![frame.collect()],
    });
    Some(posed(&motion, 0))
}
