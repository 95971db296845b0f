//! The option `--layer`, which names a layer and its effect.

use std::path::PathBuf;
use std::str::FromStr;

/// Largest absolute weight of a layer that is added.
const WEIGHT_MOST: f64 = 10.0;
/// Valid forms of the option, for messages.
const EXPECTED: &str = "expected FILE, or FILE:over or FILE:add, then perhaps a weight and joints: \
                        talk.csv:over:0.5:jaw,lid_*";

/// Effect of a layer on the motion below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LayerMode {
    /// The layer replaces the motion of its joints.
    Over,
    /// The distance of the layer's joints from home is added to the motion below.
    Add,
}

/// A layer: a file with a motion of the rig, and the effect of the motion.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerChoice {
    /// Text of the option, for messages.
    pub text: String,
    /// File with the motion.
    pub path: PathBuf,
    /// Effect on the motion below.
    pub mode: LayerMode,
    /// Share of the effect: 1 for the whole effect.
    pub weight: f64,
    /// Names of joints, which may contain `*`; empty for all joints of the file.
    pub joints: Vec<String>,
}

impl FromStr for LayerChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let modes = [(":over", LayerMode::Over), (":add", LayerMode::Add)];
        let found = modes.into_iter().filter_map(|(word, mode)| {
            let at = text.rfind(word)?;
            let rest = &text[at + word.len()..];
            (rest.is_empty() || rest.starts_with(':')).then_some((at, mode, rest))
        });
        let (path, mode, rest) = match found.max_by_key(|(at, ..)| *at) {
            Some((at, mode, rest)) => (&text[..at], mode, rest),
            None => (text, LayerMode::Over, ""),
        };
        let (mut weight, mut joints) = (1.0, Vec::new());
        for part in rest.split(':').skip(1) {
            if let Ok(number) = part.trim().parse::<f64>() {
                let least = if mode == LayerMode::Add { -WEIGHT_MOST } else { 0.0 };
                let most = if mode == LayerMode::Add { WEIGHT_MOST } else { 1.0 };
                if !(least..=most).contains(&number) {
                    return Err(format!("weight: expected {least} to {most}, found {part}"));
                }
                weight = number;
            } else if joints.is_empty() && !part.trim().is_empty() {
                joints = part.split(',').map(|name| name.trim().to_owned()).collect();
            } else {
                return Err(EXPECTED.into());
            }
        }
        if path.is_empty() || joints.iter().any(String::is_empty) {
            return Err(EXPECTED.into());
        }
        Ok(Self { text: text.to_owned(), path: path.into(), mode, weight, joints })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_is_a_file_with_mode_weight_and_joints() {
        let of = |text: &str| text.parse::<LayerChoice>();
        let plain = of("idle.show").unwrap();
        assert_eq!((plain.mode, plain.weight.to_bits()), (LayerMode::Over, 1.0_f64.to_bits()));
        let whole = of("C:\\a\\talk.csv:add:-0.5:jaw, lid_*").unwrap();
        assert_eq!(whole.path, PathBuf::from("C:\\a\\talk.csv"));
        assert_eq!((whole.mode, whole.joints.len()), (LayerMode::Add, 2));
        assert!((whole.weight + 0.5).abs() < 1e-12);
        assert_eq!(of("a.csv:over:jaw").unwrap().joints, ["jaw"]);
        for (wrong, part) in [
            ("a.csv:over:2", "expected 0 to 1"),
            ("a.csv:add:11", "expected -10 to 10"),
            ("a.csv:add:1:jaw:lid", "expected FILE"),
            ("a.csv:add:jaw,", "expected FILE"),
            (":add", "expected FILE"),
        ] {
            assert!(of(wrong).unwrap_err().contains(part), "{wrong}");
        }
    }
}
