//! Draws the result of `sinew clip blend`: figures through the transition, the distance map of the clips, and the
//! speed of their joints.

use std::io;
use std::path::Path;

use glam::DVec3;
use maud::{Markup, html};
use sinew_figure::mapping::Binding;
use sinew_figure::{FigureMotion, Mapping};
use sinew_mocap::Clip;
use sinew_pose_metrics::blend::{Blend, Nearest, Pair, Side};
use sinew_pose_metrics::spatial::{
    BODY_COUNT_MAX, Measure, MeasuredPose, Metric, RigMeasure, SpatialRig,
};

use super::chart::{Axis, line, px};
use super::file;
use super::scene::{
    Camera, Ground, Mannequin, Points, STAGE_HEIGHT, STAGE_WIDTH, Stage, posed, reach_m,
    side_view_rad,
};

/// Number of figures in the row.
const FIGURES: usize = 9;
/// Width of a figure's cell. The next constants are its height, and the width of the part of the stage that it
/// shows.
const CELL: f64 = 116.0;
const CELL_HEIGHT: f64 = CELL * STAGE_HEIGHT / VIEW_WIDTH;
const VIEW_WIDTH: f64 = 340.0;
/// Space between two cells.
const GAP: f64 = 4.0;
const WIDTH: f64 = FIGURES as f64 * (CELL + GAP) - GAP;
/// Height of the title and the line below it.
const TOP: f64 = 46.0;
/// Top of the charts. The next constants are the height of their titles, their own height, and the total height.
const CHARTS: f64 = TOP + CELL_HEIGHT + 30.0;
const CHART_TOP: f64 = 24.0;
const CHART: f64 = 280.0;
const HEIGHT: f64 = CHARTS + CHART_TOP + CHART + 78.0;
/// Width of the map. The next constant is the maximum number of cells along a side.
const MAP: f64 = 420.0;
const CELLS: usize = 60;
/// Number of colour steps.
const LEVELS: f64 = 9.0;

/// The content of the drawing.
#[derive(Debug, Clone, Copy)]
pub struct Drawing<'a> {
    /// The two clips.
    pub pair: &'a Pair,
    /// Mapping of their skeleton to the figure; `None` if the skeleton is not human.
    pub mapping: Option<&'a Mapping>,
    /// Names and frame times of the clips in their files.
    pub sides: [Side<'a>; 2],
    /// Nearest pair of frames.
    pub nearest: &'a Nearest,
    /// The blended motion.
    pub blend: &'a Blend,
}

/// Checks that a picture can be written with this name.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] if the name is not `*.svg` or `*.png`.
pub fn check(path: &Path) -> io::Result<()> {
    file::check(path)
}

/// Draws a blend as SVG or PNG, selected by the file's extension.
///
/// # Errors
/// The error of the operating system; [`io::ErrorKind::InvalidInput`] for a file with another extension, or a
/// skeleton that cannot be drawn.
pub fn write(path: &Path, drawing: &Drawing<'_>) -> io::Result<()> {
    let invalid = |error: String| io::Error::new(io::ErrorKind::InvalidInput, error);
    let mapping = drawing.mapping.ok_or_else(|| {
        invalid(
            "expected a human (other skeletons are not drawn), found another skeleton".to_owned(),
        )
    })?;
    let binding = Binding::new(mapping, &drawing.blend.clip.skeleton)
        .map_err(|error| invalid(error.to_string()))?;
    let rig = SpatialRig::<BODY_COUNT_MAX>::sized(drawing.pair.body(), None)
        .map_err(|error| invalid(error.to_string()))?;
    let motion = binding.map(&drawing.blend.clip);
    file::write(path, &drawing.picture(&motion, &rig))
}

impl Drawing<'_> {
    fn picture(&self, motion: &FigureMotion, rig: &SpatialRig<BODY_COUNT_MAX>) -> Markup {
        let [a, b] = self.sides;
        let title = format!("From {} to {}", a.name, b.name);
        let seconds = (self.blend.last - self.blend.first) as f64 * motion.dt_s;
        let way = if self.blend.gave_up > 0 { "joint by joint" } else { "along geodesics" };
        html! {
            svg xmlns="http://www.w3.org/2000/svg" class="chart figure" role="img"
                viewBox={ "0 0 " (px(WIDTH)) " " (px(HEIGHT)) } aria-label=(title) {
                rect width=(px(WIDTH)) height=(px(HEIGHT)) fill="#ffffff" {}
                text class="chart-title" x="4" y="18" { (title) }
                text class="tick" x="4" y="36" {
                    (format!("a blend of {seconds:.2} s {way}, from the first clip (blue) to the second (orange); times from its middle"))
                }
                (self.figures(motion))
                g transform={ "translate(0 " (px(CHARTS)) ")" } { (self.map(rig)) }
                g transform={ "translate(" (px(0.5 * WIDTH)) " " (px(CHARTS)) ")" } { (self.speeds()) }
            }
        }
    }

    /// Draws a row of figures through the blend. The first figure is of the first clip alone, the last figure of the
    /// second clip alone.
    fn figures(&self, motion: &FigureMotion) -> Markup {
        let Blend { first, last, clip, .. } = self.blend;
        let margin = (last - first) / (FIGURES - 3);
        let from = first.saturating_sub(margin);
        let to = (last + margin).min(clip.frames.len() - 1);
        let frames = (0..FIGURES).map(|k| from + k * (to - from) / (FIGURES - 1));
        let cells: Vec<(usize, Mannequin, Points)> = frames
            .map(|frame| {
                let (mannequin, points) = posed(motion, frame);
                (frame, mannequin, points)
            })
            .collect();
        let heights = || cells.iter().flat_map(|(.., points)| points.iter().map(|point| point.y));
        let (low, high) =
            (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
        let reach = cells.iter().map(|(.., points)| reach_m(points)).fold(0.0, f64::max);
        let girth = cells[0].1.girth();
        let (upright_m, beside_m) = (high - low + 0.95 * girth, 2.0 * reach + 0.3 * girth);
        let yaw_rad = side_view_rad(&cells[FIGURES / 2].2);
        let middle = 0.5 * (*first + *last) as f64;
        html! {
            @for (index, (frame, mannequin, points)) in cells.iter().enumerate() {
                @let x = index as f64 * (CELL + GAP);
                @let id = format!("blend-{index}");
                @let camera = Camera {
                    target_m: DVec3::new(points[0].x, 0.5 * (low + high), points[0].z),
                    yaw_rad,
                    pitch_rad: 0.2,
                    distance_m: 6.0,
                    focal: 6.0 * (STAGE_HEIGHT / upright_m).min(VIEW_WIDTH / beside_m),
                    center: [0.5 * STAGE_WIDTH, 0.5 * STAGE_HEIGHT],
                };
                @let figure = (mannequin, points.as_slice());
                @let ground = Ground::at(low - 0.04 * girth);
                @let stage = Stage { id: &id, camera, ground, desired: figure, measured: figure };
                @let share = self.share(*frame);
                @let colors = shades(share);
                svg x=(px(x)) y=(px(TOP)) width=(px(CELL)) height=(px(CELL_HEIGHT))
                    viewBox={ (px(0.5 * (STAGE_WIDTH - VIEW_WIDTH))) " 0 " (px(VIEW_WIDTH)) " " (px(STAGE_HEIGHT)) } {
                    (stage.draw_desired([&colors[0], &colors[1], &colors[2]]))
                }
                text class="stage-title" x=(px(x + 8.0)) y=(px(TOP + 20.0)) { (format!("{:.0} %", 100.0 * share)) }
                text class="stage-text" x=(px(x + 8.0)) y=(px(TOP + CELL_HEIGHT - 9.0)) {
                    (format!("{:+.2} s", (*frame as f64 - middle) * motion.dt_s))
                }
            }
        }
    }

    /// Returns the second clip's share in the pose of a frame.
    fn share(&self, frame: usize) -> f64 {
        let Blend { first, last, .. } = *self.blend;
        let t = (frame as f64 - first as f64) / (last - first) as f64;
        sinew_pose_metrics::blend::least_jerk(t.clamp(0.0, 1.0))
    }

    /// Draws the distances of pairs of frames, at most 60 frames of each clip: the straight-line distance of the
    /// joints.
    fn map(&self, rig: &SpatialRig<BODY_COUNT_MAX>) -> Markup {
        let measuring = RigMeasure::new(rig, Measure::new(Metric::Positions));
        let Pair { a, b, .. } = self.pair;
        let every = [a, b].map(|clip| clip.frames.len().div_ceil(CELLS));
        let poses = |clip: &Clip, every: usize| -> Vec<MeasuredPose<BODY_COUNT_MAX>> {
            let frames = clip.frames.iter().step_by(every);
            let pose = |frame: &Vec<_>| measuring.pose(&self.pair.rotations(frame));
            frames.map(|frame| pose(frame).expect("the solver took it")).collect()
        };
        let (of_a, of_b) = (poses(a, every[0]), poses(b, every[1]));
        let (wide, tall) = (MAP / of_a.len() as f64, CHART / of_b.len() as f64);
        let distance =
            |i: usize, j: usize| f64::from(measuring.position_distance(&of_a[i], &of_b[j]));
        let all = || (0..of_a.len()).flat_map(|i| (0..of_b.len()).map(move |j| (i, j)));
        let (low, high) = all()
            .map(|(i, j)| distance(i, j))
            .fold((f64::INFINITY, 0.0_f64), |(low, high), distance| {
                (low.min(distance), high.max(distance))
            });
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 8")]
        let level = |distance: f64| {
            let share = if high > low { (high - distance) / (high - low) } else { 0.0 };
            (share * LEVELS).min(LEVELS - 1.0) as usize
        };
        // Neighbouring cells of one colour become one rectangle.
        let rows: Vec<Vec<(usize, usize, usize)>> = (0..of_b.len())
            .map(|j| {
                let mut runs: Vec<(usize, usize, usize)> = Vec::new();
                for i in 0..of_a.len() {
                    let level = level(distance(i, j));
                    match runs.last_mut() {
                        Some((same, _, to)) if *same == level => *to = i + 1,
                        _ => runs.push((level, i, i + 1)),
                    }
                }
                runs
            })
            .collect();
        let (left, right, bottom) = (58.0, 58.0 + MAP, CHART_TOP + CHART);
        let at = |i: usize, j: usize| {
            let place = |frame: usize, every: usize| frame as f64 / every as f64 + 0.5;
            (left + wide * place(i, every[0]), bottom - tall * place(j, every[1]))
        };
        let half = (self.blend.last - self.blend.first) / 2;
        let Nearest { a: i, b: j, geodesic_m, .. } = *self.nearest;
        let dt_s = a.frame_time_s;
        let axis = |side: Side<'_>, frames: usize, places: [f64; 2]| {
            let end_s = side.start_s + (frames - 1) as f64 * dt_s;
            Axis::exact([side.start_s, end_s], places)
        };
        let [side_a, side_b] = self.sides;
        let across = axis(side_a, a.frames.len(), [left, right]);
        let up = axis(side_b, b.frames.len(), [bottom, CHART_TOP]);
        let (x, y) = at(i, j);
        html! {
            text class="chart-title" x="4" y="10" { (format!("Distance through space: {low:.2} m (dark) to {high:.2} m")) }
            @for (row, runs) in rows.iter().enumerate() {
                @for (level, from, to) in runs {
                    g class={ "heat heat-" (level) } {
                        rect x=(format!("{:.2}", left + wide * *from as f64)) y=(format!("{:.2}", bottom - tall * (row + 1) as f64))
                            width=(format!("{:.2}", wide * (to - from) as f64 + 0.15)) height=(format!("{:.2}", tall + 0.15)) {}
                    }
                }
            }
            path class="miss" d=(line([at(i - half, j - half), at(i + half, j + half)])) {}
            circle class="miss" cx=(px(x)) cy=(px(y)) r="5" {}
            @for (value, label) in across.ticks() {
                text class="tick" x=(px(across.at(value))) y=(px(bottom + 16.0)) text-anchor="middle" { (label) }
            }
            @for (value, label) in up.ticks() {
                text class="tick" x=(px(left - 7.0)) y=(px(up.at(value) + 4.0)) text-anchor="end" { (label) }
            }
            text class="axis-name" x=(px(left)) y=(px(bottom + 33.0)) { (format!("time in {} (s)", side_a.name)) }
            text class="axis-name" transform={ "translate(14 " (px(bottom)) ") rotate(-90)" } { (format!("time in {} (s)", side_b.name)) }
            text class="axis-name" x=(px(left)) y=(px(bottom + 50.0)) {
                (format!("yellow: the blend, its middle where the geodesic is shortest, {geodesic_m:.3} m"))
            }
        }
    }

    /// Draws the speed of the fastest joint around the blend: in the joined motion, and in both clips alone.
    fn speeds(&self) -> Markup {
        let Blend { first, last, speeds: [all, of_a, of_b], clip, .. } = self.blend;
        let dt_s = clip.frame_time_s;
        let margin = 2 * (last - first);
        let (from, to) = (first.saturating_sub(margin), (last + margin).min(all.len()));
        let middle = 0.5 * (*first + *last) as f64;
        // A step is between two frames.
        let time_s = |step: usize| (step as f64 + 0.5 - middle) * dt_s;
        let highest = all[from..to].iter().chain(of_a).chain(of_b).copied().fold(0.0, f64::max);
        let (left, right) = (46.0, 0.5 * WIDTH - 14.0);
        let (top, bottom) = (CHART_TOP, CHART_TOP + CHART);
        let across = Axis::exact([time_s(from), time_s(to - 1)], [left, right]);
        let up = Axis::from_zero(highest, [bottom, top]);
        let course = |start: usize, speeds: &[f64]| {
            line(
                speeds
                    .iter()
                    .enumerate()
                    .map(|(k, speed)| (across.at(time_s(start + k)), up.at(*speed))),
            )
        };
        let [a, b] = [*first, *last].map(|frame| across.at((frame as f64 - middle) * dt_s));
        html! {
            text class="chart-title" x="4" y="10" { "Speed of the fastest joint (m/s)" }
            rect class="band" x=(px(a)) y=(px(top)) width=(px(b - a)) height=(px(bottom - top)) {}
            @for (value, label) in up.ticks() {
                line class="grid" x1=(px(left)) x2=(px(right)) y1=(px(up.at(value))) y2=(px(up.at(value))) {}
                text class="tick" x=(px(left - 7.0)) y=(px(up.at(value) + 4.0)) text-anchor="end" { (label) }
            }
            @for (value, label) in across.ticks() {
                text class="tick" x=(px(across.at(value))) y=(px(bottom + 16.0)) text-anchor="middle" { (label) }
            }
            path class="reference stroke" style="fill:none" d=(course(from, &all[from..to])) {}
            g class="local" { path class="stroke" d=(course(*first, of_a)) {} }
            g class="world" { path class="stroke" d=(course(*first, of_b)) {} }
            text class="axis-name" x=(px(left)) y=(px(bottom + 33.0)) { "time from the middle of the blend (s)" }
            text class="axis-name" x=(px(left)) y=(px(bottom + 50.0)) {
                "black: the motion; in the blend (grey) also the first clip alone (blue)"
            }
            text class="axis-name" x=(px(left)) y=(px(bottom + 66.0)) { "and the second alone (orange, dashed)" }
        }
    }
}

/// Returns three shades, light to dark, of a colour between the first clip's and the second's.
fn shades(share: f64) -> [String; 3] {
    const FIRST: [[f64; 3]; 3] = [[168.0, 208.0, 255.0], [60.0, 132.0, 214.0], [20.0, 62.0, 118.0]];
    const SECOND: [[f64; 3]; 3] = [[255.0, 214.0, 150.0], [236.0, 142.0, 34.0], [130.0, 66.0, 4.0]];
    std::array::from_fn(|shade| {
        let channels = FIRST[shade].into_iter().zip(SECOND[shade]);
        let mixed = channels.map(|(a, b)| format!("{:.0}", a + share * (b - a)));
        format!("rgb({})", mixed.collect::<Vec<_>>().join(","))
    })
}
