//! Measured numbers by section, row and column.

use std::fmt;

/// Key of a number: `instructions.rnea_free_root.18`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FigureKey {
    /// The counted quantity, with its unit.
    pub(crate) section: String,
    /// Name of the measured code.
    pub(crate) row: String,
    /// Size of the rig, or part of the whole.
    pub(crate) column: String,
}

impl FigureKey {
    pub(crate) fn new(section: &str, row: &str, column: &str) -> Self {
        Self { section: section.to_owned(), row: row.to_owned(), column: column.to_owned() }
    }

    /// Parses the format that [`Display`](fmt::Display) writes.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let [section, row, column] = text.split('.').collect::<Vec<_>>().try_into().ok()?;
        Some(Self::new(section, row, column))
    }
}

impl fmt::Display for FigureKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.section, self.row, self.column)
    }
}

/// Numbers in the order of their measurement.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Figures(Vec<(FigureKey, u64)>);

impl Figures {
    /// Adds a number to the number with the same key, or inserts it.
    pub(crate) fn add(&mut self, place: FigureKey, number: u64) {
        match self.0.iter_mut().find(|(known, _)| *known == place) {
            Some((_, sum)) => *sum += number,
            None => self.0.push((place, number)),
        }
    }

    pub(crate) fn get(&self, place: &FigureKey) -> Option<u64> {
        self.0.iter().find(|(known, _)| known == place).map(|(_, number)| *number)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&FigureKey, u64)> {
        self.0.iter().map(|(place, number)| (place, *number))
    }

    /// Returns the names of sections, of rows or of columns, each once, in order.
    pub(crate) fn names<'a>(
        &'a self,
        name: impl Fn(&'a FigureKey) -> Option<&'a str>,
    ) -> Vec<&'a str> {
        let mut names = Vec::new();
        for name in self.0.iter().filter_map(|(place, _)| name(place)) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }
}

impl Extend<(FigureKey, u64)> for Figures {
    fn extend<I: IntoIterator<Item = (FigureKey, u64)>>(&mut self, more: I) {
        for (place, number) in more {
            self.add(place, number);
        }
    }
}

impl IntoIterator for Figures {
    type Item = (FigureKey, u64);
    type IntoIter = std::vec::IntoIter<Self::Item>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}
