//! Writes the text of a mapping.

use std::fmt::Write as _;

use super::{Curve, Entry, Mapping, Performance};
use crate::solve::Limb;

const HEADER: &str = "\
# Which joint of a rig follows which joint of a clip: degrees, metres. What is not listed is not taken.
";

impl Mapping {
    /// Returns the mapping as TOML. Comments contain confidence and reason of each landmark. [`Mapping::read`] returns
    /// the same mapping without confidences and reasons.
    pub fn text(&self) -> String {
        let mut text = String::from(HEADER);
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> std::fmt::Result {
        writeln!(text, "rig = {}\nclip = {}", quoted(&self.rig), quoted(&self.clip))?;
        performance(text, &self.performance)?;
        for entry in &self.landmarks {
            landmark(text, entry)?;
        }
        for item in &self.curves {
            curve(text, item)?;
        }
        Ok(())
    }
}

fn performance(text: &mut String, performance: &Performance) -> std::fmt::Result {
    writeln!(text, "\n[performance]")?;
    let scale = performance.scale.map_or_else(|| quoted("auto"), |scale| format!("{scale:?}"));
    writeln!(
        text,
        "scale = {scale} # metres of the rig for a metre of the performer; auto: by the legs"
    )?;
    writeln!(text, "mirror = {}", performance.mirror)?;
    writeln!(
        text,
        "travels = {} # a free base goes where the performer goes",
        performance.travels
    )?;
    let tilt_deg = performance.tilt_rad.to_degrees();
    writeln!(text, "tilt_deg = {tilt_deg:?} # of a fixed base: 90 lifts what hangs to forward")?;
    let choice = "# both parts alike; \"end\" or \"upper\" first, where a limb has too few joints; \"path\": where the hand is";
    writeln!(text, "arms = {} {choice}", quoted(limb_word(performance.arms)))?;
    writeln!(text, "legs = {}", quoted(limb_word(performance.legs)))?;
    let speed_deg_s = performance.speed_rad_s.to_degrees();
    writeln!(text, "speed_deg_s = {speed_deg_s:?} # of joints whose rig names none")?;
    if let Some(forward) = performance.forward {
        writeln!(text, "forward = {forward:?} # of the rig, every joint at zero, y up")?;
    }
    Ok(())
}

fn landmark(text: &mut String, entry: &Entry) -> std::fmt::Result {
    let reason = entry.reason.replace(char::is_control, " ");
    writeln!(text, "\n[[landmark]] # sure {:.2}. {reason}", entry.confidence)?;
    writeln!(text, "name = {}", quoted(entry.landmark.name()))?;
    if let Some(clip) = &entry.clip {
        writeln!(text, "clip = {}", quoted(clip))?;
    }
    if !entry.rig.is_empty() {
        let names: Vec<String> = entry.rig.iter().map(|name| quoted(name)).collect();
        writeln!(text, "rig = [{}]", names.join(", "))?;
    }
    if let Some(point) = &entry.point {
        let (body, position_m) = (quoted(&point.body), point.position_m);
        writeln!(text, "point = {{ body = {body}, position_m = {position_m:?} }}")?;
    }
    Ok(())
}

fn curve(text: &mut String, curve: &Curve) -> std::fmt::Result {
    writeln!(text, "\n[[curve]]\nclip = {}", quoted(&curve.clip))?;
    writeln!(text, "axis = {:?}\nrig = {}", curve.axis, quoted(&curve.rig))?;
    let key = if curve.slides { "points_m" } else { "points_deg" };
    let points: Vec<String> = curve
        .points
        .iter()
        .map(|[from, to]| {
            let to = if curve.slides { *to } else { to.to_degrees() };
            format!("[{:?}, {to:?}]", from.to_degrees())
        })
        .collect();
    writeln!(text, "{key} = [{}]", points.join(", "))
}

pub(super) fn limb_word(limb: Limb) -> &'static str {
    match limb {
        Limb::Both => "both",
        Limb::End => "end",
        Limb::Upper => "upper",
        Limb::Path => "path",
    }
}

fn quoted(name: &str) -> String {
    toml::Value::String(name.to_owned()).to_string()
}
