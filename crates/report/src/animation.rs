//! A loop of the playback as a single animated SVG, for places where no script may run.

use glam::DVec3;
use maud::{Markup, PreEscaped, html};

use super::chart::px;
use super::playback::{Playback, Run};
use super::scene::{Camera, Points, STAGE_HEIGHT, STAGE_WIDTH, Stage, gradients};
use super::text::Words;

/// Minimum duration of a loop, in seconds. The next constant is the maximum.
const SHORTEST_S: f64 = 1.2;
const LONGEST_S: f64 = 2.4;

/// Time between two frames, in seconds.
const FRAME_S: f64 = 0.04;

/// Returns the animation of the last run, around the playback's best frame. Returns `None` if there is no run, or the
/// playback is too short for a loop.
pub(super) fn animation(playback: &Playback, words: Words<'_>) -> Option<Markup> {
    let run = playback.runs.last()?;
    let every = frames(FRAME_S, playback.dt_s).max(1);
    let (first, last) = ends(playback, every)?;
    let shown: Vec<usize> = (first..last).step_by(every).collect();
    let view = &playback.view;
    let roots = || shown.iter().map(|frame| playback.desired[*frame][0]);
    let (low, high) = (roots().fold(DVec3::MAX, DVec3::min), roots().fold(DVec3::MIN, DVec3::max));
    let camera = Camera {
        target_m: view.target_m.unwrap_or(0.5 * (low + high)),
        yaw_rad: view.yaw_rad,
        pitch_rad: 0.16,
        distance_m: view.distance_m,
        focal: view.distance_m * STAGE_HEIGHT / (2.6 * view.size_m),
        center: [0.5 * STAGE_WIDTH, 0.53 * STAGE_HEIGHT],
    };
    let stage = |frame: usize| Stage {
        id: "playback",
        camera,
        ground: view.ground,
        desired: (&playback.mannequin, &playback.desired[frame]),
        measured: (&run.mannequin, &run.measured[frame]),
    };
    let dt_s = every as f64 * playback.dt_s;
    let seconds = dt_s * shown.len() as f64;
    let still = nearest(&shown, playback.view.frame);
    Some(html! {
        svg xmlns="http://www.w3.org/2000/svg" class="chart figure" role="img"
            width=(px(STAGE_WIDTH)) height=(px(STAGE_HEIGHT)) viewBox={ "0 0 " (px(STAGE_WIDTH)) " " (px(STAGE_HEIGHT)) }
            aria-label=(caption(playback, run, words)) {
            style { (PreEscaped(style(seconds, shown.len()))) }
            (gradients())
            (stage(shown[0]).backdrop())
            @for (place, frame) in shown.into_iter().enumerate() {
                g class=(if place == still { "moment still" } else { "moment" })
                    style={ "animation-delay:" (format!("{:.2}", dt_s * place as f64 - seconds)) "s" } {
                    (stage(frame).frame())
                }
            }
        }
    })
}

/// Describes the picture in words.
fn caption(playback: &Playback, run: &Run, words: Words<'_>) -> String {
    let (clip, name, method) = (words.clip(), &playback.clip, run.method.label());
    let by = words.follower(run.scale);
    format!(
        "{} {name}, followed with {method} by {by}. White: where the {clip} has the bodies. Red: where they are, \
         drawn thinner.",
        words.clip_title(),
    )
}

/// Returns the style that shows each frame for its share of the loop. A still frame is shown if the reader prefers
/// reduced motion, or if the program does not support animations.
fn style(seconds: f64, moments: usize) -> String {
    format!(
        ".moment{{visibility:hidden;animation:moment {seconds:.2}s step-end infinite}}.still{{visibility:visible}}\
         @keyframes moment{{0%{{visibility:visible}}{:.3}%{{visibility:hidden}}100%{{visibility:hidden}}}}\
         @media (prefers-reduced-motion:reduce){{.moment{{animation:none}}}}.part{{vector-effect:non-scaling-stroke}}",
        100.0 / moments as f64
    )
}

/// Returns the first frame of the loop and the frame after its last. The loop contains the best frame, and its end is
/// as similar as possible to its beginning. `None` if the playback is too short.
fn ends(playback: &Playback, every: usize) -> Option<(usize, usize)> {
    let best = playback.view.frame;
    let [shortest, longest] = [SHORTEST_S, LONGEST_S].map(|s| frames(s, playback.dt_s));
    let difference_m = |a: &Points, b: &Points| -> f64 {
        a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum()
    };
    let firsts = best.saturating_sub(longest)..best;
    let loops = firsts.flat_map(|first| {
        let lasts = (first + shortest).max(best + 1)..(first + longest).min(playback.desired.len());
        lasts
            .filter(move |last| (last - first).is_multiple_of(every))
            .map(move |last| (first, last))
    });
    let off = |&(first, last): &(usize, usize)| {
        difference_m(&playback.desired[first], &playback.desired[last])
    };
    loops.min_by(|a, b| off(a).total_cmp(&off(b)))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hundreds")]
fn frames(seconds: f64, dt_s: f64) -> usize {
    libm::round(seconds / dt_s) as usize
}

fn nearest(frames: &[usize], wanted: usize) -> usize {
    let off = |place: &usize| frames[*place].abs_diff(wanted);
    (0..frames.len()).min_by_key(off).unwrap_or(0)
}
