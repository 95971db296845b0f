//! Roles of joints in idle life, by their names.

use std::fmt;

/// The role of a joint in idle life.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Closes a lid for a moment.
    Blink,
    /// Turns an eye to the side.
    EyeTurn,
    /// Turns an eye up and down.
    EyeNod,
    /// Turns the head to the side, after the eyes.
    HeadTurn,
    /// Nods the head up and down, after the eyes.
    HeadNod,
    /// Tilts the head towards a shoulder.
    HeadTilt,
    /// Raises a brow at times.
    Brow,
    /// Moves chest or trunk for breathing.
    Breath,
    /// Shifts the weight by hips or waist.
    Weight,
    /// Sways an arm slowly.
    Sway,
    /// Keeps the joint at home.
    Still,
}

/// For each role: the role, its name in `--use`, and words for people.
const NAMES: [(Role, &str, &str); 11] = [
    (Role::Blink, "blink", "blinking"),
    (Role::EyeTurn, "eye-turn", "glances to the side"),
    (Role::EyeNod, "eye-nod", "glances up and down"),
    (Role::HeadTurn, "head-turn", "the head after glances"),
    (Role::HeadNod, "head-nod", "the head after glances, up and down"),
    (Role::HeadTilt, "head-tilt", "tilts of the head"),
    (Role::Brow, "brow", "brows"),
    (Role::Breath, "breath", "breathing"),
    (Role::Weight, "weight", "weight shifts"),
    (Role::Sway, "sway", "sway of arms"),
    (Role::Still, "still", "stays at home"),
];

impl Role {
    /// Returns all roles.
    pub fn all() -> impl Iterator<Item = Self> {
        NAMES.iter().map(|(role, _, _)| *role)
    }

    /// Returns the role with this name, such as `eye-turn`; `None` if there is no such role.
    pub fn named(name: &str) -> Option<Self> {
        NAMES.iter().find(|(_, known, _)| *known == name).map(|(role, _, _)| *role)
    }

    /// Returns the name that `--use` has for the role.
    pub fn name(self) -> &'static str {
        NAMES.iter().find(|(role, _, _)| *role == self).map_or("", |(_, name, _)| name)
    }

    /// Returns the role of a joint by the words of its name; `None` if no word is known.
    pub fn of(joint: &str) -> Option<Self> {
        let words = words(joint);
        let has = |known: &[&str]| words.iter().any(|word| known.contains(&word.as_str()));
        let turns = has(&["turn", "yaw", "pan", "z"]);
        let nods = has(&["nod", "pitch", "tilt", "y"]);
        let rolls = has(&["roll", "x"]);
        if has(&["lid", "lids", "eyelid", "eyelids", "blink"]) {
            Some(Self::Blink)
        } else if has(&["brow", "brows", "eyebrow", "eyebrows"]) {
            Some(Self::Brow)
        } else if has(&["eye", "eyes", "eyeball"]) {
            Some(if nods { Self::EyeNod } else { Self::EyeTurn })
        } else if has(&["head", "neck"]) {
            Some(match (turns, nods) {
                (true, _) => Self::HeadTurn,
                (_, true) => Self::HeadNod,
                _ => Self::HeadTilt,
            })
        } else if has(&["chest", "breath", "spine", "trunk", "bust", "abs", "torso"]) {
            // Nobody breathes by turning to the side.
            Some(if turns { Self::Weight } else { Self::Breath })
        } else if has(&["waist", "pelvis", "weight"]) || (has(&["hip"]) && rolls) {
            Some(Self::Weight)
        } else if has(&["shoulder", "arm", "elbow", "wrist", "bend", "turn"]) {
            Some(Self::Sway)
        } else {
            None
        }
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            NAMES.iter().find(|(role, _, _)| role == self).map_or("", |(_, _, words)| words),
        )
    }
}

/// Returns the words of a name in lower case. A word begins at a capital letter after a lower-case letter, and after
/// any character that is not a letter.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for letter in name.chars() {
        if !letter.is_alphabetic() || (letter.is_uppercase() && was_lower) {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| letter.is_alphabetic()) {
            word.extend(letter.to_lowercase());
        }
        was_lower = letter.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}
