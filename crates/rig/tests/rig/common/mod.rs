//! Helpers of the importers' tests.

use sinew_rig::import::{ImportError, Imported, NoteKind};

#[track_caller]
pub(crate) fn assert_refused(
    result: Result<Imported, ImportError>,
    item: &str,
    expected: &str,
    found: &str,
) {
    let error = result.expect_err("refused");
    assert_eq!(error.item, item, "{error}");
    assert!(error.expected.contains(expected), "{error}");
    assert!(error.found.contains(found), "{error}");
}

#[track_caller]
pub(crate) fn assert_noted(imported: &Imported, kind: NoteKind, words: &str) {
    let told: Vec<String> = imported.notes.iter().map(ToString::to_string).collect();
    let found = imported
        .notes
        .iter()
        .zip(&told)
        .any(|(note, told)| note.kind == kind && told.contains(words));
    assert!(found, "no {kind} with `{words}`: {told:#?}");
}
