//! A page about the demands of a show on a rig: the moving rig, plots of every joint with its limits, and each
//! excess. The page is a single file and needs no network.

mod data;
mod samples;
mod table;

use std::collections::BTreeSet;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use sinew_performance::text;
use sinew_retarget::feasibility::{CheckError, Limits, Performance, Report};
use sinew_rig::Mechanism;

use super::head::head;
use super::palette;
use data::{Drawn, DrawnDof, Json};

const SCRIPT: &str = concat!(
    include_str!("../rig/assets/kinematics.js"),
    include_str!("../rig/assets/shapes.js"),
    include_str!("../rig/assets/stage.js"),
    include_str!("../rig/assets/data.js"),
    include_str!("../assets/traces.js"),
    include_str!("../assets/draw.js"),
    include_str!("../assets/transport.js"),
    include_str!("assets/show.js"),
    include_str!("assets/plots.js"),
    include_str!("assets/player.js")
);
const STYLE: &str = include_str!("assets/page.css");

/// The content of the page.
#[derive(Debug)]
pub struct Page<'a, P> {
    /// Name of the rig.
    pub rig: &'a str,
    /// Name of the clip.
    pub clip: &'a str,
    /// The rig's mechanism.
    pub mechanism: &'a Mechanism,
    /// Limits of the joints.
    pub limits: &'a Limits,
    /// Peaks of the performance, and its excesses over the limits.
    pub report: &'a Report,
    /// The performance that was checked.
    pub performance: &'a P,
    /// Changes made by a fit, one per line; `None` if there was no fit.
    pub fitted: Option<&'a str>,
    /// Reason why the motion no longer looks like the performer's, if so.
    pub strange: Option<&'a str>,
    /// Further remarks about the show, one per line.
    pub summary: &'a str,
}

impl<P: Performance> Page<'_, P> {
    /// Returns the page as one HTML text that includes all scripts and data. O(duration · bodies).
    ///
    /// # Errors
    /// [`CheckError`] if the rig is larger than the core's capacity, or an instant is invalid for the rig.
    pub fn html(&self) -> Result<String, CheckError> {
        let drawn = Drawn::of(self.mechanism, self.limits, self.report);
        let json = drawn.json(self.mechanism, self.performance)?;
        Ok(self.markup(&drawn, &json).into_string())
    }

    fn markup(&self, drawn: &Drawn<'_>, json: &Json) -> Markup {
        html! {
            (DOCTYPE)
            html lang="en" {
                (head(&format!("{} on {} · Sinew feasibility", self.clip, self.rig), &(palette::page() + STYLE)))
                body class="feasibility" {
                    a class="skip" href="#joints" { "Skip to the joints" }
                    header {
                        p class="eyebrow" { "Sinew " (env!("CARGO_PKG_VERSION")) " · feasibility" }
                        h1 { (self.clip) " on " (self.rig) }
                        p class="lede" { (verdict(drawn, self.strange)) }
                    }
                    main {
                        div class="watch" {
                            (stage(drawn, json.end_s))
                            (plots(drawn))
                        }
                        div class="read" {
                            section aria-labelledby="excesses-title" {
                                h2 id="excesses-title" { "Where limits are exceeded" }
                                (table::excesses(drawn))
                                @if let Some(unknown) = text::unknown(self.mechanism, self.limits, self.report) {
                                    p class="small" { (unknown) }
                                }
                                p class="small" { "Not looked at: collisions, balance, cables." }
                            }
                            section aria-labelledby="joints-title" {
                                h2 id="joints-title" { "Joints" }
                                p class="small" {
                                    "The largest demand on each joint, divided by its limit. "
                                    "Torques are with rotors and friction. Choose a joint to see its plots."
                                }
                                (table::joints(drawn))
                            }
                            (self.show(json))
                        }
                    }
                    noscript { p { "The rig and the plots need JavaScript; nothing is fetched." } }
                    script type="application/json" id="rig-data" { (PreEscaped(&json.rig)) }
                    script type="application/json" id="show-data" { (PreEscaped(&json.show)) }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        }
    }

    /// Writes the section about the show.
    fn show(&self, json: &Json) -> Markup {
        html! {
            section aria-labelledby="show-title" {
                h2 id="show-title" { "The show" }
                ul {
                    @for line in self.summary.lines() { li { (line) } }
                    @for line in notes(json, self.report.duration_s) { li { (line) } }
                }
                @if let Some(fitted) = self.fitted {
                    h3 { "What the fit has done" }
                    ul { @for line in fitted.lines() { li { (line) } } }
                }
            }
        }
    }
}

/// Returns the verdict in one sentence.
fn verdict(drawn: &Drawn<'_>, strange: Option<&str>) -> String {
    let duration_s = drawn.report.duration_s;
    if let Some(why) = strange {
        return format!("Nobody's motion, in {duration_s:.2} s: {why}.");
    }
    if drawn.excesses.is_empty() {
        return format!("No limit is exceeded in {duration_s:.2} s.");
    }
    let joints: BTreeSet<usize> = drawn.excesses.iter().map(|excess| excess.dof).collect();
    let limits: BTreeSet<_> =
        drawn.excesses.iter().map(|excess| (excess.dof, excess.kind)).collect();
    let many =
        |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    format!(
        "In {duration_s:.2} s, {} of {} {} exceeded, {}.",
        many(limits.len(), "limit"),
        many(joints.len(), "joint"),
        if limits.len() == 1 { "is" } else { "are" },
        many(drawn.excesses.len(), "time"),
    )
}

/// Returns notes about data that the page omits.
fn notes(json: &Json, duration_s: f64) -> Vec<String> {
    let mut notes = vec![format!(
        "This page has {:.0} poses a second. Speeds, accelerations and torques in its plots are the largest between \
         them.",
        json.dt_s.recip()
    )];
    if json.end_s < duration_s - json.dt_s {
        notes.push(format!(
            "To stay small, this page shows the first {:.0} s of {duration_s:.0} s. The tables are of all of it.",
            json.end_s
        ));
    }
    notes
}

fn stage(drawn: &Drawn<'_>, end_s: f64) -> Markup {
    let is_known = |of: &DrawnDof<'_>| of.effort.is_finite() || of.continuous.is_finite();
    let known = drawn.dofs.iter().filter(|of| is_known(of)).count();
    html! {
        section class="stage" aria-label="The rig in motion" {
            canvas id="stage" tabindex="0" role="img"
                aria-label="The rig. Arrow keys turn the view, plus and minus zoom." {}
            p class="legend-of-loads" {
                "Torque:"
                @if known > 0 {
                    (key("low", "light")) (key("mid", "half its limit")) (key("high", "at its limit"))
                }
                @if known < drawn.dofs.len() { (key("unknown", "no limit known")) }
                (key("beyond", "beyond any limit now"))
            }
            div class="transport" {
                button id="play" type="button" aria-label="Play" { "▶" }
                div class="track" {
                    input id="scrubber" type="range" aria-label="Time"
                        min="0" max=(format!("{end_s:.3}")) step="0.02" value="0";
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

fn plots(drawn: &Drawn<'_>) -> Markup {
    html! {
        section class="plots" id="plots" aria-labelledby="plots-title" {
            div class="plots-head" {
                h2 id="plots-title" { label for="joint" { "Joint" } }
                select id="joint" {
                    @for (place, dof) in drawn.dofs.iter().enumerate() {
                        option value=(place) { (drawn.limits.dofs[dof.index].name) }
                    }
                }
            }
            div id="charts" {}
        }
    }
}
