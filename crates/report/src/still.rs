//! A still picture in place of the playback, for paper and for readers without scripts.

use maud::{Markup, html};
use sinew_evaluation::MethodName;

use super::chart::px;
use super::playback::Playback;
use super::scene::{Camera, STAGE_HEIGHT, STAGE_WIDTH, Stage};

/// Draws the playback's first frame with the given methods on the rig of one scale.
pub(super) fn still(playback: &Playback, scale: f64, methods: &[MethodName]) -> Markup {
    let view = &playback.view;
    let frame = view.frame;
    let Some(desired) = playback.desired.get(frame) else {
        return html! {};
    };
    let camera = Camera {
        target_m: view.target_m.unwrap_or(desired[0]),
        yaw_rad: view.yaw_rad,
        pitch_rad: 0.22,
        distance_m: view.distance_m,
        focal: view.distance_m * STAGE_HEIGHT / (2.7 * view.size_m),
        center: [0.5 * STAGE_WIDTH, 0.5 * STAGE_HEIGHT],
    };
    html! {
        div class="pair" {
            @for run in playback.runs.iter().filter(|run| run.scale.to_bits() == scale.to_bits() && methods.contains(&run.method)) {
                @let id = format!("still-{}", run.method);
                @let stage = Stage {
                    id: &id,
                    camera,
                    ground: view.ground,
                    desired: (&playback.mannequin, desired),
                    measured: (&run.mannequin, &run.measured[frame]),
                };
                @let [deg, cm, ..] = run.errors[frame];
                svg xmlns="http://www.w3.org/2000/svg" class="chart figure" role="img"
                    viewBox={ "0 0 " (px(STAGE_WIDTH)) " " (px(STAGE_HEIGHT)) }
                    aria-label={ (run.method.label()) " at " (format!("{:.2}", frame as f64 * playback.dt_s)) " s" } {
                    (stage.draw())
                    text class="stage-title" x="18" y="32" { (run.method.label()) }
                    text class="stage-text" x="18" y="52" {
                        (format!("{:.2} s, mean of all bodies {deg:.1}°, {cm:.1} cm", frame as f64 * playback.dt_s))
                    }
                }
            }
        }
    }
}
