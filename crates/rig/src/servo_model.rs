//! Built-in kinds of servo, from the data files of `crates/rig/models`. Each value names its source or is marked as
//! a guess.

use crate::description::ServoModel;

/// Name and file of each kind of servo, in the order of the documentation.
const FILES: [(&str, &str); 11] = [
    ("XL330-M288-T", include_str!("../models/xl330-m288-t.toml")),
    ("XL430-W250-T", include_str!("../models/xl430-w250-t.toml")),
    ("XM430-W350-T", include_str!("../models/xm430-w350-t.toml")),
    ("MX-28", include_str!("../models/mx-28.toml")),
    ("MX-64", include_str!("../models/mx-64.toml")),
    ("STS3215-7.4V", include_str!("../models/sts3215-7.4v.toml")),
    ("STS3215-12V", include_str!("../models/sts3215-12v.toml")),
    ("SG90", include_str!("../models/sg90.toml")),
    ("MG90S", include_str!("../models/mg90s.toml")),
    ("MG996R", include_str!("../models/mg996r.toml")),
    ("DS3218", include_str!("../models/ds3218.toml")),
];

impl ServoModel {
    /// Returns a built-in kind by name, or `None` if the name is unknown.
    ///
    /// ```
    /// use sinew_rig::description::ServoModel;
    /// let servo = ServoModel::built_in("XL330-M288-T").expect("it is built in");
    /// assert_eq!(servo.stall_torque_nm.value, 0.52);
    /// assert_eq!(servo.stall_torque_nm.source, "ROBOTIS e-manual, at 5 V");
    /// assert!(servo.backlash_rad.is_guess());
    /// ```
    pub fn built_in(name: &str) -> Option<Self> {
        let (_, file) = FILES.iter().find(|(known, _)| *known == name)?;
        // A test ensures that every file is valid.
        toml::from_str(file).ok()
    }

    /// Returns the name of a kind with its article: `an XL330-M288-T`, `a DS3218`.
    pub fn with_article(name: &str) -> String {
        let mut letters = name.chars();
        let (first, second) = (letters.next().unwrap_or_default(), letters.next());
        // In an abbreviation, each letter is pronounced by its name.
        let is_spelt = second.is_none_or(|letter| !letter.is_lowercase());
        let vowels = if is_spelt { "AEFHILMNORSX8" } else { "AEIO" };
        let article = if vowels.contains(first.to_ascii_uppercase()) { "an" } else { "a" };
        format!("{article} {name}")
    }

    /// Returns the names of the built-in kinds.
    pub fn built_in_names() -> impl ExactSizeIterator<Item = &'static str> {
        FILES.iter().map(|(name, _)| *name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn articles_are_those_of_speech() {
        for (name, said) in [
            ("STS3215-12V", "an STS3215-12V"),
            ("XL330-M288-T", "an XL330-M288-T"),
            ("MG90S", "an MG90S"),
            ("DS3218", "a DS3218"),
            ("Savox", "a Savox"),
            ("Agile", "an Agile"),
            ("", "a "),
        ] {
            assert_eq!(ServoModel::with_article(name), said);
        }
    }
}
