//! What a person should know of an import.

use std::collections::BTreeMap;
use std::fmt;

/// One thing that is not in the rig as it is in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// What kind of thing.
    pub kind: NoteKind,
    /// What, in words.
    pub text: String,
    /// Names of what it is about; empty if it is the file as a whole.
    pub items: Vec<String>,
}

/// What was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NoteKind {
    /// Written in another way.
    Changed,
    /// Not in the file, and made up by a rule.
    Filled,
    /// In the file, and not in the rig.
    LeftOut,
    /// Taken as it is; look whether it is true.
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

/// Notes in the making: those of one text become one note with several items.
#[derive(Debug, Default)]
pub(super) struct Notes {
    notes: Vec<Note>,
    places: BTreeMap<(NoteKind, String), usize>,
}

impl Notes {
    /// Of the file as a whole.
    pub(super) fn add(&mut self, kind: NoteKind, text: impl Into<String>) {
        self.entry(kind, text.into());
    }

    /// Of one part of it.
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

/// Names are written out up to this many.
const LISTED_MAX: usize = 12;

/// Names as a person reads them: `` `a`, `b` and 7 more ``.
pub(super) fn list<S: AsRef<str>>(names: &[S]) -> String {
    let shown: Vec<String> =
        names.iter().take(LISTED_MAX).map(|name| format!("`{}`", name.as_ref())).collect();
    match names.len().saturating_sub(LISTED_MAX) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
