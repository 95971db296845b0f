//! Names of shapes, and the viseme of each mouth shape.

/// Names of the 15 visemes.
pub(super) const VISEMES: [&str; 15] =
    ["sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "ih", "oh", "ou"];

/// Visemes of the mouth shapes in Rhubarb's letters, and in the set of Preston Blair, which Papagayo and Rhubarb's .dat
/// use. Both have a shape `E`; Rhubarb's `E` is rounded.
const MOUTHS: [(&str, &str); 9] = [
    ("A", "PP"),
    ("B", "SS"),
    ("C", "E"),
    ("D", "aa"),
    ("E", "oh"),
    ("F", "ou"),
    ("G", "FF"),
    ("H", "nn"),
    ("X", "sil"),
];
const PRESTON_BLAIR: [(&str, &str); 10] = [
    ("AI", "aa"),
    ("E", "E"),
    ("etc", "DD"),
    ("FV", "FF"),
    ("L", "nn"),
    ("MBP", "PP"),
    ("O", "oh"),
    ("U", "ou"),
    ("WQ", "ou"),
    ("rest", "sil"),
];

/// A set of names for mouth shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MouthSet {
    /// Rhubarb's letters.
    Letters,
    /// The set of Preston Blair.
    PrestonBlair,
}

impl MouthSet {
    /// Returns the set that a file uses: Preston Blair's if the file contains a name that only this set has.
    pub(super) fn of<'a>(mut mouths: impl Iterator<Item = &'a str>) -> Self {
        let is_own = |mouth: &str| {
            mouth != "E" && PRESTON_BLAIR.iter().any(|(name, _)| name.eq_ignore_ascii_case(mouth))
        };
        if mouths.any(is_own) { Self::PrestonBlair } else { Self::Letters }
    }

    fn table(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Letters => &MOUTHS,
            Self::PrestonBlair => &PRESTON_BLAIR,
        }
    }

    /// Returns the viseme of a mouth shape, if the set contains the shape.
    pub(super) fn viseme(self, mouth: &str) -> Option<&'static str> {
        let table = self.table().iter();
        table.clone().find(|(name, _)| name.eq_ignore_ascii_case(mouth)).map(|(_, viseme)| *viseme)
    }

    /// Returns the names of all mouth shapes, for messages.
    pub(super) fn names(self) -> String {
        self.table().iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
    }
}

/// Returns whether two names mean the same shape. Only letters and digits count, without case and without the prefix
/// `viseme`; the endings `_L` and `.L` mean `Left`, and `_R` and `.R` mean `Right`.
pub(super) fn is_same(one: &str, other: &str) -> bool {
    one == other || plain(one) == plain(other)
}

fn plain(name: &str) -> String {
    let name = name.trim();
    let side = [("_l", "left"), (".l", "left"), ("_r", "right"), (".r", "right")];
    let lower = name.to_lowercase();
    let lower = side
        .into_iter()
        .find_map(|(end, side)| Some(format!("{}{side}", lower.strip_suffix(end)?)))
        .unwrap_or(lower);
    let lower = lower.strip_prefix("viseme").unwrap_or(&lower);
    lower.chars().filter(|letter| letter.is_alphanumeric()).collect()
}
