//! Checks that the image contains every public function that boards may call, according to the sources.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::elf::{Elf, Lines, last_part};
use sinew_steps::step;

/// Folders of the code that boards may call, relative to the workspace.
const SOURCES: [&str; 7] = [
    "crates/servo-bus/src",
    "core/src",
    "firmware/src",
    "crates/link/src",
    "dev/bit-parity/src",
    "crates/show/src",
    "crates/storage/src",
];

/// Sources in [`SOURCES`] that are for hosts only.
const OF_HOSTS: [&str; 2] = ["crates/show/src/write/", "crates/show/src/sound.rs"];

/// Folder of the image's sources.
const IMAGE: &str = "dev/audit/src/image";

/// A public function: its file, relative to the workspace, and its name.
type Public = (String, String);

/// Returns the public functions that have no instruction in the image and are not named in its sources. Functions
/// that only return a field do not count.
pub(super) fn left_out(elf: &Elf, lines: &Lines) -> Result<Vec<String>> {
    let mut public = BTreeSet::new();
    for folder in SOURCES {
        for file in rust_files(&step::root().join(folder))? {
            let name = shown(&file);
            if OF_HOSTS.iter().any(|source| name.starts_with(source)) {
                continue;
            }
            public.extend(functions(&read(&file)?).map(|function| (name.clone(), function)));
        }
    }
    let mut named = String::new();
    for file in rust_files(&step::root().join(IMAGE))? {
        named += &read(&file)?;
    }
    let there = in_image(elf, lines);
    Ok(public
        .into_iter()
        .filter(|(file, function)| {
            !there.contains(&(file.clone(), function.clone()))
                && !named.contains(&format!("{function}("))
        })
        .map(|(file, function)| format!("{function} of {file}"))
        .collect())
}

/// Returns the functions with an instruction in the image, inlined or not.
fn in_image(elf: &Elf, lines: &Lines) -> BTreeSet<Public> {
    elf.functions()
        .iter()
        .flat_map(|function| &function.instructions)
        .flat_map(|instruction| lines.at(instruction.address))
        .map(|place| (shown(Path::new(&place.file)), last_part(&place.function).to_owned()))
        .collect()
}

/// Returns the names of the public functions in a source, except those that only return a field, and tests.
fn functions(text: &str) -> impl Iterator<Item = String> + '_ {
    let product = text.split("\n#[cfg(test)]").next().unwrap_or_default();
    product.lines().zip(product.lines().skip(1)).filter_map(|(line, body)| {
        let line = line.trim_start();
        let rest =
            ["pub fn ", "pub const fn "].iter().find_map(|start| line.strip_prefix(start))?;
        let name = rest.split(['(', '<']).next()?;
        let field = body.trim().trim_start_matches('&').strip_prefix("self.");
        let is_accessor = field
            .is_some_and(|field| field.chars().all(|c| c.is_alphanumeric() || "_.".contains(c)));
        (!is_accessor).then(|| name.to_owned())
    })
}

/// Returns all source files in a folder.
fn rust_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let entries = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    for entry in entries {
        let path = entry?.path();
        if path.is_dir() {
            files.extend(rust_files(&path)?);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    Ok(files)
}

fn read(file: &Path) -> Result<String> {
    fs::read_to_string(file).with_context(|| file.display().to_string())
}

/// Returns a file's path relative to the workspace.
fn shown(file: &Path) -> String {
    file.strip_prefix(step::root()).unwrap_or(file).display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn public_functions_are_those_that_do_something() {
        let text = "
impl Tree {
    pub fn len(&self) -> usize {
        self.bodies.len()
    }
    pub fn gains(&self) -> &[Gains] {
        &self.gains
    }
    pub const fn kp(self) -> f32 {
        self.inner.0
    }
    pub(crate) fn hidden() {
    }
    pub const fn new() -> Self {
        Self
    }
    pub fn project<const N: usize>(
        &self,
    ) {}
}

#[cfg(test)]
mod tests {
    pub fn test() {
        1
    }
}";
        assert_eq!(functions(text).collect::<Vec<_>>(), ["len", "new", "project"]);
    }
}
