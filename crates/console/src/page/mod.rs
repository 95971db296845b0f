//! The files of the page, by name, with their content types.

/// All files that the console serves.
pub(crate) const FILES: &[(&str, &str, &[u8])] =
    &[("index.html", "text/html; charset=utf-8", include_bytes!("index.html"))];
