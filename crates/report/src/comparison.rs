//! The paper's Figure 4: one posture, held by a figure of other dimensions with two methods until it rests.

use glam::DVec3;
use maud::{Markup, html};
use sinew_evaluation::{Errors, MethodName, Protocol, Run, RunError};
use sinew_figure::FigureMotion;
use sinew_figure::plant::Pose;

use super::chart::{line, px};
use super::scene::{
    Camera, Ground, Mannequin, Points, STAGE_HEIGHT, STAGE_WIDTH, Stage, feet_m, reach_m,
    side_view_rad,
};

/// Time for which the posture is held, in seconds: about 40 time constants of the controller.
const HELD_S: f64 = 3.0;

/// The methods of the paper's Figure 4.
const METHODS: [MethodName; 2] = [MethodName::World, MethodName::LinearCompensation];

/// Indices and names of hands and feet.
const MISSES: [(usize, &str); 4] =
    [(7, "left hand"), (11, "right hand"), (14, "left foot"), (17, "right foot")];

/// One posture of a clip, held by a figure with every method until it rests.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Name of the posture's clip.
    pub clip: String,
    /// Frame of the posture in the clip.
    pub frame: usize,
    /// Factor on the figure's dimensions.
    pub scale: f64,
    mannequin: Mannequin,
    desired: Points,
    results: Vec<PostureResult>,
}

/// The result of holding the posture with one method.
#[derive(Debug, Clone, PartialEq)]
struct PostureResult {
    method: MethodName,
    mannequin: Mannequin,
    points: Points,
    /// Mean errors of the last step, over all bodies and over the leaves.
    errors: Errors,
    /// Distances of hands and feet from their desired positions, in the order of [`MISSES`].
    misses_cm: [f64; 4],
    /// Highest speed of hands and feet during the last step.
    fastest_mm_s: f64,
}

impl Comparison {
    /// Makes a figure of `scale` times the clip's dimensions hold the clip's farthest reach, in the protocol's
    /// setup.
    ///
    /// # Errors
    /// [`RunError`] of the runs.
    pub fn new(motion: &FigureMotion, protocol: &Protocol, scale: f64) -> Result<Self, RunError> {
        let frame = most_outstretched(motion);
        let held = held(motion, frame);
        let mannequin = Mannequin::of_figure(motion);
        let mut desired = None;
        let mut results = Vec::new();
        for method in METHODS {
            let mut last: [Option<(Points, Errors, [DVec3; 4])>; 2] = [None, None];
            let mut misses_cm = [0.0; 4];
            let setup = protocol.setup_of(scale, method);
            let scaled = mannequin.scaled_by(&setup.dimensions.factors());
            Run::new(&held, &setup, None, 0)?.track(|step| {
                let mut errors = Errors::default();
                errors.add_step(&step);
                let points = scaled.points(step.measured);
                let hands_and_feet = MISSES.map(|(body, _)| step.measured[body].position_m);
                misses_cm = MISSES.map(|(body, _)| miss_cm(step.desired, step.measured, body));
                last = [last[1].take(), Some((points, errors, hands_and_feet))];
                desired = Some(mannequin.points(step.desired));
            })?;
            let [Some(before), Some((points, errors, now))] = last else {
                unreachable!("the posture is held for many steps");
            };
            let fastest_mm_s = now
                .iter()
                .zip(&before.2)
                .map(|(now, before)| (*now - *before).length() / held.dt_s * 1000.0)
                .fold(0.0, f64::max);
            results.push(PostureResult {
                method,
                mannequin: scaled,
                points,
                errors,
                misses_cm,
                fastest_mm_s,
            });
        }
        let desired = desired.expect("the posture is held for many steps");
        Ok(Self { clip: motion.name.clone(), frame, scale, mannequin, desired, results })
    }

    /// Describes the picture in words.
    pub(super) fn caption(&self) -> String {
        let rests = self.results.iter().map(|held| held.fastest_mm_s).fold(0.0, f64::max);
        let state = if rests < 1.0 {
            "until it rests".to_owned()
        } else {
            format!("for {HELD_S} s (still moving at {rests:.0} mm/s)")
        };
        format!(
            "Frame {} of clip {}, held {state} by a figure of {} times the clip’s dimensions. White: where the \
             clip has the bodies. Red: where they are, drawn thinner. Yellow: by how much hands and feet miss.",
            self.frame, self.clip, self.scale
        )
    }

    /// Returns one panel per method, each an SVG.
    pub(super) fn panels(&self) -> Vec<Markup> {
        self.results
            .iter()
            .map(|held| {
                html! {
                    svg xmlns="http://www.w3.org/2000/svg" class="chart figure" role="img"
                        viewBox={ "0 0 " (px(STAGE_WIDTH)) " " (px(STAGE_HEIGHT)) } aria-label=(describe(held)) {
                        (self.panel(held))
                    }
                }
            })
            .collect()
    }

    /// Returns all panels side by side as one SVG.
    pub(super) fn picture(&self) -> Markup {
        let gap = 12.0;
        let step = STAGE_WIDTH + gap;
        html! {
            svg xmlns="http://www.w3.org/2000/svg" class="chart" role="img"
                viewBox={ "0 0 " (px(step * self.results.len() as f64 - gap)) " " (px(STAGE_HEIGHT)) }
                aria-label=(self.caption()) {
                @for (index, held) in self.results.iter().enumerate() {
                    g transform={ "translate(" (px(step * index as f64)) " 0)" } { (self.panel(held)) }
                }
            }
        }
    }

    fn panel(&self, held: &PostureResult) -> Markup {
        let stage = Stage {
            id: held.method.as_str(),
            camera: self.camera(),
            ground: Ground::at(feet_m(&self.desired) - 0.03),
            desired: (&self.mannequin, &self.desired),
            measured: (&held.mannequin, &held.points),
        };
        let [angular_deg, linear_cm, ..] = held.errors.all.figures();
        html! {
            (stage.draw())
            text class="stage-title" x="18" y="32" { (held.method.label()) }
            text class="stage-text" x="18" y="52" {
                (format!("mean of all bodies {angular_deg:.1}°, {linear_cm:.1} cm"))
            }
            (self.misses(held, &stage))
        }
    }

    /// Draws yellow lines from the desired to the actual positions of hands and feet, with labels.
    fn misses(&self, held: &PostureResult, stage: &Stage<'_>) -> Markup {
        let ends = |body: usize| [self.desired[body], held.points[body]].map(|at| stage.place(at));
        let texts = MISSES.iter().zip(held.misses_cm).map(|((body, name), miss_cm)| {
            let [from, to] = ends(*body);
            let middle = (0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1));
            (format!("{name} {miss_cm:.1} cm"), middle)
        });
        let labels = stage.labels(texts.collect());
        html! {
            @for (body, _) in MISSES {
                path class="miss" d=(line(ends(body))) {}
            }
            @for label in labels {
                path class="leader" d=(line([label.lead, label.named])) {}
                text class="miss-label" x=(px(label.place.0)) y=(px(label.place.1)) { (label.text) }
            }
        }
    }

    /// Returns a camera in front and slightly aside, with the whole figure in view.
    fn camera(&self) -> Camera {
        let (low, high) =
            self.desired.iter().fold((self.desired[0], self.desired[0]), |(low, high), point| {
                (low.min(*point), high.max(*point))
            });
        // Hands and feet of the larger figure extend farther, and labels need room at the sides.
        let wide_m = 1.5 * (high - low).with_y(0.0).length() * self.scale;
        let size_m = ((high.y - low.y) * 1.25 * self.scale).max(wide_m).max(1.0);
        Camera {
            target_m: 0.5 * (low + high),
            yaw_rad: side_view_rad(&self.desired),
            pitch_rad: 0.14,
            distance_m: 6.0,
            focal: 6.0 * STAGE_HEIGHT / size_m,
            center: [0.5 * STAGE_WIDTH, 0.53 * STAGE_HEIGHT],
        }
    }
}

fn describe(held: &PostureResult) -> String {
    let misses: Vec<String> = MISSES
        .iter()
        .zip(held.misses_cm)
        .map(|((_, name), miss_cm)| format!("{name} {miss_cm:.1} cm"))
        .collect();
    format!("{}: hands and feet miss by: {}", held.method.label(), misses.join(", "))
}

fn miss_cm(desired: &[Pose], measured: &[Pose], body: usize) -> f64 {
    (desired[body].position_m - measured[body].position_m).length() * 100.0
}

/// Returns the frame of the farthest reach.
fn most_outstretched(motion: &FigureMotion) -> usize {
    let reaches = (0..motion.rotation.len()).map(|frame| reach_m(&motion.world_positions_m(frame)));
    farthest(reaches)
}

/// Returns the index of the largest value, the first of equal values.
pub(super) fn farthest(reaches: impl Iterator<Item = f64>) -> usize {
    reaches.enumerate().fold((0, 0.0), |best, one| if one.1 > best.1 { one } else { best }).0
}

/// Returns a clip that holds one frame of another clip.
fn held(motion: &FigureMotion, frame: usize) -> FigureMotion {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hundreds")]
    let frames = (HELD_S / motion.dt_s).ceil() as usize + 3;
    FigureMotion {
        root_position_m: vec![motion.root_position_m[frame]; frames],
        rotation: vec![motion.rotation[frame].clone(); frames],
        ..motion.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_figure::builtin;
    use sinew_figure::fixture::moving;
    use sinew_figure::pipeline::{Settings, prepare};

    #[test]
    fn compensation_brings_hands_and_feet_nearer() {
        let kicks = builtin::clips().into_iter().find(|clip| clip.name == "kicks_01").unwrap();
        let (motion, _) = prepare(kicks, &Settings::default()).unwrap();
        let comparison = Comparison::new(&motion, &Protocol::default(), 1.1).unwrap();
        let [world, compensated] = &comparison.results[..] else { panic!("two methods") };
        for held in [world, compensated] {
            assert!(held.fastest_mm_s < 1.0, "{}: {} mm/s", held.method, held.fastest_mm_s);
        }
        // World keeps the angles; Linear Compensation sacrifices them for the positions.
        assert!(world.errors.all.angular_max_deg() < 0.1);
        assert!(compensated.errors.all.angular_max_deg() > 1.0);
        let mean = |held: &PostureResult| held.misses_cm.iter().sum::<f64>() / 4.0;
        assert!(mean(compensated) < 0.9 * mean(world), "{} {}", mean(compensated), mean(world));
    }

    #[test]
    fn a_figure_of_equal_dimensions_misses_nothing() {
        let comparison = Comparison::new(&moving("clip", 40), &Protocol::default(), 1.0).unwrap();
        for held in &comparison.results {
            assert!(held.misses_cm.iter().all(|miss_cm| *miss_cm < 0.1), "{:?}", held.misses_cm);
        }
    }
}
