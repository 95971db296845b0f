//! Notes of an import for its user.

use std::collections::BTreeMap;
use std::fmt;

/// A difference between the rig and its file, or a doubtful value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// Kind of the note.
    pub kind: NoteKind,
    /// Description in words.
    pub text: String,
    /// Names of the parts that the note applies to; empty for the file as a whole.
    pub items: Vec<String>,
}

/// Kind of a note.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NoteKind {
    /// The rig expresses the value in another way.
    Changed,
    /// The value is missing in the file, and is filled in by a rule.
    Filled,
    /// The value is in the file, but not in the rig.
    LeftOut,
    /// The value is imported unchanged, but may be wrong: check it.
    Doubtful,
}

impl fmt::Display for NoteKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Changed => "changed",
            Self::Filled => "filled",
            Self::LeftOut => "left out",
            Self::Doubtful => "doubtful",
        })
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind, self.text)?;
        if self.items.is_empty() { Ok(()) } else { write!(f, " ({})", list(&self.items)) }
    }
}

/// Collects notes. Notes of equal text become one note with several items.
#[derive(Debug, Default)]
pub(super) struct Notes {
    notes: Vec<Note>,
    places: BTreeMap<(NoteKind, String), usize>,
}

impl Notes {
    /// Adds a note on the file as a whole.
    pub(super) fn add(&mut self, kind: NoteKind, text: impl Into<String>) {
        self.entry(kind, text.into());
    }

    /// Adds a note on one part of the file.
    pub(super) fn add_of(
        &mut self,
        kind: NoteKind,
        text: impl Into<String>,
        item: impl Into<String>,
    ) {
        self.entry(kind, text.into()).items.push(item.into());
    }

    pub(super) fn finish(self) -> Vec<Note> {
        self.notes
    }

    fn entry(&mut self, kind: NoteKind, text: String) -> &mut Note {
        let place = *self.places.entry((kind, text.clone())).or_insert(self.notes.len());
        if place == self.notes.len() {
            self.notes.push(Note { kind, text, items: Vec::new() });
        }
        &mut self.notes[place]
    }
}

/// Maximum number of names in a list.
const LISTED_MAX: usize = 12;

/// Joins names for a message: `` `a`, `b` and 7 more ``.
pub(super) fn list<S: AsRef<str>>(names: &[S]) -> String {
    let shown: Vec<String> =
        names.iter().take(LISTED_MAX).map(|name| format!("`{}`", name.as_ref())).collect();
    match names.len().saturating_sub(LISTED_MAX) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
