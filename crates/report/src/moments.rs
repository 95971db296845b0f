//! Draws the result of `sinew clip find`: the pose of every moment together with the query's, pelvis on pelvis.

use std::io;
use std::path::Path;

use glam::{DQuat, DVec3};
use maud::{Markup, html};
use sinew_figure::mapping::Binding;
use sinew_mocap::{Clip, JointSample};
use sinew_pose_metrics::find::{Found, Library, Query};
use sinew_pose_metrics::spatial::Measure;

use super::chart::px;
use super::file;
use super::scene::{
    Camera, Ground, Mannequin, Points, STAGE_HEIGHT, STAGE_WIDTH, Stage, WHITE, posed, reach_m,
    side_view_rad,
};

/// Width of a figure's cell. The next constants are its height, and the width of the part of the stage that it
/// shows.
const CELL: f64 = 150.0;
const CELL_HEIGHT: f64 = CELL * STAGE_HEIGHT / VIEW_WIDTH;
const VIEW_WIDTH: f64 = 380.0;
/// Space between two cells.
const GAP: f64 = 4.0;
/// Height of the title and the line below it.
const TOP: f64 = 46.0;
/// Number of cells in a row if moments are poses. The next constant is the number of poses that are shown of a
/// clip.
const COLUMNS: usize = 6;
const OF_CLIP: usize = 6;
/// Maximum number of letters in a cell.
const LETTERS: usize = 17;

/// Checks that a picture can be written with this name.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] if the name is not `*.svg` or `*.png`.
pub fn check(path: &Path) -> io::Result<()> {
    file::check(path)
}

/// Draws the query and the found moments as SVG or PNG, selected by the file's extension. For a pose: the query,
/// then the moments. For a clip: a row of poses for the query and for each moment.
///
/// # Errors
/// The error of the operating system; [`io::ErrorKind::InvalidInput`] for a file with another extension, or a
/// skeleton that cannot be drawn.
pub fn write(
    path: &Path,
    query: &Query,
    library: &Library,
    measure: Measure,
    found: &Found,
) -> io::Result<()> {
    let invalid = |why: String| io::Error::new(io::ErrorKind::InvalidInput, why);
    let mapping = query.mapping.as_ref().ok_or_else(|| {
        invalid(
            "expected a human (other skeletons are not drawn), found another skeleton".to_owned(),
        )
    })?;
    let binding =
        Binding::new(mapping, &query.skeleton).map_err(|error| invalid(error.to_string()))?;
    file::write(path, &picture(&Drawing { query, library, measure, found, binding }))
}

struct Drawing<'a> {
    query: &'a Query,
    library: &'a Library,
    measure: Measure,
    found: &'a Found,
    binding: Binding,
}

/// A cell: the query's figure, the found figure, and texts above and below.
struct Cell {
    query: (Mannequin, Points),
    found: Option<(Mannequin, Points)>,
    above: [String; 2],
    below: String,
}

fn picture(drawing: &Drawing<'_>) -> Markup {
    let Drawing { query, measure, .. } = drawing;
    let cells = drawing.cells();
    let columns = if query.is_pose { COLUMNS.min(cells.len()) } else { drawing.shown().len() };
    let rows = cells.len().div_ceil(columns);
    let width = columns as f64 * (CELL + GAP) - GAP;
    let height = TOP + rows as f64 * (CELL_HEIGHT + GAP) - GAP;
    let title =
        format!("{} moments like {}, by {measure}", drawing.found.moments.len(), query.name);
    let camera = camera(&cells);
    html! {
        svg xmlns="http://www.w3.org/2000/svg" class="chart figure" role="img"
            viewBox={ "0 0 " (px(width)) " " (px(height)) } aria-label=(title) {
            rect width=(px(width)) height=(px(height)) fill="#ffffff" {}
            text class="chart-title" x="4" y="18" { (title) }
            text class="tick" x="4" y="36" {
                "white: the query; red: the moment found, with its pelvis at the same place"
            }
            @for (index, cell) in cells.iter().enumerate() {
                @let x = (index % columns) as f64 * (CELL + GAP);
                @let y = TOP + (index / columns) as f64 * (CELL_HEIGHT + GAP);
                svg x=(px(x)) y=(px(y)) width=(px(CELL)) height=(px(CELL_HEIGHT))
                    viewBox={ (px(0.5 * (STAGE_WIDTH - VIEW_WIDTH))) " 0 " (px(VIEW_WIDTH)) " " (px(STAGE_HEIGHT)) } {
                    (cell.draw(index, camera))
                }
                text class="stage-title" x=(px(x + 8.0)) y=(px(y + 20.0)) { (cell.above[0]) }
                text class="stage-text" x=(px(x + 8.0)) y=(px(y + 37.0)) { (cell.above[1]) }
                text class="stage-text" x=(px(x + 8.0)) y=(px(y + CELL_HEIGHT - 9.0)) { (cell.below) }
            }
        }
    }
}

impl Drawing<'_> {
    fn cells(&self) -> Vec<Cell> {
        let Self { query, library, measure, found, .. } = self;
        let shown = self.shown();
        let time =
            |seconds: f64, frame: usize| format!("{:.2} s", seconds + frame as f64 / query.rate_hz);
        let mut cells = Vec::new();
        for frame in &shown {
            cells.push(Cell {
                query: self.figure(&query.poses[*frame], *frame),
                found: None,
                above: ["query".into(), time(query.start_s, *frame)],
                below: cut(&query.name),
            });
        }
        for moment in &found.moments {
            let clip = &library.clips[moment.clip];
            let seconds = clip.seconds(moment.pose, query.rate_hz);
            let unit = measure.metric.unit();
            for frame in &shown {
                let pose = &clip.poses[moment.pose + frame];
                let is_first = *frame == shown[0];
                let distance = format!("{:.3} {unit}", moment.distance);
                cells.push(Cell {
                    query: self.figure(&query.poses[*frame], *frame),
                    found: Some(self.figure(pose, *frame)),
                    above: [if is_first { distance } else { String::new() }, time(seconds, *frame)],
                    below: if is_first { cut(&clip.name) } else { String::new() },
                });
            }
        }
        // A cell without a distance begins with its time.
        for cell in &mut cells {
            if cell.above[0].is_empty() {
                cell.above.swap(0, 1);
            }
        }
        cells
    }

    /// Returns the query's frames that are drawn.
    fn shown(&self) -> Vec<usize> {
        let last = self.query.poses.len() - 1;
        let count = OF_CLIP.min(last + 1);
        (0..count).map(|k| k * last / (count - 1).max(1)).collect()
    }

    /// Returns a pose with the query's orientation in that frame, since a body's orientation does not count.
    fn figure(&self, pose: &[DQuat], frame: usize) -> (Mannequin, Points) {
        let Query { skeleton, poses, .. } = self.query;
        let mut samples: Vec<JointSample> = skeleton
            .joints
            .iter()
            .zip(pose)
            .map(|(joint, rotation)| JointSample {
                rotation: *rotation,
                position_m: joint.offset_m,
            })
            .collect();
        samples[0] = JointSample { rotation: poses[frame][0], position_m: DVec3::ZERO };
        let motion = self.binding.map(&Clip {
            name: String::new(),
            skeleton: skeleton.clone(),
            frame_time_s: 1.0,
            frames: vec![samples],
        });
        posed(&motion, 0)
    }
}

/// Returns one camera for all cells, at the side of the first figure: all cells have one view.
fn camera(cells: &[Cell]) -> Camera {
    let figures =
        || cells.iter().flat_map(|cell| [Some(&cell.query), cell.found.as_ref()]).flatten();
    let heights = || figures().flat_map(|(_, points)| points.iter().map(|point| point.y));
    let (low, high) =
        (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    let reach = figures().map(|(_, points)| reach_m(points)).fold(0.0, f64::max);
    let (mannequin, points) = &cells[0].query;
    let girth = mannequin.girth();
    // Hands and head are round, and texts need room above and below.
    let (upright_m, beside_m) = (high - low + 0.95 * girth, 2.0 * reach + 0.3 * girth);
    Camera {
        target_m: DVec3::new(points[0].x, 0.5 * (low + high) + 0.04 * girth, points[0].z),
        yaw_rad: side_view_rad(points),
        pitch_rad: 0.2,
        distance_m: 6.0,
        focal: 6.0 * (STAGE_HEIGHT / upright_m).min(VIEW_WIDTH / beside_m),
        center: [0.5 * STAGE_WIDTH, 0.5 * STAGE_HEIGHT],
    }
}

impl Cell {
    fn draw(&self, index: usize, camera: Camera) -> Markup {
        let id = format!("moment-{index}");
        let (mannequin, desired) = &self.query;
        let (found, measured) = self.found.as_ref().unwrap_or(&self.query);
        let both = desired.iter().chain(measured);
        let low = both.fold(f64::INFINITY, |low, point| low.min(point.y));
        let stage = Stage {
            id: &id,
            camera,
            ground: Ground::at(low - 0.04 * mannequin.girth()),
            desired: (mannequin, desired),
            measured: (found, measured),
        };
        if self.found.is_some() { stage.draw() } else { stage.draw_desired(WHITE) }
    }
}

/// Shortens a name to its end if it is too long.
fn cut(name: &str) -> String {
    let count = name.chars().count();
    if count <= LETTERS {
        return name.to_owned();
    }
    format!("…{}", name.chars().skip(count + 1 - LETTERS).collect::<String>())
}
