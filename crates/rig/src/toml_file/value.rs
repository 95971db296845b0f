//! Types of values that keys have, with conversion from and to text.

use toml::Value as TomlValue;

use super::error::UnlocatedError;
use super::item::{Item, in_file};
use crate::description::{Base, JointType, ShapeKind, SignalLoss};
use crate::number;

/// A type of a key's value.
pub(super) trait Value: PartialEq + Sized {
    /// Description of a valid value, for messages.
    const EXPECTED: &'static str;

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError>;

    /// Returns the value as text, in degrees if `is_angle`.
    fn text(&self, is_angle: bool) -> String;
}

impl Value for String {
    const EXPECTED: &'static str = "a text in quotes";

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        item.value().as_str().map(str::to_owned).ok_or_else(|| item.wrong(Self::EXPECTED))
    }

    fn text(&self, _: bool) -> String {
        TomlValue::String(self.clone()).to_string()
    }
}

impl Value for f64 {
    const EXPECTED: &'static str = "a number";

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        item.number()
    }

    fn text(&self, is_angle: bool) -> String {
        in_file(&[*self], is_angle).into_iter().map(number::text).collect()
    }
}

impl Value for bool {
    const EXPECTED: &'static str = "true or false";

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        item.value().as_bool().ok_or_else(|| item.wrong(Self::EXPECTED))
    }

    fn text(&self, _: bool) -> String {
        self.to_string()
    }
}

impl Value for u8 {
    const EXPECTED: &'static str = "a whole number from 0 to 255";

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        Self::try_from(item.integer(Self::EXPECTED)?).map_err(|_| item.wrong(Self::EXPECTED))
    }

    fn text(&self, _: bool) -> String {
        self.to_string()
    }
}

impl Value for u16 {
    const EXPECTED: &'static str = "a whole number from 0 to 65535";

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        Self::try_from(item.integer(Self::EXPECTED)?).map_err(|_| item.wrong(Self::EXPECTED))
    }

    fn text(&self, _: bool) -> String {
        self.to_string()
    }
}

impl Value for i8 {
    const EXPECTED: &'static str = "1 or -1";

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        Self::try_from(item.integer(Self::EXPECTED)?).map_err(|_| item.wrong(Self::EXPECTED))
    }

    fn text(&self, _: bool) -> String {
        self.to_string()
    }
}

/// An optional value.
impl<T: Value> Value for Option<T> {
    const EXPECTED: &'static str = T::EXPECTED;

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        T::read(item).map(Some)
    }

    fn text(&self, is_angle: bool) -> String {
        self.as_ref().map_or_else(String::new, |value| value.text(is_angle))
    }
}

impl<const N: usize> Value for [f64; N] {
    const EXPECTED: &'static str = match N {
        2 => "a list of 2 numbers",
        3 => "a list of 3 numbers",
        _ => "a list of 4 numbers",
    };

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        let elements = item.elements(Self::EXPECTED)?;
        let numbers: Vec<f64> = elements.iter().map(f64::read).collect::<Result<_, _>>()?;
        Self::try_from(numbers).map_err(|_| item.wrong(Self::EXPECTED))
    }

    fn text(&self, is_angle: bool) -> String {
        number::list_text(&in_file(self, is_angle))
    }
}

impl<T: Value> Value for Vec<T> {
    const EXPECTED: &'static str = "a list in square brackets";

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        item.elements(Self::EXPECTED)?.iter().map(T::read).collect()
    }

    fn text(&self, is_angle: bool) -> String {
        let texts: Vec<_> = self.iter().map(|value| value.text(is_angle)).collect();
        format!("[{}]", texts.join(", "))
    }
}

/// Ranges of axes: a single pair for one axis, a list of pairs for several.
#[derive(PartialEq)]
pub(super) struct Ranges(pub(super) Vec<[f64; 2]>);

impl Value for Ranges {
    const EXPECTED: &'static str = "[least, most]";

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        let elements = item.elements(Self::EXPECTED)?;
        if elements.iter().any(|element| element.value().is_array()) {
            elements.iter().map(<[f64; 2]>::read).collect::<Result<_, _>>().map(Self)
        } else {
            <[f64; 2]>::read(item).map(|pair| Self(vec![pair]))
        }
    }

    fn text(&self, is_angle: bool) -> String {
        match &self.0[..] {
            [pair] => pair.text(is_angle),
            pairs => pairs.to_vec().text(is_angle),
        }
    }
}

/// A type whose values are a few fixed words.
trait Choice: Copy + PartialEq + 'static {
    const EXPECTED: &'static str;
    const WORDS: &'static [(&'static str, Self)];
}

impl Choice for JointType {
    const EXPECTED: &'static str =
        "\"fixed\", \"revolute\", \"prismatic\", \"universal\", \"spherical\" or \"free\"";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("fixed", Self::Fixed),
        ("revolute", Self::Revolute),
        ("prismatic", Self::Prismatic),
        ("universal", Self::Universal),
        ("spherical", Self::Spherical),
        ("free", Self::Free),
    ];
}

impl Choice for Base {
    const EXPECTED: &'static str = "\"fixed\" or \"driven\"";
    const WORDS: &'static [(&'static str, Self)] =
        &[("fixed", Self::Fixed), ("driven", Self::Driven)];
}

impl Choice for ShapeKind {
    const EXPECTED: &'static str = "\"box\", \"sphere\", \"cylinder\" or \"capsule\"";
    const WORDS: &'static [(&'static str, Self)] = &[
        ("box", Self::Box),
        ("sphere", Self::Sphere),
        ("cylinder", Self::Cylinder),
        ("capsule", Self::Capsule),
    ];
}

impl Choice for SignalLoss {
    const EXPECTED: &'static str = "\"limp\", \"hold\" or \"home\"";
    const WORDS: &'static [(&'static str, Self)] =
        &[("limp", Self::Limp), ("hold", Self::Hold), ("home", Self::Home)];
}

impl<T: Choice> Value for T {
    const EXPECTED: &'static str = <T as Choice>::EXPECTED;

    fn read(item: &Item<'_>) -> Result<Self, UnlocatedError> {
        let word = item.value().as_str();
        let choice = T::WORDS.iter().find(|(name, _)| Some(*name) == word);
        choice.map(|(_, choice)| *choice).ok_or_else(|| item.wrong(<T as Choice>::EXPECTED))
    }

    fn text(&self, _: bool) -> String {
        let word = T::WORDS.iter().find(|(_, choice)| choice == self);
        word.map_or_else(String::new, |(word, _)| format!("\"{word}\""))
    }
}
