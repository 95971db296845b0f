//! Finds the source line of an instruction.

use std::path::Path;

use addr2line::Loader;
use anyhow::{Result, anyhow};

/// The debugging information of an image.
pub(crate) struct Lines(Loader);

/// A place in the source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SourceLine {
    /// Demangled name of the function.
    pub(crate) function: String,
    /// Path of the file, as it was given to the compiler.
    pub(crate) file: String,
    /// Line number from 1; 0 for code without a line.
    pub(crate) line: u32,
}

impl Lines {
    /// Opens the debugging information of an image.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(crate) fn of(image: &Path) -> Result<Self> {
        let loader = Loader::new(image).map_err(|error| anyhow!("{}: {error}", image.display()))?;
        Ok(Self(loader))
    }

    /// Returns the source lines of the instruction at an address: first the innermost function, then those into which
    /// it was inlined. Empty if there is no debugging information.
    pub(crate) fn at(&self, address: u64) -> Vec<SourceLine> {
        let mut places = Vec::new();
        let Ok(mut frames) = self.0.find_frames(address) else { return places };
        while let Ok(Some(frame)) = frames.next() {
            let name = frame.function.and_then(|name| Some(name.raw_name().ok()?.into_owned()));
            let (file, line) =
                frame.location.map_or((None, None), |location| (location.file, location.line));
            places.push(SourceLine {
                function: name.map_or_else(String::new, |name| super::name::demangled(&name)),
                file: file.unwrap_or_default().to_owned(),
                line: line.unwrap_or_default(),
            });
        }
        places
    }
}
