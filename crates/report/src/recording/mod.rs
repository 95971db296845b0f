//! A page about a recording of `sinew play`: the moving rig, each joint's target, trace, error and torque, and
//! states and faults. The page is a single file and needs no network.

mod rig;
mod table;
mod watch;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use sinew_performance::play::{Recording, RecordingError};
use sinew_rig::{Description, Mechanism};
use thiserror::Error;

use super::head::head;
use super::palette;
pub use rig::RigError;
use rig::{Joint, Rig, joints};
use watch::Watch;

const SCRIPT: &str = concat!(
    include_str!("../rig/assets/kinematics.js"),
    include_str!("../rig/assets/shapes.js"),
    include_str!("../rig/assets/stage.js"),
    include_str!("../rig/assets/data.js"),
    include_str!("../assets/traces.js"),
    include_str!("../assets/draw.js"),
    include_str!("../assets/transport.js"),
    include_str!("assets/plots.js"),
    include_str!("assets/player.js")
);
const STYLE: &str =
    concat!(include_str!("../feasibility/assets/page.css"), include_str!("assets/page.css"));

/// The error of a recording for which there is no page.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PageError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording is of another rig.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The recording does not contain its rate.
    #[error("does not say at what rate it was made")]
    Rate,
}

/// The content of the page.
#[derive(Debug)]
pub struct Page<'a> {
    /// The recording to show.
    pub recording: &'a Recording,
    /// Description of the rig.
    pub rig: &'a Description,
    /// Mechanism of the rig.
    pub mechanism: &'a Mechanism,
}

/// Returns the duration of the complete part of a recording, s.
///
/// # Errors
/// [`PageError::Rate`].
pub fn duration_s(recording: &Recording) -> Result<f64, PageError> {
    Ok(recording.rows() as f64 / rate_hz(recording)?)
}

fn rate_hz(recording: &Recording) -> Result<f64, PageError> {
    let rate_hz = recording.note("rate_hz").and_then(|text| text.parse().ok());
    rate_hz.filter(|hz: &f64| hz.is_finite() && *hz > 0.0).ok_or(PageError::Rate)
}

impl Page<'_> {
    /// Returns the page as one HTML text that includes all scripts and data. O(rows · joints).
    ///
    /// # Errors
    /// [`PageError`].
    pub fn html(&self) -> Result<String, PageError> {
        let joints = joints(self.recording, self.rig, self.mechanism)?;
        let columns = joints.iter().map(|joint| joint.columns).collect();
        let mut watch = Watch::new(columns, self.recording.rows(), rate_hz(self.recording)?);
        for part in self.recording.parts() {
            watch.take(&part?);
        }
        Ok(self.markup(&joints, &watch)?.into_string())
    }

    fn markup(&self, joints: &[Joint], watch: &Watch) -> Result<Markup, PageError> {
        let json = |text: serde_json::Result<String>| {
            text.expect("numbers and names only").replace("</", "<\\/")
        };
        let rig = json(serde_json::to_string(&Rig::of(self.mechanism, joints)));
        let show = json(serde_json::to_string(&watch.show()));
        let show_name = self.recording.note("show").unwrap_or("A show");
        // The name of a file without its folders.
        let name = show_name.rsplit(['/', '\\']).next().unwrap_or(show_name);
        let duration_s = duration_s(self.recording)?;
        Ok(html! {
            (DOCTYPE)
            html lang="en" {
                (head(&format!("{name} on {} · Sinew recording", self.rig.name), &(palette::page() + STYLE)))
                body class="feasibility recording" {
                    a class="skip" href="#joints" { "Skip to the joints" }
                    header {
                        p class="eyebrow" { "Sinew " (env!("CARGO_PKG_VERSION")) " · recording" }
                        h1 { (name) " on " (self.rig.name) }
                        p class="lede" { (verdict(joints, watch, duration_s)) }
                        @if !self.recording.is_whole() { p class="alert" { (cut(duration_s)) } }
                    }
                    main {
                        div class="watch" {
                            (stage(joints, watch))
                            (plots(joints))
                        }
                        div class="read" {
                            section aria-labelledby="course-title" {
                                h2 id="course-title" { "States and faults" }
                                (table::course(watch))
                            }
                            section aria-labelledby="joints-title" {
                                h2 id="joints-title" { "Joints while the show runs" }
                                p class="small" { "Choose a joint to see its plots, its largest error to see when." }
                                (table::joints(joints, watch))
                            }
                            section aria-labelledby="page-title" {
                                h2 id="page-title" { "This page" }
                                ul { @for line in notes(watch, duration_s) { li { (line) } } }
                            }
                        }
                    }
                    noscript { p { "The rig and the plots need JavaScript; nothing is fetched." } }
                    script type="application/json" id="rig-data" { (PreEscaped(&rig)) }
                    script type="application/json" id="show-data" { (PreEscaped(&show)) }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        })
    }
}

/// Returns the notice about a recording that is cut off.
pub fn cut(duration_s: f64) -> String {
    format!("The recording is cut off. Its first {duration_s:.2} s are whole, and shown.")
}

/// Returns the verdict in one sentence.
fn verdict(joints: &[Joint], watch: &Watch, duration_s: f64) -> String {
    let turning = || joints.iter().zip(watch.told()).filter(|(joint, _)| joint.is_followed());
    let ticks: usize = turning().map(|(_, told)| told.ticks).sum();
    let largest = turning().max_by(|(_, a), (_, b)| a.error_most.total_cmp(&b.error_most));
    let followed = match largest {
        Some((joint, told)) if ticks > 0 => format!(
            "While the show ran, joints were {:.2}° from their targets on average, and {:.2}° at most ({} at {:.2} s).",
            (turning().map(|(_, told)| told.error_sum).sum::<f64>() / ticks as f64).to_degrees(),
            told.error_most.to_degrees(),
            joint.name,
            told.error_most_s,
        ),
        _ => "No show ran.".to_owned(),
    };
    let swinging: Vec<&str> = (joints.iter().zip(watch.told()))
        .filter(|(_, told)| told.is_swinging)
        .map(|(joint, _)| joint.name.as_str())
        .collect();
    let swinging = match swinging.as_slice() {
        [] => String::new(),
        many => format!(" It swings at {}.", many.join(", ")),
    };
    let is_fault = |(_, fault): &&(f64, String)| !fault.starts_with("warning");
    let faults = match watch.faults.iter().filter(is_fault).count() {
        0 => "there was no fault".to_owned(),
        1 => "there was one fault".to_owned(),
        many => format!("there were {many} faults"),
    };
    format!("{followed}{swinging} In {duration_s:.2} s {faults}.")
}

fn notes(watch: &Watch, duration_s: f64) -> Vec<String> {
    let mut notes = vec![
        format!(
            "This page has {:.0} poses a second. Errors, torques and currents in its plots are the largest between \
             them.",
            watch.dt_s().recip()
        ),
        "Error is the command of the previous tick minus the value measured after it, as in the controller."
            .to_owned(),
        "The thin lines on the stage are where the rig was sent.".to_owned(),
        "Swing is the largest peak-to-peak change of the error that alternates faster than about 8 times a second. It \
         is bold where the controller warned of it."
            .to_owned(),
    ];
    if watch.end_s() < duration_s - 2.0 * watch.dt_s() {
        notes.push(format!(
            "To stay small, this page shows the first {:.0} s of {duration_s:.0} s. The tables are of all of it.",
            watch.end_s()
        ));
    }
    notes
}

fn stage(joints: &[Joint], watch: &Watch) -> Markup {
    let [half, full] = if joints.iter().any(|joint| joint.slides) {
        ["5° or 5 mm", "10° or 10 mm and more"]
    } else {
        ["5°", "10° and more"]
    };
    html! {
        section class="stage" aria-label="The rig in motion" {
            canvas id="stage" tabindex="0" role="img"
                aria-label="The rig. Arrow keys turn the view, plus and minus zoom." {}
            p class="legend-of-loads" {
                "Error:" (key("low", "none")) (key("mid", half)) (key("high", &format!("{full}, or it swings")))
            }
            div class="transport" {
                button id="play" type="button" aria-label="Play" { "▶" }
                div class="track" {
                    input id="scrubber" type="range" aria-label="Time"
                        min="0" max=(format!("{:.3}", watch.end_s())) step="0.02" value="0";
                    div id="strip" aria-hidden="true" {}
                }
                output id="clock" for="scrubber" { "0.00 s" }
            }
        }
    }
}

fn key(color: &str, text: &str) -> Markup {
    html! { span { span class={ "swatch " (color) } {} (text) } }
}

fn plots(joints: &[Joint]) -> Markup {
    html! {
        section class="plots" id="plots" aria-labelledby="plots-title" {
            div class="plots-head" {
                h2 id="plots-title" { label for="joint" { "Joint" } }
                select id="joint" {
                    @for (place, joint) in joints.iter().enumerate() {
                        option value=(place) { (joint.name) }
                    }
                }
            }
            div id="charts" {}
        }
    }
}

impl Joint {
    /// Returns whether the joint rotates and is moved by a servo. Only these joints count in the mean of all
    /// joints.
    fn is_followed(&self) -> bool {
        !self.slides && self.columns.servo.is_some()
    }
}
