//! Writes a proposed map as a mapping file, with comments.

use std::fmt::Write as _;

use sinew_mocap::skeleton_map::End;

use super::FigureMapping;

impl FigureMapping {
    /// Returns the map as a mapping file, with the confidence of each body in comments. Reading it gives the same
    /// map.
    pub fn to_toml(&self) -> String {
        let mut text = String::from(
            "# A proposal for a map on the figure of 18 bodies: read it, edit it, give it with `--mapping`.\n\
             #\n\
             # A body's origin is the joint it hangs on, its frame is that of the joint `rotation`, and `end` is\n\
             # where its segment ends: a joint, { site = J } for the end site of joint J, or\n\
             # { beyond = J, ratio = r } for the bone that ends at J gone on by r times its length.\n\
             # The number before a body is how sure it is, 0 to 1.\n",
        );
        for finding in &self.findings {
            let _ = writeln!(text, "#\n# Note: {}", one_line(finding));
        }
        let _ = writeln!(text, "\nname = {}", quoted(&self.map.name));
        let _ = writeln!(text, "metres_per_unit = {:?}", self.map.metres_per_unit);
        if let Some(rate_hz) = self.map.rate_hz {
            let _ = writeln!(text, "rate_hz = {rate_hz:?}");
        }
        if let Some(up) = self.map.up {
            let _ = writeln!(text, "up = '{up}'");
        }
        text.push_str("\n[signature]\n");
        let signature = &self.map.signature;
        for (key, joints) in [
            ("joints", &signature.joints),
            ("no_joints", &signature.no_joints),
            ("zero_offsets", &signature.zero_offsets),
            ("nonzero_offsets", &signature.nonzero_offsets),
        ] {
            if key == "joints" || !joints.is_empty() {
                let joints =
                    joints.iter().map(|joint| quoted(joint)).collect::<Vec<_>>().join(", ");
                let _ = writeln!(text, "{key} = [{joints}]");
            }
        }
        text.push_str("\n[body]\n");
        for note in &self.notes {
            let Some(part) = self.map.bodies.get(&note.body) else { continue };
            let _ = writeln!(text, "# {:.2}: {}.", note.confidence, one_line(&note.reason));
            for remark in &note.remarks {
                let _ = writeln!(text, "# {}.", one_line(remark));
            }
            let end = match &part.end {
                End::Joint(joint) => quoted(joint),
                End::Site { site } => format!("{{ site = {} }}", quoted(site)),
                End::Beyond { beyond, ratio } => {
                    format!("{{ beyond = {}, ratio = {ratio:?} }}", quoted(beyond))
                }
            };
            let (origin, rotation) = (quoted(&part.origin), quoted(&part.rotation));
            let _ = writeln!(
                text,
                "{} = {{ origin = {origin}, rotation = {rotation}, end = {end} }}",
                note.body
            );
        }
        text
    }
}

/// Returns a string in TOML syntax.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// Replaces control characters, because a comment ends at the end of its line.
fn one_line(text: &str) -> String {
    text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}
